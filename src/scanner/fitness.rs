//! Whether image, memory, supply and clock are fit to scan.

use crate::scanner::seal::ImageState;
use crate::scanner::settings::{Settings, Switch};
use crate::verdict::{Reason, Reasons};

/// State of image, memory, supply and clock at boot, valid until a reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoardHealth {
    /// State of the image in flash, by comparison with its seal.
    pub image: ImageState,
    /// Whether the march test of the memory has failed.
    pub memory_damaged: bool,
    /// Whether the supply voltage was too low at boot.
    pub supply_low: bool,
    /// Whether the internal oscillator drives the core, because the crystal does not run.
    pub internal_clock: bool,
}

impl BoardHealth {
    /// Board without any fault.
    pub const GOOD: Self = Self {
        image: ImageState::Whole,
        memory_damaged: false,
        supply_low: false,
        internal_clock: false,
    };

    /// Returns the first reason that prevents scans, if any. The internal oscillator prevents them unless the
    /// setting `internal-clock` allows it.
    pub(super) fn fault(self, settings: &Settings) -> Option<Reason> {
        let allowed = settings.timing.internal_clock == Switch::On;
        let faults = [
            (self.image == ImageState::Damaged, Reason::ImageDamaged),
            (self.memory_damaged, Reason::MemoryDamaged),
            (self.supply_low, Reason::Supply),
            (self.internal_clock && !allowed, Reason::InternalClock),
        ];
        let found = faults.into_iter().find(|&(found, _)| found);
        found.map(|(_, reason)| reason)
    }

    /// Returns the reasons for which no answer may be `ok`: at most one, for an image without a seal.
    pub(super) fn degrading_faults(self) -> Reasons {
        match self.image {
            ImageState::Blank => Reasons::NONE.with(Reason::ImageUnsealed),
            ImageState::Whole | ImageState::Damaged => Reasons::NONE,
        }
    }
}
