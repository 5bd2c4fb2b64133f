//! Clock set-up: 168 MHz from the crystal, or 16 MHz from the internal oscillator.
//!
//! Every wait has a timeout. If the crystal does not start (a fault of a board, and the emulator, whose RCC
//! reads as 0), the chip stays on its internal oscillator. That is slower, allows the same functions, and is
//! accurate to 1 % at room temperature only: enough to report the fault, and to measure which of the four
//! [`CRYSTALS`] is fitted. The register values are computed here and tested on the host, since the emulator never
//! takes this path.

use stairscan::signal::radar::wire::LINK_BAUD;

/// Clock source of the core, and the chip's frequencies with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clocks {
    /// Name of the source in the sentences `BOOT` and `STAT`.
    pub name: &'static str,
    /// Frequency of the core and the bus AHB, Hz.
    pub core_hz: u32,
    /// Frequency of the peripheral bus APB1 (USART2), Hz.
    pub apb1_hz: u32,
    /// Frequency of the peripheral bus APB2 (USART1), Hz.
    pub apb2_hz: u32,
    /// Frequency of the timers on APB1 (TIM5), Hz: twice that of APB1 wherever that is divided.
    pub timer_hz: u32,
}

impl Clocks {
    /// Returns USART1's divider for a baud rate of the link to the radar module; `None` if the rate is not met
    /// exactly, or is above 1 Mbaud without the crystal: two ends may be at most 2 % apart.
    pub fn link_rate(&self, baud: u32) -> Option<u32> {
        let divider = brr(self.apb2_hz, baud.max(1));
        let steady = baud <= LINK_BAUD || *self == HSE;
        (steady && divider >= 16 && self.apb2_hz == divider * baud).then_some(divider)
    }
}

/// Clocks on the internal oscillator, as after reset.
pub const HSI: Clocks = Clocks {
    name: "hsi-16",
    core_hz: 16_000_000,
    apb1_hz: 16_000_000,
    apb2_hz: 16_000_000,
    timer_hz: 16_000_000,
};

/// Clocks on crystal and PLL.
pub const HSE: Clocks = Clocks {
    name: "hse-168",
    core_hz: 168_000_000,
    apb1_hz: 42_000_000,
    apb2_hz: 84_000_000,
    timer_hz: 84_000_000,
};

/// A crystal, and the factors of the PLL with it: VCO = crystal / m × n = 336 MHz. The core has VCO / [`P`], the
/// chip's 48 MHz clock VCO / [`Q`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crystal {
    /// Frequency, Hz.
    pub hz: u32,
    /// Divider of the crystal's clock before the PLL.
    pub m: u32,
    /// Factor from the divided crystal's clock to the VCO.
    pub n: u32,
}

/// Divider from the VCO to the core clock.
pub const P: u32 = 2;
/// Divider from the VCO to the chip's 48 MHz clock.
pub const Q: u32 = 7;

/// The crystals with which this image runs. The input of the PLL has 2 MHz, which gives the least jitter (RM0090
/// 7.3.2), but 1 MHz with 25 MHz.
pub const CRYSTALS: [Crystal; 4] = [
    Crystal::of(8, 4, 168),
    Crystal::of(12, 6, 168),
    Crystal::of(16, 8, 168),
    Crystal::of(25, 25, 336),
];

/// Divider of the crystal's clock to HSE_RTC, the input of timer TIM11 in a measurement: the largest of RTCPRE.
const RTC_DIVIDER: u32 = 31;
/// Number of periods of HSE_RTC from one capture to the next: the largest prescaler of a capture.
const PERIODS: u32 = 8;
/// Number of intervals between captures of one measurement: a timer clock at its ends is 0.1 % at most.
const INTERVALS: u32 = 8;
/// Minimum of a measurement, percent of a crystal's: the internal oscillator, by which the timer counts, is 8 % slow
/// at most from -40 to 105 °C (DS8626, HSI oscillator characteristics).
const LEAST_PERCENT: u32 = 91;
/// Maximum of a measurement, percent of a crystal's: the internal oscillator is 4.5 % fast at most (as above).
const MOST_PERCENT: u32 = 105;

