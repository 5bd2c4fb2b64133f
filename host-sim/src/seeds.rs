//! Allocation of the seeds of random scenes to their uses.
//!
//! A published result is valid only for scenes that were not used for tuning. Every scene that is
//! inspected, fitted to or used for comparisons influences the tuning. Therefore the seeds are
//! allocated here, once.

use std::fmt;
use std::ops::Range;

use clap::ValueEnum;

use crate::random::Kind;

/// A draw: a range of seeds of random scenes that is reserved for one use, such as tuning or published results. Scenes
/// of one draw are in no other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Draw {
    /// Fits of weights, and inspection of single scenes.
    Tuning,
    /// Choice between several fits.
    Validation,
    /// Calibration of probabilities, and thresholds, by `fit`.
    Calibration,
    /// Regression test in CI; measured at every change, so that it counts as used for tuning.
    #[default]
    Snapshot,
    /// Published tables only, never used for tuning.
    Reporting,
}

/// Seeds of [`Draw::Tuning`]. Scenes drawn without a seed used the first of them.
pub const TUNING: Range<u64> = 0..1_000_000;
/// Seeds of [`Draw::Validation`].
pub const VALIDATION: Range<u64> = 1_000_000..1_500_000;
/// Seeds of [`Draw::Calibration`].
pub const CALIBRATION: Range<u64> = 1_500_000..2_000_000;
/// Seeds of [`Draw::Snapshot`].
pub const SNAPSHOT: Range<u64> = 2_000_000..3_000_000;
/// Seeds of [`Draw::Reporting`].
pub const REPORTING: Range<u64> = 3_000_000..4_000_000;

impl Draw {
    /// All draws, in the order of their seeds.
    pub const ALL: [Draw; 5] = [
        Draw::Tuning,
        Draw::Validation,
        Draw::Calibration,
        Draw::Snapshot,
        Draw::Reporting,
    ];

    /// Returns the range of seeds that is reserved for the draw's use.
    pub fn seeds(self) -> Range<u64> {
        match self {
            Draw::Tuning => TUNING,
            Draw::Validation => VALIDATION,
            Draw::Calibration => CALIBRATION,
            Draw::Snapshot => SNAPSHOT,
            Draw::Reporting => REPORTING,
        }
    }

    /// Returns the number of scenes of a kind for a table: for the published one as many as a machine with two cores
    /// computes in half an hour, for the others in two minutes. The published one has more of those kinds whose types
    /// of answer are rarely `ok`, without steps and down. Each of these types then has about 2,000 `ok` answers, and
    /// that of a drop ahead about 800.
    pub fn scenes(self, kind: Kind) -> u64 {
        match (self, kind) {
            (Draw::Reporting, Kind::Ascending) => 1800,
            (Draw::Reporting, Kind::None | Kind::Clutter | Kind::Brink | Kind::Hole) => 2400,
            (Draw::Reporting, Kind::Descending | Kind::Downstairs) => 4000,
            (Draw::Reporting, _) => 600,
            (_, Kind::Ascending) => 60,
            (_, _) => 12,
        }
    }

    /// Returns the draw's name on the command line.
    pub fn as_str(self) -> &'static str {
        match self {
            Draw::Tuning => "tuning",
            Draw::Validation => "validation",
            Draw::Calibration => "calibration",
            Draw::Snapshot => "snapshot",
            Draw::Reporting => "reporting",
        }
    }
}

impl fmt::Display for Draw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}
