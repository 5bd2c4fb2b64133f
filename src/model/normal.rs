//! The normal distribution, its tail, and a density with wider tails.

use crate::math;
use crate::params::posterior as number;

/// The tail beyond so many standard deviations is taken for 0.
const SURE: f32 = 6.0;
/// Beyond this squared deviation only the tails are left.
const CORE: f32 = 25.0;

/// Logistic function.
pub fn logistic(x: f32) -> f32 {
    1.0 / (1.0 + math::exp(-x))
}

/// Upper tail of the normal distribution by the logistic function: within 0.01 of it.
pub fn above(z: f32) -> f32 {
    if z.abs() > SURE {
        return if z > 0.0 { 0.0 } else { 1.0 };
    }
    logistic(-number::NORMAL_SLOPE * z)
}

/// A Gaussian with wide tails, not normalised by its standard deviations.
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