impl Crystal {
    /// Fields of register RCC_PLLCFGR: PLLM, PLLN, PLLP, PLLSRC, PLLQ. The others are reserved.
    pub const PLL_FIELDS: u32 = 0b1111 << 24 | 1 << 22 | 0b11 << 16 | 0x1ff << 6 | 0x3f;

    const fn of(mhz: u32, m: u32, n: u32) -> Self {
        let hz = mhz * 1_000_000;
        Self { hz, m, n }
    }

    /// Returns the fields of register RCC_PLLCFGR (RM0090 7.3.2) with the crystal as the source.
    pub const fn pllcfgr(self) -> u32 {
        const SOURCE_HSE: u32 = 1 << 22;
        Q << 24 | SOURCE_HSE | (P / 2 - 1) << 16 | self.n << 6 | self.m
    }

    /// Returns the number of clocks of an exact internal oscillator in a measurement of this crystal.
    const fn clocks(self) -> u32 {
        const KHZ: u32 = 1_000;
        HSI.timer_hz / KHZ * (RTC_DIVIDER * PERIODS * INTERVALS) / (self.hz / KHZ)
    }

    /// Returns the crystal of a measurement, `clocks` of the internal oscillator; `None` if it is none of the four.
    pub fn measured(clocks: u32) -> Option<Self> {
        let near = |crystal: &Self| {
            let nominal = crystal.clocks();
            let percent = nominal * LEAST_PERCENT..=nominal * MOST_PERCENT;
            percent.contains(&clocks.saturating_mul(100))
        };
        CRYSTALS.into_iter().find(near)
    }
}

/// Value of register RCC_CFGR (RM0090 7.3.3): PLL as system clock, AHB /1, APB1 /4, APB2 /2.
pub const CFGR: u32 = 0b100 << 13 | 0b101 << 10 | 0b10;

/// Value of register FLASH_ACR (RM0090 3.9.2): 5 wait states for 168 MHz at 3.3 V, prefetch and both caches.
pub const FLASH_ACR: u32 = 1 << 10 | 1 << 9 | 1 << 8 | 5;

/// Returns the divider for register USART_BRR at `baud`: with 16-fold oversampling it is the quotient, rounded.
pub const fn brr(bus_hz: u32, baud: u32) -> u32 {
    (bus_hz + baud / 2) / baud
}

/// Returns the baud rate to request from the HAL's serial port so that it sets the divider `brr`: the HAL assumes
/// the clocks as after reset, since not it but this module has set them up.
pub const fn hal_baud(brr: u32) -> u32 {
    (HSI.apb1_hz + brr / 2) / brr
}

/// Returns the value of a timer's prescaler for the frequency `tick_hz` of its ticks.
pub const fn prescaler(timer_hz: u32, tick_hz: u32) -> u32 {
    timer_hz / tick_hz - 1
}

/// Writes the registers.
#[cfg(target_os = "none")]
pub mod apply {
    use super::super::delay::delay_clocks;
    use super::{CFGR, Clocks, Crystal, FLASH_ACR, HSE, HSI, INTERVALS, RTC_DIVIDER};
    use stm32f4xx_hal::pac;

