//! Outcome of one recording with one fault.

use crate::recording::Recording;

/// First seed of faults, separate from those of scenes; one seed for each recording.
pub const SEEDS: u64 = 1 << 32;

/// Outcome of one run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// Status `fault`.
    Fault,
    /// Degraded, and the reason names the fault.
    Named,
    /// Degraded for another reason.
    Unnamed,
    /// `ok` and correct.
    Right,
    /// `ok` and wrong.
    Wrong,
}

/// One recording with one fault.
pub struct Run {
    /// The outcome.
    pub fate: Fate,
    /// Whether its reasons name the fault.
    pub named: bool,
    /// Text that is printed if the answer is `ok` and wrong.
    pub words: String,
}

/// The recordings that are `ok` and correct without a fault, with counts.
pub struct Clean {
    /// The recordings.
    pub recordings: Vec<Recording>,
    /// Range of the mirror's own echo in each, 0.01 mm from the radar.
    pub mirror_echoes: Vec<i32>,
    /// Number of recordings that were `ok`.
    pub ok: usize,
    /// Number of recordings.
    pub all: usize,
}
