//! Outcome of one recording, or guard sweep, with one fault.

use crate::recording::Recording;

/// First seed of faults, separate from those of scenes: the recording at index `k` has the seed `SEEDS + k`.
pub const SEEDS: u64 = 1 << 32;

/// Outcome of an answer with a fault, by status and correctness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// Status `fault`.
    Fault,
    /// `degraded`, and a reason names the fault.
    Named,
    /// `degraded` for other reasons only.
    Unnamed,
    /// `ok` and correct.
    Right,
    /// `ok` and wrong.
    Wrong,
}

/// The answer to one recording, or guard sweep, with one fault.
pub struct Run {
    /// Outcome by status and correctness.
    pub fate: Fate,
    /// Whether the answer's reasons name the fault.
    pub named: bool,
    /// Text that is printed if the answer is `ok` and wrong.
    pub words: String,
}

/// The recordings that are `ok` and correct without a fault, with counts.
pub struct Clean {
    /// Recordings without a fault, to which the faults are applied.
    pub recordings: Vec<Recording>,
    /// Range of the mirror echo in each recording, 0.01 mm from the radar; 0 for guard sweeps.
    pub mirror_echoes: Vec<i32>,
    /// Number of recordings that were `ok` without a fault, correct or not.
    pub ok: usize,
    /// Number of recordings that were scanned without a fault.
    pub all: usize,
}