    /// Core clocks between two polls: 10 µs at 16 MHz.
    const POLL_CLOCKS: u32 = 160;
    /// Maximum number of polls until the crystal runs: 50 ms, where it needs 2 to 10.
    const CRYSTAL_POLLS: u32 = 5_000;
    /// Maximum number of polls until the PLL has locked (300 µs), and until the core runs from it: 1 ms at 16
    /// MHz.
    const PLL_POLLS: u32 = 100;
    /// Maximum number of polls until the next capture, each several clocks long: the slowest crystal that the chip
    /// allows (4 MHz) makes one in 1,000 clocks.
    const CAPTURE_POLLS: u32 = 1_000;
    /// Value of RMP in register TIM11_OR (RM0090 19.5.11): the timer's input is HSE_RTC.
    const INPUT_HSE_RTC: u8 = 0b10;
    /// Flag CC1OF of register TIM11_SR: a capture was overwritten before it was read.
    const OVERWRITTEN: u32 = 1 << 9;

    fn wait(polls: u32, mut ready: impl FnMut() -> bool) -> bool {
        (0..polls).any(|_| {
            delay_clocks(POLL_CLOCKS);
            ready()
        })
    }

    /// Starts crystal and PLL if they are ready within their timeouts; returns the resulting clocks. The timer
    /// measures the crystal and is as after a reset then.
    pub fn start(rcc: &pac::RCC, flash: &pac::FLASH, timer: &pac::TIM11) -> Clocks {
        rcc.cr().modify(|_, w| w.hseon().set_bit());
        let runs = wait(CRYSTAL_POLLS, || rcc.cr().read().hserdy().bit_is_set());
        let clocks = match runs {
            true => measure(rcc, timer),
            false => None,
        };
        let crystal = clocks.and_then(Crystal::measured);
        if crystal.is_some_and(|crystal| switch(rcc, flash, crystal)) {
            // If the crystal stops, the chip switches to its internal oscillator and an interrupt enters the
            // fault path.
            rcc.cr().modify(|_, w| w.csson().set_bit());
            return HSE;
        }
        stop(rcc, flash);
        HSI
    }

    /// Returns the clocks of the internal oscillator, from which the core runs, during a measurement of the crystal
    /// (RM0090 7.2.11); `None` if captures are missing. It takes 0.5 ms at most.
    fn measure(rcc: &pac::RCC, timer: &pac::TIM11) -> Option<u32> {
        rcc.apb2enr().modify(|_, w| w.tim11en().set_bit());
        // The clock comes two clocks behind the write (ES0182): this read waits for them.
        rcc.apb2enr().read();
        // SAFETY: a divider in a field of five bits.
        rcc.cfgr()
            .modify(|_, w| unsafe { w.rtcpre().bits(RTC_DIVIDER as u8) });
        // SAFETY: an input of the reference manual in a field of two bits.
        timer
            .or()
            .modify(|_, w| unsafe { w.rmp().bits(INPUT_HSE_RTC) });
        timer.arr().write(|w| w.arr().set(u16::MAX));
        timer
            .ccmr1_input()
            .write(|w| w.cc1s().ti1().ic1psc().eight_events());
        timer.ccer().write(|w| w.cc1e().set_bit());
        timer.cr1().write(|w| w.cen().set_bit());
        let clocks = intervals(timer);
        rcc.apb2rstr().modify(|_, w| w.tim11rst().set_bit());
        rcc.apb2rstr().modify(|_, w| w.tim11rst().clear_bit());
        rcc.apb2enr().modify(|_, w| w.tim11en().clear_bit());
        // SAFETY: 0, as after a reset: HSE_RTC does not run.
        rcc.cfgr().modify(|_, w| unsafe { w.rtcpre().bits(0) });
        clocks
    }

    /// Returns the timer's clocks from one capture to the last of [`INTERVALS`] further ones.
    fn intervals(timer: &pac::TIM11) -> Option<u32> {
        let capture = || {
            let came = (0..CAPTURE_POLLS).any(|_| timer.sr().read().cc1if().bit_is_set());
            // Reading the capture clears its flag.
            came.then(|| timer.ccr1().read().ccr().bits())
        };
        let first = capture()?;
        let mut last = first;
        for _ in 0..INTERVALS {
            last = capture()?;
        }
        let whole = timer.sr().read().bits() & OVERWRITTEN == 0;
        whole.then(|| u32::from(last.wrapping_sub(first)))
    }

