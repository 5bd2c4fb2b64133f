//! Interface of the board and data of its boot: what the scanner needs besides mirror and radar module.

use super::fitness::BoardHealth;
use super::settings::Settings;
use super::store::StoreError;
use crate::report::CrashLine;
use crate::scanner::command::Measure;
use crate::verdict::{Reason, Reasons};

/// Functions of the board: retained state, flash, diagnostics.
pub trait Board {
    /// Whether `stop` was the last of `start` and `stop`; survives a reset.
    fn stopped(&self) -> bool;
    /// Retains over a reset whether the scanner stays idle: `true` after `stop`, `false` after `start`.
    fn set_stopped(&mut self, stopped: bool);
    /// Returns the hash that [`Board::retain_settings_hash`] retained before the reset; `None` if none has been
    /// retained since power-up.
    fn retained_settings_hash(&self) -> Option<u32>;
    /// Retains `hash`, that of the settings in force, over a reset.
    fn retain_settings_hash(&mut self, hash: u32);
    /// Saves `settings` in flash. May block for as long as flash takes to erase; so it may be called only when
    /// nothing moves.
    fn save(&mut self, settings: &Settings) -> Result<(), StoreError>;
    /// Sets the number of consecutive crashes to 0: the firmware has run long enough since the last one.
    fn clear_crashes(&mut self);
    /// Returns the last crash since power-on, or since [`Board::forget_crash`].
    fn last_crash(&self) -> CrashLine<'static> {
        CrashLine::NONE
    }
    /// Deletes the record of the last crash.
    fn forget_crash(&mut self) {}
    /// Resets the chip into its boot loader, which takes a new image; returns if the chip has no boot loader.
    fn enter_loader(&mut self) {}
    /// Called when the self-test has passed: an image on trial resets the chip here, and the boot loader confirms it.
    fn self_test_passed(&mut self) {}
    /// Returns the diagnostic value that `measure` selects, such as the size of the stack in bytes.
    fn measure(&self, measure: Measure) -> u32;
}

impl<B: Board + ?Sized> Board for &mut B {
    fn stopped(&self) -> bool {
        (**self).stopped()
    }

    fn set_stopped(&mut self, stopped: bool) {
        (**self).set_stopped(stopped);
    }

    fn retained_settings_hash(&self) -> Option<u32> {
        (**self).retained_settings_hash()
    }

    fn retain_settings_hash(&mut self, hash: u32) {
        (**self).retain_settings_hash(hash);
    }

    fn save(&mut self, settings: &Settings) -> Result<(), StoreError> {
        (**self).save(settings)
    }

    fn clear_crashes(&mut self) {
        (**self).clear_crashes();
    }

    fn last_crash(&self) -> CrashLine<'static> {
        (**self).last_crash()
    }

    fn forget_crash(&mut self) {
        (**self).forget_crash();
    }

    fn enter_loader(&mut self) {
        (**self).enter_loader();
    }

    fn self_test_passed(&mut self) {
        (**self).self_test_passed();
    }

    fn measure(&self, measure: Measure) -> u32 {
        (**self).measure(measure)
    }
}

/// State of the chip's second memory at boot: the 64 KB that the scanner's data do not need.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SecondMemory {
    /// It was not looked for.
    #[default]
    Unknown,
    /// The chip has none.
    None,
    /// 64 KB of CCM, as on the STM32F405 and F407.
    Ccm,
    /// 64 KB of SRAM3, as on the STM32F427 and F429.
    Sram3,
    /// It is there, and does not keep what is written to it.
    Damaged,
}

impl SecondMemory {
    /// Returns the state as it appears in `BOOT`; empty if it is unknown.
    pub const fn as_str(self) -> &'static str {
        match self {
            SecondMemory::Unknown => "",
            SecondMemory::None => "none",
            SecondMemory::Ccm => "ccm-64",
            SecondMemory::Sram3 => "sram3-64",
            SecondMemory::Damaged => "damaged",
        }
    }
}

/// Content of the sentence `BOOT`, and state of the board at boot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BootInfo {
    /// Version of the firmware.
    pub version: &'static str,
    /// Git revision from which the firmware was built.
    pub revision: &'static str,
    /// Cause of the reset as text, such as `power-on` or `watchdog`.
    pub reset: &'static str,
    /// Clock source of the core as text: `hse-168` (crystal, 168 MHz) or `hsi-16` (internal oscillator, 16 MHz).
    pub clock: &'static str,
    /// Number of boots since power-up, this one included.
    pub boots: u32,
    /// Unique number of the chip, 96 bits, in the order of its memory.
    pub serial: [u32; 3],
    /// State of the chip's second memory.
    pub second_memory: SecondMemory,
    /// Bits of the chip's option bytes ([`OptionBytes::bits`](super::option_bytes::OptionBytes::bits)); `None` if they
    /// are unknown.
    pub option_bytes: Option<u32>,
    /// Cause of the reset as a reason for `status`; `None` unless it was a crash, the watchdog or the supply.
    pub cause: Option<Reason>,
    /// Whether several resets by crash, watchdog or supply followed one another: the scanner then stays idle
    /// until a command starts it.
    pub crash_loop: bool,
    /// State of image, memory, supply and clock at boot.
    pub health: BoardHealth,
}

impl BootInfo {
    /// Returns the reasons that `status` shows about the reset until a scan has succeeded.
    pub(super) fn reasons(&self) -> Reasons {
        let cause = |reason| Reasons::NONE.with(reason);
        let mut reasons = self.cause.map_or(Reasons::NONE, cause);
        if self.crash_loop {
            reasons.add(Reason::CrashLoop);
        }
        reasons
    }
}
