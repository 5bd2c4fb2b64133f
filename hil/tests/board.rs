//! Tests on the board: clock, flash, watchdog, STEP pulses, report port. Each begins with a reset.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("the tests of hil run on the chip: `cargo hil`");
}

#[cfg(target_os = "none")]
#[embedded_test::tests(default_timeout = 10)]
mod tests {
    use core::cell::RefCell;
    use core::ops::RangeInclusive;

    use cortex_m::peripheral::{DWT, SYST};
    use critical_section::Mutex;
    use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
    use hil::clock::{self, Clocks, HSE, brr, hal_baud};
    use hil::controller::Chip;
    use hil::flash::Sectors;
    use hil::motor::{Motor, Pins};
    use hil::settings_flash::ByClock;
    use hil::time::{self, Time};
    use stairscan::scanner::mirror::StepPort;
    use stairscan::scanner::ramp::Ramp;
    use stairscan::scanner::settings::{DriverConfig, WireLevel};
    use stm32f4xx_hal::pac;
    use stm32f4xx_hal::prelude::*;
    use stm32f4xx_hal::rcc::{Enable, Rcc};
    use stm32f4xx_hal::serial::{Config, Serial};
    use stm32f4xx_hal::watchdog::IndependentWatchdog;

    /// Size of the free sector at the end of the flash, bytes.
    const SECTOR: usize = 128 * 1024;
    /// Address and number of the free sector (boot/src/layout.rs).
    const FREE: (u32, u32) = (0x080e_0000, 11);
    /// Timeout of the watchdog in the image, ms.
    const WATCHDOG_MS: u32 = 2_000;
    /// Speed of the STEP test, microsteps/s.
    const SPEED: u32 = 25_600;
    /// Baud rate of the report port.
    const BAUD: u32 = 115_200;

    /// The chip after the set-up that the image begins with: clocks, and the timer of microseconds.
    struct Board {
        clocks: Clocks,
        rcc: Rcc,
        time: Time,
        systick: SYST,
        iwdg: pac::IWDG,
        usart2: pac::USART2,
        gpio: (pac::GPIOA, pac::GPIOB, pac::GPIOC),
        exti: pac::EXTI,
    }

    static MOTOR: Mutex<RefCell<Option<Motor>>> = Mutex::new(RefCell::new(None));

    #[cortex_m_rt::exception]
    fn SysTick() {
        critical_section::with(|cs| {
            if let Some(motor) = MOTOR.borrow_ref_mut(cs).as_mut() {
                motor.tick();
            }
        });
    }

    #[init]
    fn init() -> Board {
        let (p, core) = (pac::Peripherals::take(), cortex_m::Peripherals::take());
        let (p, mut core) = (p.unwrap(), core.unwrap());
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
        let clocks = clock::start(&p.RCC, &p.FLASH, &p.TIM11);
        let mut rcc = p.RCC.constrain();
        pac::TIM5::enable(&mut rcc);
        Board {
            clocks,
            rcc,
            time: time::start(p.TIM5, &clocks),
            systick: core.SYST,
            iwdg: p.IWDG,
            usart2: p.USART2,
            gpio: (p.GPIOA, p.GPIOB, p.GPIOC),
            exti: p.EXTI,
        }
    }

    fn assert_within(value: u32, range: RangeInclusive<u32>) {
        assert!(range.contains(&value), "{value} is not within {range:?}");
    }

    /// Waits `us` µs by the timer of the image; returns the core clocks that passed.
    fn clocks_in(time: &Time, us: u32) -> u32 {
        let (begun, first) = (time.now(), DWT::cycle_count());
        while time.now().since(begun) < us {}
        DWT::cycle_count().wrapping_sub(first)
    }

    /// The crystal runs, and core and timer have the frequencies that the drivers compute with. The image itself compares
    /// the crystal with the internal oscillator at boot.
    #[test]
    fn the_core_runs_at_168_mhz(board: Board) {
        assert_eq!(board.clocks, HSE);
        assert_within(clocks_in(&board.time, 10_000), 1_679_500..=1_680_500);
    }

