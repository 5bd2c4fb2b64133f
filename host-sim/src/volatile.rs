//! A board without non-volatile memory, for scanners on the host.

use stairscan::scanner::command::Measure;
use stairscan::scanner::store::StoreError;
use stairscan::scanner::{Board, Fitness, Identity, Settings};

/// A board that keeps nothing over a reset and has no flash.
#[derive(Clone, Copy, Debug)]
pub struct Volatile {
    stopped: bool,
}

impl Volatile {
    /// For a scanner that starts scanning at boot.
    pub const SCANNING: Self = Self { stopped: false };
    /// For a scanner that waits for `start`.
    pub const STOPPED: Self = Self { stopped: true };
}

/// Identity of a scanner on the host, built for `what`.
pub const fn identity(what: &'static str) -> Identity {
    Identity {
        version: env!("CARGO_PKG_VERSION"),
        revision: what,
        reset: "none",
        clock: "host",
        boots: 1,
        serial: [0; 3],
        cause: None,
        crash_loop: false,
        fitness: Fitness::GOOD,
    }
}

impl Board for Volatile {
    fn stopped(&self) -> bool {
        self.stopped
    }

    fn set_stopped(&mut self, stopped: bool) {
        self.stopped = stopped;
    }

    fn settings_before(&self) -> Option<u32> {
        None
    }

    fn note_settings(&mut self, _: u32) {}

    fn save(&mut self, _: &Settings) -> Result<(), StoreError> {
        Err(StoreError::Controller)
    }

    fn survived(&mut self) {}

    fn measure(&self, _: Measure) -> u32 {
        0
    }
}
