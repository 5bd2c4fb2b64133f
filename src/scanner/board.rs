//! What the scanner is built over, beside its mirror and its radar module.

use super::fitness::Fitness;
use super::settings::Settings;
use super::store::StoreError;
use crate::scanner::command::Measure;
use crate::verdict::{Reason, Reasons};

/// What else the scanner needs of its board.
pub trait Board {
    /// Whether `stop` was the last word; survives a reset.
    fn stopped(&self) -> bool;
    /// Remembers whether to stand still.
    fn set_stopped(&mut self, stopped: bool);
    /// Hash of the settings that were in force before the reset; `None` after the power was off.
    fn settings_before(&self) -> Option<u32>;
    /// Remembers the hash of the settings that are in force over a reset.
    fn note_settings(&mut self, hash: u32);
    /// Keeps `settings` over loss of power. May take as long as flash takes to erase, during which
    /// nothing else runs: only from a standstill.
    fn save(&mut self, settings: &Settings) -> Result<(), StoreError>;
    /// The firmware has run long enough to forget crashes before this boot.
    fn survived(&mut self);
    /// Resets the chip into its boot loader, which takes a new image; returns where there is none.
    fn enter_loader(&mut self) {}
    /// The self-test has passed: an image on trial resets the chip here, and the boot loader confirms it.
    fn self_test_passed(&mut self) {}
    /// A diagnostic value.
    fn measure(&self, measure: Measure) -> u32;
}

impl<B: Board + ?Sized> Board for &mut B {
    fn stopped(&self) -> bool {
        (**self).stopped()
    }

    fn set_stopped(&mut self, stopped: bool) {
        (**self).set_stopped(stopped);
    }

    fn settings_before(&self) -> Option<u32> {
        (**self).settings_before()
    }

    fn note_settings(&mut self, hash: u32) {
        (**self).note_settings(hash);
    }

    fn save(&mut self, settings: &Settings) -> Result<(), StoreError> {
        (**self).save(settings)
    }

    fn survived(&mut self) {
        (**self).survived();
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

/// What the first sentence after boot says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Version of the firmware.
    pub version: &'static str,
    /// Git revision that it was built from.
    pub revision: &'static str,
    /// Why the chip was reset.
    pub reset: &'static str,
    /// What drives the core.
    pub clock: &'static str,
    /// Boots since power came, this one included.
    pub boots: u32,
    /// The chip's own number.
    pub serial: [u32; 3],
    /// What reset the chip, where that was a crash, the watchdog or the supply.
    pub cause: Option<Reason>,
    /// Whether such resets followed one another: the scanner stands still until it is told to start.
    pub crash_loop: bool,
    /// Processor, memory, clock and supply.
    pub fitness: Fitness,
}

impl Identity {
    /// Returns what `status` shows of the reset until a scan has succeeded.
    pub(super) fn reasons(&self) -> Reasons {
        let cause = |reason| Reasons::NONE.with(reason);
        let mut reasons = self.cause.map_or(Reasons::NONE, cause);
        if self.crash_loop {
            reasons.add(Reason::CrashLoop);
        }
        reasons
    }
}

/// The scanner's hardware, each piece behind its trait.
#[derive(Clone, Copy, Debug)]
pub struct Hardware<M, L, P, B> {
    /// The mirror ([`super::Mirror`]).
    pub mirror: M,
    /// The radar module ([`crate::signal::radar::RadarModule`]).
    pub link: L,
    /// The report port ([`BytePort`](crate::port::BytePort)).
    pub port: P,
    /// The rest ([`Board`]).
    pub board: B,
}