    /// The image's driver erases a sector, writes and reads back, in a sector that nothing uses.
    #[test]
    fn flash_is_erased_written_and_read_back(_board: Board) {
        let (address, number) = FREE;
        let mut flash = Sectors::<Chip<ByClock>, SECTOR, 1>::new(Chip(ByClock), address, number);
        let mut found = [0; 64];
        flash.erase(0, SECTOR as u32).unwrap();
        for at in (0..SECTOR as u32).step_by(found.len()) {
            flash.read(at, &mut found).unwrap();
            assert_eq!(found, [0xff; 64], "erased at {at}");
        }
        let written = core::array::from_fn(|k| (k * 37) as u8);
        for at in [0, SECTOR as u32 - 64] {
            flash.write(at, &written).unwrap();
            flash.read(at, &mut found).unwrap();
            assert_eq!(found, written, "written at {at}");
        }
        assert!(flash.write(SECTOR as u32, &written).is_err());
        flash.erase(0, SECTOR as u32).unwrap();
    }

    /// The watchdog's registers hold its timeout, and the oscillator that counts it is as the data sheet has it. That it
    /// resets is seen by hand (docs/user/hardware.md): a harness does not survive it.
    #[test]
    fn the_watchdog_is_set_to_two_seconds(board: Board) {
        let mut watchdog = IndependentWatchdog::new(board.iwdg);
        watchdog.start(WATCHDOG_MS.millis());
        // SAFETY: a device's registers, which are read only.
        let iwdg = unsafe { &*pac::IWDG::ptr() };
        let begun = board.time.now();
        // Until both values have reached the watchdog's own clock domain (RM0090 21.4.4).
        while iwdg.sr().read().bits() != 0 {
            assert!(board.time.now().since(begun) < 100_000);
        }
        watchdog.feed();
        let prescaler = 4 << iwdg.pr().read().pr().bits();
        let ticks = u32::from(iwdg.rlr().read().rl().bits()) + 1;
        // 32 kHz nominally; 17 to 47 kHz (DS8626, table 37).
        assert_within(ticks * prescaler / 32, WATCHDOG_MS - 20..=WATCHDOG_MS + 20);
        assert_within(lsi_hz(&board.time), 17_000..=47_000);
    }

    /// Returns the frequency of the internal low-speed oscillator, Hz, by captures of TIM5 (RM0090 18.4.21).
    fn lsi_hz(time: &Time) -> u32 {
        const CAPTURES: u32 = 100;
        /// Value of TI4_RMP in register TIM5_OR: channel 4 captures the oscillator.
        const LSI: u8 = 0b01;
        // SAFETY: a device's registers; the image's clock, which counts in this timer, goes on.
        let timer = unsafe { &*pac::TIM5::ptr() };
        // SAFETY: an input of the reference manual in a field of two bits.
        timer.or().modify(|_, w| unsafe { w.it4_rmp().bits(LSI) });
        timer
            .ccmr2_input()
            .modify(|_, w| w.cc4s().ti4().ic4psc().eight_events());
        timer.ccer().modify(|_, w| w.cc4e().set_bit());
        let capture = || {
            let begun = time.now();
            while timer.sr().read().cc4if().bit_is_clear() {
                assert!(time.now().since(begun) < 10_000, "no capture");
            }
            timer.ccr4().read().bits()
        };
        let first = capture();
        let last = (0..CAPTURES).fold(first, |_, _| capture());
        8 * CAPTURES * 1_000_000 / last.wrapping_sub(first)
    }

