//! One recording with one fault, and how its run ends.

use crate::recording::Recording;

/// Seeds of fault draws, apart from those of scenes: one per recording.
pub const SEEDS: u64 = 1 << 32;

/// End of one run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// No answer.
    Fault,
    /// Degraded, and the reason names the fault.
    Named,
    /// Degraded for another reason.
    Unnamed,
    /// `ok`, and so it is.
    Right,
    /// `ok`, and it is not.
    Wrong,
}

/// One recording with one fault.
pub struct Run {
    /// How it ended.
    pub fate: Fate,
    /// Whether its reasons name the fault.
    pub named: bool,
    /// Line that is printed for it if it is `ok` and wrong.
    pub words: String,
}

/// The recordings that are `ok` and right without a fault, and how many there were in all.
pub struct Clean {
    /// They.
    pub recordings: Vec<Recording>,
    /// Where each shows the mirror's own echo, 0.01 mm from the radar.
    pub mirror_echoes: Vec<i32>,
    /// How many were `ok`.
    pub ok: usize,
    /// How many there were.
    pub all: usize,
}