    /// Starts the PLL and switches the core to it; returns whether the core runs from it.
    fn switch(rcc: &pac::RCC, flash: &pac::FLASH, crystal: Crystal) -> bool {
        // SAFETY: the values are those of the reference manual, checked by this module's tests; reserved bits stay.
        rcc.pllcfgr()
            .modify(|r, w| unsafe { w.bits(r.bits() & !Crystal::PLL_FIELDS | crystal.pllcfgr()) });
        rcc.cr().modify(|_, w| w.pllon().set_bit());
        if !wait(PLL_POLLS, || rcc.cr().read().pllrdy().bit_is_set()) {
            return false;
        }
        // The core may run faster only once the wait states read back (RM0090 3.5.1).
        // SAFETY: as above.
        flash.acr().write(|w| unsafe { w.bits(FLASH_ACR) });
        if flash.acr().read().bits() != FLASH_ACR {
            return false;
        }
        // SAFETY: as above.
        rcc.cfgr().write(|w| unsafe { w.bits(CFGR) });
        wait(PLL_POLLS, || rcc.cfgr().read().sws().is_pll())
    }

    /// Leaves the clocks as a reset does.
    pub fn stop(rcc: &pac::RCC, flash: &pac::FLASH) {
        // SAFETY: 0 is the reset value (RM0090 7.3.3): the internal oscillator, nothing divided.
        rcc.cfgr().write(|w| unsafe { w.bits(0) });
        let slow = wait(PLL_POLLS, || rcc.cfgr().read().sws().is_hsi());
        rcc.cr().modify(|_, w| {
            w.csson()
                .clear_bit()
                .pllon()
                .clear_bit()
                .hseon()
                .clear_bit()
        });
        if slow {
            // SAFETY: 0 is the reset value (RM0090 3.9.1): no wait states, which 16 MHz do not need.
            flash.acr().write(|w| unsafe { w.bits(0) });
        }
    }
}

