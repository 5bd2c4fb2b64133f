//! The recordings of a page, and their order in its index.

use serde_json::Value;

/// One recording of a page, with its rank.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Name of the recording, and everything that the page shows of it, as JSON.
    pub data: Value,
    /// Rank of the recording in the index.
    pub rank: Rank,
}

/// Worst result among a recording's answers; the index lists recordings in this order, worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rank {
    /// The recording could not be read or scanned.
    Unreadable,
    /// An answer is `ok`, but wrong by the recording's ground truth.
    OkAndWrong,
    /// An answer is a `fault`.
    Fault,
    /// An answer is wrong by the ground truth, and not `ok`.
    Wrong,
    /// An answer is `degraded`; none is wrong.
    Degraded,
    /// All answers are `ok`, and correct or without ground truth.
    Ok,
}
