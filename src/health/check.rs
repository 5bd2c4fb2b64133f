//! Result of a health check, and conversion of its limits from dB to map units.

use crate::signal::grid::DB_PER_UNIT;
use crate::verdict::Reason;

/// Factor from fractions to per cent.
pub const PER_CENT: u32 = 100;

/// Converts a level difference, dB and not negative, to map units of 0.376 dB, rounded.
pub const fn units(db: f32) -> i32 {
    (db / DB_PER_UNIT + 0.5) as i32
}

/// Result of one health check: the measured value and its limit, in the check's own unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CheckResult {
    /// Reason that is reported if the value exceeds the limit.
    pub reason: Reason,
    /// Measured value, in the unit of the check that `reason` names.
    pub value: i32,
    /// Maximum value of a healthy instrument, in the same unit as `value`.
    pub limit: i32,
}
