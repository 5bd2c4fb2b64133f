//! Board of the scanner: state that a reset retains, and flash with the settings.
//!
//! In: what the scanner retains and saves, and faults of the flash on command. Out: the same after a reset or a loss of
//! power.

use stairscan::scanner::command::Measure;
use stairscan::scanner::store::{Store, StoreError};
use stairscan::scanner::{self, Settings};

use super::flash::{Flash, FlashFault, Power};
use super::shared::Shared;

/// Size of a sector of settings, bytes: sectors 1 and 2 of the STM32F405 (RM0090, table 5).
pub const SECTOR: usize = 16 * 1024;

/// State of the board.
#[derive(Clone, Debug)]
pub struct Board {
    /// Whether `stop` was the last of `start` and `stop`.
    pub stopped: bool,
    /// Retained hash of the settings in force; `None` before it is retained first.
    pub settings_hash: Option<u32>,
    /// Number of boots since power-up.
    pub boots: u32,
    /// Whether the count of crashes has been set to 0.
    pub crashes_cleared: bool,
    /// The two sectors of settings.
    pub flash: Flash<SECTOR>,
    /// Every diagnostic value.
    pub measured: u32,
}

impl Board {
    /// Returns a board with erased flash before its first boot; `seed` selects what power cuts leave of the flash.
    pub fn new(seed: u64) -> Self {
        Self {
            stopped: false,
            settings_hash: None,
            boots: 0,
            crashes_cleared: false,
            flash: Flash::new(2, &Power::new(seed)),
            measured: 0,
        }
    }

    /// Loses the power: only the flash keeps its content.
    pub fn lose_power(&mut self) {
        (self.stopped, self.settings_hash, self.boots) = (false, None, 0);
    }

    /// Lets the flash refuse to be written and erased, or not.
    pub fn break_flash(&mut self, broken: bool) {
        self.flash.refuses = broken.then_some(FlashFault::Controller);
    }

    /// Returns the settings in flash; `None` if there are none.
    pub fn load(&mut self) -> Option<Settings> {
        Store::new(&mut self.flash).load()
    }
}

impl Default for Board {
    fn default() -> Self {
        Self::new(0)
    }
}

impl scanner::Board for Board {
    fn stopped(&self) -> bool {
        self.stopped
    }

    fn set_stopped(&mut self, stopped: bool) {
        self.stopped = stopped;
    }

    fn retained_settings_hash(&self) -> Option<u32> {
        self.settings_hash
    }

    fn retain_settings_hash(&mut self, hash: u32) {
        self.settings_hash = Some(hash);
    }

    fn save(&mut self, settings: &Settings) -> Result<(), StoreError> {
        // As on the chip, which checks supply and controller first.
        match self.flash.refuses {
            Some(FlashFault::LowSupply) => Err(StoreError::Supply),
            Some(_) => Err(StoreError::Controller),
            None => Store::new(&mut self.flash).save(settings),
        }
    }

    fn clear_crashes(&mut self) {
        self.crashes_cleared = true;
    }

    fn measure(&self, _: Measure) -> u32 {
        self.measured
    }
}

impl scanner::Board for Shared<Board> {
    fn stopped(&self) -> bool {
        self.get().stopped
    }

    fn set_stopped(&mut self, stopped: bool) {
        self.get().set_stopped(stopped);
    }

    fn retained_settings_hash(&self) -> Option<u32> {
        self.get().settings_hash
    }

    fn retain_settings_hash(&mut self, hash: u32) {
        self.get().retain_settings_hash(hash);
    }

    fn save(&mut self, settings: &Settings) -> Result<(), StoreError> {
        self.get().save(settings)
    }

    fn clear_crashes(&mut self) {
        self.get().clear_crashes();
    }

    fn measure(&self, measure: Measure) -> u32 {
        self.get().measure(measure)
    }
}
