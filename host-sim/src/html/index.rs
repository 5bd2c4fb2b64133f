//! The recordings of a page, and their order in its index.

use serde_json::Value;

/// One recording of a page.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Its name and the data shown on the page.
    pub data: Value,
    /// Rank in the index.
    pub rank: Rank,
}

/// Result of a recording, worst first: the order of the index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rank {
    /// The recording could not be read or scanned.
    Unreadable,
    /// `ok`, and wrong by the recording's ground truth.
    OkAndWrong,
    /// A `fault`.
    Fault,
    /// Not `ok`, and wrong.
    Wrong,
    /// Nothing wrong, but not `ok`.
    Degraded,
    /// `ok`, and correct or without ground truth.
    Ok,
}
