//! A board without non-volatile memory, for scanners on the host.

use stairscan::scanner::command::Measure;
use stairscan::scanner::store::StoreError;
use stairscan::scanner::{Board, BoardHealth, BootInfo, SecondMemory, Settings};

/// A board that keeps nothing over a reset and has no flash.
#[derive(Clone, Copy, Debug)]
pub struct Volatile {
    stopped: bool,
}

impl Volatile {
    /// Board, without non-volatile memory, of a scanner that starts scanning at boot.
    pub const SCANNING: Self = Self { stopped: false };
    /// Board, without non-volatile memory, of a scanner that waits after boot for the command `start`.
    pub const STOPPED: Self = Self { stopped: true };
}

/// Returns the boot information of a scanner on the host, with `what` in the place of the revision.
pub const fn identity(what: &'static str) -> BootInfo {
    BootInfo {
        version: env!("CARGO_PKG_VERSION"),
        revision: what,
        reset: "none",
        clock: "host",
        boots: 1,
        serial: [0; 3],
        second_memory: SecondMemory::Unknown,
        option_bytes: None,
        cause: None,
        crash_loop: false,
        health: BoardHealth::GOOD,
    }
}

impl Board for Volatile {
    fn stopped(&self) -> bool {
        self.stopped
    }

    fn set_stopped(&mut self, stopped: bool) {
        self.stopped = stopped;
    }

    fn retained_settings_hash(&self) -> Option<u32> {
        None
    }

    fn retain_settings_hash(&mut self, _: u32) {}

    fn save(&mut self, _: &Settings) -> Result<(), StoreError> {
        Err(StoreError::Controller)
    }

    fn clear_crashes(&mut self) {}

    fn measure(&self, _: Measure) -> u32 {
        0
    }
}
