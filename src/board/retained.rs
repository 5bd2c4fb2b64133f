//! State that survives a reset as long as the power stays on: a record in uninitialised RAM with a checksum.

use stairscan::crc;
use stairscan::report::{CrashLine, CrashSite};

/// Cause of a reset by the firmware itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Crash {
    /// The firmware did not reset the chip by a crash.
    None = 0,
    /// A panic.
    Panic = 1,
    /// A hard fault, such as one by a stack overflow.
    HardFault = 2,
    /// An interrupt without a handler.
    UnhandledInterrupt = 3,
    /// A memory protection fault: the stack's end was reached, or code was executed in RAM.
    Memory = 4,
    /// The supply voltage fell.
    Supply = 5,
    /// The crystal stopped.
    Clock = 6,
}

impl Crash {
    const ALL: [Self; 7] = [
        Self::None,
        Self::Panic,
        Self::HardFault,
        Self::UnhandledInterrupt,
        Self::Memory,
        Self::Supply,
        Self::Clock,
    ];

    /// Returns the crash as the cause of a reset.
    #[cfg_attr(not(target_os = "none"), allow(dead_code))]
    pub const fn as_str(self) -> &'static str {
        match self {
            Crash::None => "none",
            Crash::Panic => "panic",
            Crash::HardFault => "hard-fault",
            Crash::UnhandledInterrupt => "stray-interrupt",
            Crash::Memory => "memory-fault",
            Crash::Supply => "supply",
            Crash::Clock => "clock",
        }
    }

    /// Returns the crash of this number; [`Crash::UnhandledInterrupt`] for any number without a crash.
    #[cfg_attr(not(target_os = "none"), allow(dead_code))]
    pub fn from_number(number: u32) -> Self {
        let found = Self::ALL.iter().find(|crash| **crash as u32 == number);
        found.copied().unwrap_or(Self::UnhandledInterrupt)
    }
}

/// State that is retained over a reset, for the next boot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BootRecord {
    /// Whether `stop` was the last of the commands `start` and `stop`.
    pub stopped: bool,
    /// Cause of the reset if the firmware itself makes it after a crash.
    pub crash: Crash,
    /// Number of boots since power-up, the current one included.
    pub boots: u32,
    /// Number of consecutive boots after a crash, a watchdog reset or a loss of supply; 0 once the firmware has
    /// run long enough.
    pub crashes: u32,
    /// Hash of the configured settings in force; `None` if there were none.
    pub settings: Option<u32>,
}

/// The record as words: flags, boots, crashes, hash of settings, and checksum.
type Words = [u32; 5];

impl BootRecord {
    /// Record of a fresh power-up.
    pub const FRESH: Self = Self {
        stopped: false,
        crash: Crash::None,
        boots: 0,
        crashes: 0,
        settings: None,
    };
    /// Value XORed into the checksum, so that neither all zeros nor all ones are a valid record.
    const CHECKSUM_XOR: u32 = 0x5ca7_13e5;

    fn check(words: &Words) -> u32 {
        let [flags, boots, crashes, hash, _] = *words;
        crc::of_words(&[flags, boots, crashes, hash]) ^ Self::CHECKSUM_XOR
    }

    fn words(self) -> Words {
        let flags = u32::from(self.stopped)
            | (self.crash as u32) << 8
            | u32::from(self.settings.is_some()) << 16;
        let hash = self.settings.unwrap_or(0);
        let check = Self::check(&[flags, self.boots, self.crashes, hash, 0]);
        [flags, self.boots, self.crashes, hash, check]
    }

    /// Returns the record of these words, or that of a fresh power-up if their checksum is wrong.
    fn from_words(words: Words) -> Self {
        let [flags, boots, crashes, hash, check] = words;
        if check != Self::check(&words) {
            return Self::FRESH;
        }
        let crash = Crash::from_number((flags >> 8) & 0xff);
        Self {
            stopped: flags & 1 == 1,
            crash,
            boots,
            crashes,
            settings: (flags >> 16 == 1).then_some(hash),
        }
    }
}

/// The last crash. It is written at a crash alone, and kept over later resets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CrashRecord {
    /// Cause of the reset.
    pub crash: Crash,
    /// Number of the boot since power-up that crashed.
    pub boot: u32,
    /// Place of the crash.
    pub site: CrashSite,
}

/// The record of the last crash as words: flags, boot, the five words of the place, and checksum.
type CrashWords = [u32; 8];

impl CrashRecord {
    /// Value XORed into the checksum, so that neither all zeros nor all ones are a valid record.
    const CHECKSUM_XOR: u32 = 0x2b90_c41d;

