//! What is looked at, and in which units.

use crate::signal::grid::DB_PER_UNIT;
use crate::verdict::Reason;

/// Per cent of rows.
pub const PER_CENT: u32 = 100;

/// Map units of so many decibels.
pub const fn units(db: f32) -> i32 {
    (db / DB_PER_UNIT + 0.5) as i32
}

/// One thing that is looked at: how much of it was seen, and how much of it a healthy instrument may
/// show. The unit is the thing's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sign {
    /// The reason that more of it is.
    pub reason: Reason,
    /// What was seen.
    pub seen: i32,
    /// What may be.
    pub limit: i32,
}
