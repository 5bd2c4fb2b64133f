//! The independent watchdog (RM0090 21): it has its own oscillator and cannot be stopped.
//!
//! The boot loader has started it with its longest period. A reload while a new period is still being taken over loads
//! the old one: the HAL reloads at once, so that its first window is the loader's, 32 s. So this sets it up itself.

/// Keys of register KR: start, access to PR and RLR, reload (RM0090 21.4.1).
const START: u16 = 0xcccc;
const ACCESS: u16 = 0x5555;
const RELOAD: u16 = 0xaaaa;
/// Prescaler: division of the 32 kHz by 256.
const DIVIDE_BY_256: u8 = 6;
/// Reload value for 2 s: 250 counts of 8 ms. The oscillator has 17 to 47 kHz (DS8626, table 37): 1.36 to 3.8 s.
const COUNTS: u16 = 249;
/// Maximum number of polls of 10 µs until PR and RLR are taken over. That takes 5 periods of the oscillator (RM0090
/// 21.4.4): 0.3 ms at most.
const POLLS: u32 = 100;

/// Registers of the independent watchdog.
pub trait Registers {
    /// Writes `key` to KR.
    fn key(&mut self, key: u16);
    /// Writes prescaler and reload value to PR and RLR.
    fn set_period(&mut self, prescaler: u8, reload: u16);
    /// Whether PR or RLR is still being taken over: PVU or RVU of SR.
    fn is_updating(&mut self) -> bool;
    /// Waits 10 µs.
    fn wait(&mut self);
}

/// Starts the watchdog with a period of 2 s, which also holds for the first window.
pub fn start(registers: &mut impl Registers) {
    // Its oscillator, which the update needs, runs from the start on.
    registers.key(START);
    // The loader's period may still be being taken over, and PR may not be written meanwhile.
    settle(registers);
    registers.key(ACCESS);
    registers.set_period(DIVIDE_BY_256, COUNTS);
    settle(registers);
    feed(registers);
}

/// Waits until PR and RLR have been taken over. Without an oscillator the watchdog does not count either.
fn settle(registers: &mut impl Registers) {
    for _ in 0..POLLS {
        if !registers.is_updating() {
            return;
        }
        registers.wait();
    }
}

/// Resets the watchdog's counter.
pub fn feed(registers: &mut impl Registers) {
    registers.key(RELOAD);
}

#[cfg(target_os = "none")]
mod chip {
    use stairscan::scanner::Micros;
    use stairscan::scanner::resets::SURVIVED_US;
    use stm32f4xx_hal::pac;

    use super::{Registers, feed, start};
    use crate::board::delay::delay_clocks;
    use crate::board::handover;

    /// The watchdog's registers, and the number of core clocks in 10 µs.
    struct ChipRegisters {
        iwdg: pac::IWDG,
        clocks: u32,
    }

    impl Registers for ChipRegisters {
        fn key(&mut self, key: u16) {
            // SAFETY: only the three keys above are written.
            self.iwdg.kr().write(|w| unsafe { w.bits(key) });
        }

        fn set_period(&mut self, prescaler: u8, reload: u16) {
            self.iwdg.pr().write(|w| w.pr().set(prescaler));
            // The only field of the register is set: nothing of its reset value remains.
            self.iwdg.rlr().write(|w| w.rl().set(reload));
        }

        fn is_updating(&mut self) -> bool {
            let state = self.iwdg.sr().read();
            state.pvu().bit_is_set() || state.rvu().bit_is_set()
        }

        fn wait(&mut self) {
            delay_clocks(self.clocks);
        }
    }

    /// The running watchdog.
    pub struct Watchdog {
        registers: ChipRegisters,
        fed: Micros,
        /// Time of the boot; `None` once the boot loader's count of resets is cleared.
        booted: Option<Micros>,
    }

    impl Watchdog {
        /// Minimum time between two resets of the watchdog's counter, µs.
        const PAUSE_US: u32 = 50_000;

