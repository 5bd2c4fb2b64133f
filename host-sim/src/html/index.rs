//! The recordings of a page, and their order in its index.

use serde_json::Value;

/// One recording of a page.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Its name, and what the page shows of it.
    pub data: Value,
    /// Where it stands in the index.
    pub rank: Rank,
}

/// How bad an answer is, the worst first: the order of the index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rank {
    /// It could not be read or scanned.
    Unreadable,
    /// `ok`, and wrong by the recording's own truth.
    OkAndWrong,
    /// A `fault`.
    Fault,
    /// Not `ok`, and wrong.
    Wrong,
    /// Nothing wrong, but not `ok`.
    Degraded,
    /// `ok`, and right as far as one knows.
    Ok,
}