    /// Returns the content of the sentence `CRASH`.
    #[cfg_attr(not(target_os = "none"), allow(dead_code))]
    pub fn line(self) -> CrashLine<'static> {
        CrashLine {
            cause: self.crash.as_str(),
            boot: self.boot,
            site: self.site,
        }
    }

    fn words(self) -> CrashWords {
        let site = self.site;
        let fields = [site.pc, site.lr, site.cfsr, site.address, site.place];
        let mut flags = self.crash as u32;
        for (bit, field) in (8..).zip(&fields) {
            flags |= u32::from(field.is_some()) << bit;
        }
        let [pc, lr, cfsr, address, place] = fields.map(Option::unwrap_or_default);
        let words = [flags, self.boot, pc, lr, cfsr, address, place];
        let check = crc::of_words(&words) ^ Self::CHECKSUM_XOR;
        [flags, self.boot, pc, lr, cfsr, address, place, check]
    }

    /// Returns the record of these words; `None` if their checksum is wrong.
    fn from_words(words: CrashWords) -> Option<Self> {
        let [flags, boot, pc, lr, cfsr, address, place, check] = words;
        let right = crc::of_words(&[flags, boot, pc, lr, cfsr, address, place]);
        (check == right ^ Self::CHECKSUM_XOR).then_some(())?;
        let field = |bit: u32, word: u32| (flags >> bit & 1 == 1).then_some(word);
        Some(Self {
            crash: Crash::from_number(flags & 0xff),
            boot,
            site: CrashSite {
                pc: field(8, pc),
                lr: field(9, lr),
                cfsr: field(10, cfsr),
                address: field(11, address),
                place: field(12, place),
            },
        })
    }
}

#[cfg(target_os = "none")]
mod memory {
    use super::{BootRecord, CrashRecord, CrashWords, Words};
    use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

    const LENGTH: usize = size_of::<Words>() / size_of::<u32>();

    // SAFETY: the start-up code leaves the section unchanged, and any bits are valid words. A partly written
    // record fails its checksum.
    #[unsafe(link_section = ".uninit.RETAINED")]
    static RETAINED: [AtomicU32; LENGTH] = [const { AtomicU32::new(0) }; LENGTH];

    // SAFETY: as above.
    #[unsafe(link_section = ".uninit.CRASH")]
    static CRASH: [AtomicU32; size_of::<CrashWords>() / size_of::<u32>()] =
        [const { AtomicU32::new(0) }; size_of::<CrashWords>() / size_of::<u32>()];

    /// Returns the record of the last crash; `None` if there is none.
    pub fn load_crash() -> Option<CrashRecord> {
        CrashRecord::from_words(CRASH.each_ref().map(|place| place.load(Relaxed)))
    }

    /// Writes the record of the last crash.
    pub fn store_crash(record: CrashRecord) {
        for (place, word) in CRASH.iter().zip(record.words()) {
            place.store(word, Relaxed);
        }
    }

    /// Deletes the record of the last crash.
    pub fn forget_crash() {
        // Zeros fail the checksum.
        CRASH.iter().for_each(|place| place.store(0, Relaxed));
    }

    /// Returns the record in retained memory, or that of a fresh power-up.
    pub fn load() -> BootRecord {
        BootRecord::from_words(RETAINED.each_ref().map(|place| place.load(Relaxed)))
    }

    /// Writes `record` to retained memory.
    pub fn store(record: BootRecord) {
        for (place, word) in RETAINED.iter().zip(record.words()) {
            place.store(word, Relaxed);
        }
    }
}

#[cfg(target_os = "none")]
pub use memory::{forget_crash, load, load_crash, store, store_crash};

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: BootRecord = BootRecord {
        stopped: true,
        crash: Crash::Panic,
        boots: 7,
        crashes: 2,
        settings: Some(0),
    };

    #[test]
    fn survives_as_written() {
        for stopped in [false, true] {
            for crash in Crash::ALL {
                for settings in [None, Some(0), Some(u32::MAX)] {
                    let record = BootRecord {
                        stopped,
                        crash,
                        settings,
                        ..GOOD
                    };
                    assert_eq!(BootRecord::from_words(record.words()), record);
                }
            }
        }
    }

    #[test]
    fn a_crash_survives_as_written_and_nothing_else_is_one() {
        let site = |bits: u32| {
            let field = |bit: u32| (bits >> bit & 1 == 1).then_some(bit * 0x0101_0101);
            CrashSite {
                pc: field(0),
                lr: field(1),
                cfsr: field(2),
                address: field(3),
                place: field(4),
            }
        };
        for crash in Crash::ALL {
            for bits in 0..32 {
                let record = CrashRecord {
                    crash,
                    boot: u32::MAX - bits,
                    site: site(bits),
                };
                let words = record.words();
                assert_eq!(CrashRecord::from_words(words), Some(record));
                for bit in 0..256 {
                    let mut bad = words;
                    bad[bit / 32] ^= 1 << (bit % 32);
                    assert_eq!(CrashRecord::from_words(bad), None, "bit {bit}");
                }
            }
        }
        for pattern in [0, u32::MAX, 0x5555_5555] {
            assert_eq!(CrashRecord::from_words([pattern; 8]), None);
        }
    }

    #[test]
    fn anything_else_is_a_fresh_power_up() {
        for bit in 0..160 {
            let mut words = GOOD.words();
            words[bit / 32] ^= 1 << (bit % 32);
            assert_eq!(
                BootRecord::from_words(words),
                BootRecord::FRESH,
                "bit {bit}"
            );
        }
        for pattern in [0, u32::MAX, 0x5555_5555] {
            assert_eq!(BootRecord::from_words([pattern; 5]), BootRecord::FRESH);
        }
    }
}