    /// With wires from PC6 (STEP) to PA1, and from PB1 (STALL) to ground: width and rate of the pulses, by captures of TIM2.
    #[test]
    fn step_pulses_have_their_width_and_rate(mut board: Board) {
        let (a, b, c) = board.gpio;
        let (a, b, c) = (
            a.split(&mut board.rcc),
            b.split(&mut board.rcc),
            c.split(&mut board.rcc),
        );
        let _captured = a.pa1.into_alternate::<1>();
        pac::TIM2::enable(&mut board.rcc);
        let driver = DriverConfig::default();
        let pins = Pins {
            enable: c.pc8.into_push_pull_output(),
            step: c.pc6.into_push_pull_output(),
            dir: c.pc7.into_push_pull_output(),
            home: b.pb0.into_pull_down_input(),
            stall: b.pb1.into_pull_up_input(),
            exti: board.exti,
        };
        let mut motor = Motor::new(pins, board.systick, board.clocks.core_hz, WireLevel::Low);
        motor.configure(&driver);
        motor.set_enabled(true);
        let ramp = Ramp {
            speed: SPEED,
            acceleration: 100_000_000,
        };
        motor.begin(2_000, ramp, false);
        critical_section::with(|cs| MOTOR.replace(cs, Some(motor)));
        let (width, period) = captured(&board.time);
        // The timer counts at 84 MHz: 1 % of rate, and the width that the driver asks for.
        let nominal = board.clocks.timer_hz / SPEED;
        assert_within(period, nominal * 99 / 100..=nominal * 101 / 100);
        let least = u32::from(driver.pulse_width) * board.clocks.timer_hz / 1_000_000;
        assert_within(width, least * 9 / 10..=nominal / 2);
    }

    /// Returns width and period of pulses at PA1, ticks of TIM2, by the mean over some hundred of them at full speed.
    fn captured(time: &Time) -> (u32, u32) {
        const PULSES: u32 = 256;
        // SAFETY: a device's registers; nothing else uses this timer.
        let timer = unsafe { &*pac::TIM2::ptr() };
        // Channel 2 captures rising edges of its input, channel 1 falling edges of the same one.
        timer.ccmr1_input().write(|w| w.cc2s().ti2().cc1s().ti2());
        timer
            .ccer()
            .write(|w| w.cc2e().set_bit().cc1e().set_bit().cc1p().set_bit());
        timer.cr1().write(|w| w.cen().set_bit());
        let edge = || {
            let begun = time.now();
            while timer.sr().read().cc1if().bit_is_clear() {
                assert!(
                    time.now().since(begun) < 100_000,
                    "no pulse: PC6 to PA1, PB1 to ground?"
                );
            }
            (timer.ccr2().read().bits(), timer.ccr1().read().bits())
        };
        // The first pulses are slower.
        let (first, _) = (0..PULSES).fold((0, 0), |_, _| edge());
        let (mut last, mut width) = (first, 0);
        for _ in 0..PULSES {
            let (rise, fall) = edge();
            (last, width) = (rise, width + fall.wrapping_sub(rise));
        }
        (width / PULSES, last.wrapping_sub(first) / PULSES)
    }

    /// With a wire from PA2 to PA3: bytes come back, and take the time of the baud rate.
    #[test]
    fn the_report_port_sends_at_its_rate(mut board: Board) {
        const BYTES: u32 = 200;
        let (a, _, _) = board.gpio;
        let a = a.split(&mut board.rcc);
        let pins = (a.pa2.into_alternate::<7>(), a.pa3.into_alternate::<7>());
        let rate = hal_baud(brr(board.clocks.apb1_hz, BAUD)).bps();
        let config = Config::default().baudrate(rate);
        let serial: Serial<_> = Serial::new(board.usart2, pins, config, &mut board.rcc).unwrap();
        let (mut tx, mut rx) = serial.split();
        let begun = board.time.now();
        for byte in (0..BYTES).map(|k| (k * 29) as u8) {
            while tx.write(byte).is_err() {}
            let sent = board.time.now();
            let back = loop {
                if let Ok(back) = rx.read() {
                    break back;
                }
                assert!(
                    board.time.now().since(sent) < 10_000,
                    "nothing: PA2 to PA3?"
                );
            };
            assert_eq!(back, byte);
        }
        // Ten bits a byte, and less than half a bit from each stop bit to the next start.
        let least = BYTES * 10 * 1_000 / (BAUD / 1_000) * 98 / 100;
        assert_within(board.time.now().since(begun), least..=least * 108 / 100);
    }
}
