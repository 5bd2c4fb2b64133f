//! Outcome of one recording, or guard sweep, with one fault.

use host_sim::recording::Recording;

/// First seed of faults, separate from those of scenes: the recording at index `k` has the seed `SEEDS + k`.
pub const SEEDS: u64 = 1 << 32;

/// Outcome of an answer with a fault, by status and correctness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// Status `fault`: no answer is given.
    Fault,
    /// Status `degraded`, and a reason names the fault.
    Named,
    /// Status `degraded` for reasons that do not name the fault.
    Unnamed,
    /// Status `ok`, and the answer is correct despite the fault.
    Right,
    /// Status `ok`, but the answer is wrong: the dangerous outcome.
    Wrong,
}

/// The answer to one recording, or guard sweep, with one fault.
pub struct Run {
    /// Outcome of the answer by status and correctness.
    pub fate: Fate,
    /// Whether the answer's reasons name the fault.
    pub named: bool,
    /// Description of the answer for the list of runs that are `ok` and wrong.
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
