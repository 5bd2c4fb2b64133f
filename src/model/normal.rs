//! The normal distribution, its tail, and a density with heavier tails.

use crate::math;
use crate::params::posterior as number;

/// Number of standard deviations beyond which the normal distribution's tail counts as 0.
const SURE: f32 = 6.0;
/// Squared deviation, in squared standard deviations, beyond which only the heavy tails of the density remain.
const CORE: f32 = 25.0;

/// Returns the logistic function 1 / (1 + e^-x).
pub fn logistic(x: f32) -> f32 {
    1.0 / (1.0 + math::exp(-x))
}

/// Returns the probability that a standard normal variable exceeds `z`, approximated by the logistic function to within
/// 0.01.
pub fn above(z: f32) -> f32 {
    if z.abs() > SURE {
        return if z > 0.0 { 0.0 } else { 1.0 };
    }
    logistic(-number::NORMAL_SLOPE * z)
}

/// Returns a Gaussian density with heavy tails over the squared deviation in standard deviations. It must be divided
/// by the standard deviations and √(2π).
pub fn tailed(z2: f32) -> f32 {
    if z2 > number::TAIL_END_Z2 {
        return number::TAIL_END;
    }
    let wide = 1.0 / (1.0 + z2 / number::TAIL_Z2);
    let wide = number::TAIL_SHARE * (wide * wide) * (wide * wide);
    if z2 > CORE {
        return wide;
    }
    number::CORE_SHARE * math::exp(-0.5 * z2) + wide
}
