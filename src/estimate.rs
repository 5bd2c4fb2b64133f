//! A measured value and how well it is known.

use crate::math;

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
    /// Its variance.
    pub variance: f32,
}

impl Estimate {
    /// From a value and its standard deviation.
    pub const fn new(value: f32, sigma: f32) -> Self {
        Self {
            value,
            variance: sigma * sigma,
        }
    }

    /// The standard deviation.
    pub fn sigma(&self) -> f32 {
        math::sqrt(self.variance)
    }
}
