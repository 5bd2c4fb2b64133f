//! A measured value with its variance, and the tolerances of a reported length.

use crate::math;

/// Minimum expanded uncertainty of a reported length, metres; part of the design contract of the status `ok`.
pub const MIN_EXPANDED_M: f32 = 0.03;
/// Maximum expanded uncertainty of a length that counts as measured, metres; part of the design contract of the status
/// `ok`.
pub const MAX_EXPANDED_M: f32 = 0.08;
/// Coverage factor: ratio of expanded uncertainty to standard deviation.
pub const COVERAGE_FACTOR: f32 = 3.0;

/// Returns the expanded uncertainty U of a reported length of standard deviation `sigma_m`, metres: U = max(3
/// cm, 3σ).
pub fn expanded(sigma_m: f32) -> f32 {
    math::max(MIN_EXPANDED_M, COVERAGE_FACTOR * sigma_m)
}

/// A value with its variance, in the value's unit and its square.
///
/// ```
/// use stairscan::estimate::Estimate;
///
/// let height_m = Estimate::new(0.165, 0.004);
/// assert!((height_m.variance - 1.6e-5).abs() < 1e-9);
/// assert!((height_m.sigma() - 0.004).abs() < 1e-7);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f32,
    /// The value's variance, in the square of its unit.
    pub variance: f32,
}

impl Estimate {
    /// Creates an estimate from a value and its standard deviation.
    pub const fn new(value: f32, sigma: f32) -> Self {
        Self {
            value,
            variance: sigma * sigma,
        }
    }

    /// Returns the standard deviation.
    pub fn sigma(&self) -> f32 {
        math::sqrt(self.variance)
    }
}
