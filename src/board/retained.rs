//! What survives a reset: the last word of `stop`, and why the firmware reset itself.

/// Cause of a reset that the firmware brought about itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Crash {
    /// None.
    None = 0,
    /// A panic.
    Panic = 1,
    /// A hard fault, a stack overflow among them.
    HardFault = 2,
    /// An interrupt without a handler.
    Stray = 3,
}

/// A small record with a checksum: after power-up the memory holds anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Record {
    stopped: u32,
    crash: u32,
    check: u32,
}

impl Record {
    const SALT: u32 = 0x5ca7_13e5;

    const fn check(stopped: u32, crash: u32) -> u32 {
        // A multiplication spreads each bit over the word; equal words never check.
        (stopped ^ Self::SALT)
            .wrapping_mul(0x9e37_79b1)
            .rotate_left(7)
            ^ crash.wrapping_mul(0x85eb_ca6b)
    }

    /// A record.
    pub const fn new(stopped: bool, crash: Crash) -> Self {
        let (stopped, crash) = (stopped as u32, crash as u32);
        Self {
            stopped,
            crash,
            check: Self::check(stopped, crash),
        }
    }

    /// The record if it is one, else that of a fresh power-up.
    pub fn checked(self) -> Self {
        let valid = self.check == Self::check(self.stopped, self.crash) && self.stopped <= 1;
        if valid {
            self
        } else {
            Self::new(false, Crash::None)
        }
    }

    /// Whether `stop` was the last word.
    pub fn stopped(self) -> bool {
        self.stopped == 1
    }

    /// Why the firmware reset the chip.
    pub fn crash(self) -> Crash {
        match self.crash {
            1 => Crash::Panic,
            2 => Crash::HardFault,
            3 => Crash::Stray,
            _ => Crash::None,
        }
    }
}

#[cfg(target_os = "none")]
mod memory {
    use super::{Crash, Record};
    use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

    // SAFETY: the start-up code leaves the section as it is, and any bits are three words. A torn
    // record fails its check.
    #[unsafe(link_section = ".uninit.RETAINED")]
    static RETAINED: [AtomicU32; 3] = [const { AtomicU32::new(0) }; 3];

    /// Reads the record.
    pub fn load() -> Record {
        let [stopped, crash, check] = &RETAINED;
        Record {
            stopped: stopped.load(Relaxed),
            crash: crash.load(Relaxed),
            check: check.load(Relaxed),
        }
        .checked()
    }

    /// Writes the record.
    pub fn store(stopped: bool, crash: Crash) {
        let record = Record::new(stopped, crash);
        let words = [record.stopped, record.crash, record.check];
        for (place, word) in RETAINED.iter().zip(words) {
            place.store(word, Relaxed);
        }
    }
}

#[cfg(target_os = "none")]
pub use memory::{load, store};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn survives_as_written_and_rejects_anything_else() {
        for stopped in [false, true] {
            for crash in [Crash::None, Crash::Panic, Crash::HardFault, Crash::Stray] {
                let record = Record::new(stopped, crash).checked();
                assert_eq!((record.stopped(), record.crash()), (stopped, crash));
            }
        }
        let fresh = Record::new(false, Crash::None);
        let good = Record::new(true, Crash::Panic);
        for bit in 0..96 {
            let mut words = [good.stopped, good.crash, good.check];
            words[bit / 32] ^= 1 << (bit % 32);
            let [stopped, crash, check] = words;
            let record = Record {
                stopped,
                crash,
                check,
            };
            assert_eq!(record.checked(), fresh, "bit {bit}");
        }
        for pattern in [0, u32::MAX, 0x5555_5555] {
            let record = Record {
                stopped: pattern,
                crash: pattern,
                check: pattern,
            };
            assert_eq!(record.checked(), fresh);
        }
    }
}