        /// Starts the watchdog. With a debugger it stops while the core is halted, and the clock of memory and bus goes on
        /// while the core sleeps, so that the log can be read (RM0090 38.16.3).
        pub fn start(iwdg: pac::IWDG, dbgmcu: &pac::DBGMCU, core_hz: u32, now: Micros) -> Self {
            dbgmcu.apb1_fz().modify(|_, w| w.dbg_iwdg_stop().set_bit());
            dbgmcu.cr().modify(|_, w| w.dbg_sleep().set_bit());
            let clocks = core_hz / 100_000;
            let mut registers = ChipRegisters { iwdg, clocks };
            start(&mut registers);
            Self {
                registers,
                fed: now,
                booted: Some(now),
            }
        }

        /// Resets the watchdog's counter if `healthy`, that is if the scanner's state is within its deadline; clears the
        /// boot loader's count of resets a minute after the boot.
        pub fn attend(&mut self, now: Micros, healthy: bool) {
            let survived = |at| now.since(at) >= SURVIVED_US;
            if healthy && self.booted.is_some_and(survived) {
                self.booted = None;
                handover::clear_resets();
            }
            if healthy && now.since(self.fed) >= Self::PAUSE_US {
                feed(&mut self.registers);
                self.fed = now;
            }
        }
    }
}

#[cfg(target_os = "none")]
pub use chip::Watchdog;

#[cfg(test)]
mod tests {
    use super::*;

    /// Microseconds of one count of the oscillator at 17 kHz, times five: the longest update.
    const UPDATE_US: u32 = 300;

    /// Model of the watchdog that the loader has started with its longest period.
    struct Model {
        now_us: u32,
        access: bool,
        /// Prescaler and reload value in use, and those written; with the time from which these hold.
        used: (u8, u16),
        written: (u8, u16),
        until_us: u32,
        /// Counter after the last reload, and the prescaler then.
        window: (u8, u16),
    }

    impl Model {
        fn take_over(&mut self) -> bool {
            if self.now_us >= self.until_us {
                self.used = self.written;
            }
            self.now_us < self.until_us
        }

        /// Returns the time until the reset after the last reload, ms at 32 kHz.
        fn window_ms(&self) -> u32 {
            (u32::from(self.window.1) + 1) * (4 << self.window.0) / 32
        }
    }

    impl Registers for Model {
        fn key(&mut self, key: u16) {
            self.take_over();
            self.access = key == ACCESS;
            if key == RELOAD {
                self.window = self.used;
            }
        }

        fn set_period(&mut self, prescaler: u8, reload: u16) {
            assert!(self.access, "PR and RLR are locked");
            assert!(!self.take_over(), "an update is under way");
            self.written = (prescaler, reload);
            self.until_us = self.now_us + UPDATE_US;
        }

        fn is_updating(&mut self) -> bool {
            self.take_over()
        }

        fn wait(&mut self) {
            self.now_us += 10;
        }
    }

    fn from_loader(until_us: u32) -> Model {
        Model {
            now_us: 0,
            access: false,
            used: (0, 0xfff),
            written: (6, 0xfff),
            until_us,
            window: (6, 0xfff),
        }
    }

    #[test]
    fn the_first_window_is_as_long_as_the_others() {
        for until_us in [0, 10, UPDATE_US] {
            let mut model = from_loader(until_us);
            start(&mut model);
            assert_eq!(model.window_ms(), 2_000);
            feed(&mut model);
            assert_eq!(model.window_ms(), 2_000);
        }
        // Without the waits, as in the HAL.
        let mut model = from_loader(0);
        model.key(ACCESS);
        model.set_period(DIVIDE_BY_256, COUNTS);
        model.key(RELOAD);
        assert_eq!(model.window_ms(), 32_768);
    }

    #[test]
    fn an_update_that_never_ends_is_not_waited_for() {
        struct Dead(u32);
        impl Registers for Dead {
            fn key(&mut self, _: u16) {}
            fn set_period(&mut self, _: u8, _: u16) {}
            fn is_updating(&mut self) -> bool {
                true
            }
            fn wait(&mut self) {
                self.0 += 1;
            }
        }
        let mut dead = Dead(0);
        start(&mut dead);
        assert_eq!(dead.0, 2 * POLLS);
    }
}
