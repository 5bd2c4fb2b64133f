//! Clock set-up: 168 MHz from the crystal, or 16 MHz from the internal oscillator.
//!
//! Every wait has a timeout. If the crystal does not start (a fault of a board, and the emulator, whose RCC
//! reads as 0), the chip stays on its internal oscillator. That is slower, allows the same functions, and is
//! accurate to 1 % at room temperature only: enough to report the fault. The register values are computed here
//! and tested on the host, since the emulator never takes this path.

use stairscan::signal::radar::wire::LINK_BAUD;

/// The board's crystal, Hz.
#[cfg(test)]
pub const CRYSTAL_HZ: u32 = 8_000_000;

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

/// Factors of the PLL: VCO = crystal / m × n, core clock = VCO / p.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pll {
    /// Divider of the crystal's clock before the PLL.
    pub m: u32,
    /// Factor from the divided crystal's clock to the VCO.
    pub n: u32,
    /// Divider from the VCO to the core clock: 2, 4, 6 or 8.
    pub p: u32,
    /// Divider from the VCO to the chip's 48 MHz clock.
    pub q: u32,
}

/// PLL factors for 168 MHz: 8 MHz / 4 × 168 / 2.
pub const PLL: Pll = Pll {
    m: 4,
    n: 168,
    p: 2,
    q: 7,
};

impl Pll {
    /// Returns the value of register RCC_PLLCFGR (RM0090 7.3.2) with the crystal as the source.
    pub const fn pllcfgr(self) -> u32 {
        const SOURCE_HSE: u32 = 1 << 22;
        // Bit 29 is reserved and set after reset.
        1 << 29 | self.q << 24 | SOURCE_HSE | (self.p / 2 - 1) << 16 | self.n << 6 | self.m
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

#[cfg(target_os = "none")]
mod apply {
    use super::super::delay::delay_clocks;
    use super::{CFGR, Clocks, FLASH_ACR, HSE, HSI, PLL};
    use stm32f4xx_hal::pac;

    /// Core clocks between two polls: 10 µs at 16 MHz.
    const POLL_CLOCKS: u32 = 160;
    /// Maximum number of polls until the crystal runs: 50 ms, where it needs 2 to 10.
    const CRYSTAL_POLLS: u32 = 5_000;
    /// Maximum number of polls until the PLL has locked (300 µs), and until the core runs from it: 1 ms at 16
    /// MHz.
    const PLL_POLLS: u32 = 100;

    fn wait(polls: u32, mut ready: impl FnMut() -> bool) -> bool {
        (0..polls).any(|_| {
            delay_clocks(POLL_CLOCKS);
            ready()
        })
    }

    /// Starts crystal and PLL if they are ready within their timeouts; returns the resulting clocks.
    pub fn start(rcc: &pac::RCC, flash: &pac::FLASH) -> Clocks {
        rcc.cr().modify(|_, w| w.hseon().set_bit());
        if !wait(CRYSTAL_POLLS, || rcc.cr().read().hserdy().bit_is_set()) {
            rcc.cr().modify(|_, w| w.hseon().clear_bit());
            return HSI;
        }
        // SAFETY: the values are those of the reference manual, checked by this module's tests.
        rcc.pllcfgr().write(|w| unsafe { w.bits(PLL.pllcfgr()) });
        rcc.cr().modify(|_, w| w.pllon().set_bit());
        if !wait(PLL_POLLS, || rcc.cr().read().pllrdy().bit_is_set()) {
            rcc.cr().modify(|_, w| w.pllon().clear_bit());
            return HSI;
        }
        // The flash wait states must be set before the core runs faster.
        // SAFETY: as above.
        flash.acr().write(|w| unsafe { w.bits(FLASH_ACR) });
        // SAFETY: as above.
        rcc.cfgr().write(|w| unsafe { w.bits(CFGR) });
        if wait(PLL_POLLS, || rcc.cfgr().read().sws().is_pll()) {
            // If the crystal stops, the chip switches to its internal oscillator and an interrupt enters the
            // fault path.
            rcc.cr().modify(|_, w| w.csson().set_bit());
            return HSE;
        }
        // SAFETY: 0 is the reset value: HSI, nothing divided.
        rcc.cfgr().write(|w| unsafe { w.bits(0) });
        HSI
    }
}

#[cfg(target_os = "none")]
pub use apply::start;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pll_stays_within_the_data_sheet() {
        let input = CRYSTAL_HZ / PLL.m;
        assert!((950_000..=2_100_000).contains(&input));
        let vco = input * PLL.n;
        assert!((100_000_000..=432_000_000).contains(&vco));
        assert_eq!(vco / PLL.p, HSE.core_hz);
        assert_eq!(vco / PLL.q, 48_000_000);
    }

    #[test]
    fn registers_hold_what_the_reference_manual_says() {
        let field = |value: u32, low: u32, bits: u32| (value >> low) & ((1 << bits) - 1);
        let pll = PLL.pllcfgr();
        assert_eq!(field(pll, 0, 6), 4, "PLLM");
        assert_eq!(field(pll, 6, 9), 168, "PLLN");
        assert_eq!(field(pll, 16, 2), 0, "PLLP: 0 divides by 2");
        assert_eq!(field(pll, 22, 1), 1, "PLLSRC: HSE");
        assert_eq!(field(pll, 24, 4), 7, "PLLQ");
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