#[cfg(target_os = "none")]
pub use apply::start;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_crystal_gives_the_same_clocks_within_the_data_sheet() {
        for crystal in CRYSTALS {
            let input = crystal.hz / crystal.m;
            assert_eq!(input * crystal.m, crystal.hz);
            assert!((1_000_000..=2_000_000).contains(&input), "{crystal:?}");
            assert!((50..=432).contains(&crystal.n), "{crystal:?}");
            let vco = input * crystal.n;
            assert_eq!(vco / P, HSE.core_hz, "{crystal:?}");
            assert_eq!(vco, 48_000_000 * Q, "{crystal:?}");
        }
    }

    /// Clocks of an internal oscillator of `hsi` MHz in a measurement of a crystal of `mhz`, `rest` clocks off.
    fn clocks(mhz: f64, hsi: f64, rest: f64) -> u32 {
        (f64::from(RTC_DIVIDER * PERIODS * INTERVALS) / mhz * hsi + rest) as u32
    }

    #[test]
    fn a_crystal_is_known_at_every_temperature() {
        for (mhz, crystal) in [8.0, 12.0, 16.0, 25.0].into_iter().zip(CRYSTALS) {
            for percent in [92.0, 96.0, 99.0, 100.0, 101.0, 104.0, 104.5] {
                for rest in [-2.0, 0.0, 2.0] {
                    let clocks = clocks(mhz, 0.16 * percent, rest);
                    let found = Crystal::measured(clocks);
                    assert_eq!(found, Some(crystal), "{mhz} MHz at {percent} %");
                }
            }
        }
    }

    /// Those in the middle between two of the four; at no temperature is one taken for another.
    #[test]
    fn other_crystals_are_none_of_the_four() {
        for mhz in [4.0, 6.0, 7.0, 10.0, 14.0, 19.0, 20.0] {
            for percent in [92.0, 100.0, 104.5] {
                let clocks = clocks(mhz, 0.16 * percent, 0.0);
                assert_eq!(Crystal::measured(clocks), None, "{mhz} MHz at {percent} %");
            }
        }
        for clocks in [0, 1, u32::from(u16::MAX)] {
            assert_eq!(Crystal::measured(clocks), None);
        }
    }

    #[test]
    fn registers_hold_what_the_reference_manual_says() {
        let field = |value: u32, low: u32, bits: u32| (value >> low) & ((1 << bits) - 1);
        let factors = [(4, 168), (6, 168), (8, 168), (25, 336)];
        for (crystal, (m, n)) in CRYSTALS.into_iter().zip(factors) {
            let pll = crystal.pllcfgr();
            assert_eq!(pll & !Crystal::PLL_FIELDS, 0);
            assert_eq!(field(pll, 0, 6), m, "PLLM");
            assert_eq!(field(pll, 6, 9), n, "PLLN");
            assert_eq!(field(pll, 16, 2), 0, "PLLP: 0 divides by 2");
            assert_eq!(field(pll, 22, 1), 1, "PLLSRC: HSE");
            assert_eq!(field(pll, 24, 4), 7, "PLLQ");
        }
        assert_eq!(field(CFGR, 0, 2), 2, "SW: PLL");
        assert_eq!(field(CFGR, 4, 4), 0, "HPRE: not divided");
        assert_eq!(field(CFGR, 10, 3), 0b101, "PPRE1: /4");
        assert_eq!(field(CFGR, 13, 3), 0b100, "PPRE2: /2");
        assert_eq!(HSE.core_hz / 4, HSE.apb1_hz);
        assert_eq!(HSE.core_hz / 2, HSE.apb2_hz);
        assert_eq!(HSE.apb1_hz * 2, HSE.timer_hz);
        assert_eq!(field(FLASH_ACR, 0, 3), 5, "LATENCY");
        assert_eq!(
            field(FLASH_ACR, 8, 3),
            7,
            "prefetch, instruction and data cache"
        );
        const { assert!(HSE.apb1_hz <= 42_000_000 && HSE.apb2_hz <= 84_000_000) };
    }

    #[test]
    fn the_link_goes_up_on_the_crystal_only() {
        let rates = [
            1_000_000, 2_000_000, 3_000_000, 2_500_000, 4_000_000, 6_000_000, 0,
        ];
        let dividers = |clocks: Clocks| rates.map(|baud| clocks.link_rate(baud));
        let [one, two, three, none @ ..] = dividers(HSE);
        assert_eq!([one, two, three], [Some(84), Some(42), Some(28)]);
        // 6 Mbaud would leave 14 clocks to a bit, less than one period of oversampling.
        assert_eq!(none, [None, Some(21), None, None]);
        assert_eq!(
            dividers(HSI),
            [Some(16), None, None, None, None, None, None]
        );
    }

    #[test]
    fn both_clocks_hit_the_baud_rates() {
        for clocks in [HSI, HSE] {
            let exact = brr(clocks.apb2_hz, 1_000_000);
            assert_eq!(clocks.apb2_hz, exact * 1_000_000, "{}", clocks.name);
            assert!(exact >= 16, "less than one period of oversampling");
            let report = brr(clocks.apb1_hz, 115_200);
            for divider in [exact, report] {
                // As stm32f4xx-hal's `calculate_brr` has it for 16-fold oversampling.
                assert_eq!(
                    brr(HSI.apb1_hz, hal_baud(divider)),
                    divider,
                    "{}",
                    clocks.name
                );
            }
            let error = f64::from(clocks.apb1_hz) / f64::from(report) / 115_200.0 - 1.0;
            assert!(error.abs() < 0.005, "{}: {error}", clocks.name);
            let division = prescaler(clocks.timer_hz, 1_000_000) + 1;
            assert_eq!(division * 1_000_000, clocks.timer_hz);
        }
    }
}
