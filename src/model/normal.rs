//! The normal distribution, its tail, densities with heavier tails or with shoulders, and a logarithm of densities that
//! may be 0.

use crate::math;
use crate::params::posterior::{self, Deviations, Limits};

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
    logistic(-posterior::NORMAL_SLOPE * z)
}

/// Returns a Gaussian density with heavy tails over the squared deviation in standard deviations. It must be divided
/// by the standard deviations and √(2π).
pub fn tailed(z2: f32) -> f32 {
    if z2 > posterior::TAIL_END_Z2 {
        return posterior::TAIL_END;
    }
    let wide = 1.0 / (1.0 + z2 / posterior::TAIL_Z2);
    let wide = posterior::TAIL_SHARE * (wide * wide) * (wide * wide);
    if z2 > CORE {
        return wide;
    }
    posterior::CORE_SHARE * math::exp(-0.5 * z2) + wide
}

/// Returns the natural logarithm of `x`; that of 10^-30 for smaller arguments.
pub const fn ln(x: f32) -> f32 {
    math::ln(math::max(x, posterior::MIN_PROBABILITY))
}

/// Returns the logarithm, nats, of a density that is even, 1, between two limits and falls outside as a Gaussian of
/// standard deviation `sigma`.
pub fn shoulder(v: f32, even: Limits, sigma: f32) -> f32 {
    let d = math::max(math::max(even.low - v, v - even.high), 0.0) / sigma;
    -0.5 * d * d
}

/// Returns the log-density of a deviation `z`, metres.
pub fn departure(z: f32, of: Deviations) -> f32 {
    let gauss = |s: f32| math::exp(-0.5 * (z / s) * (z / s)) / s;
    ln((1.0 - of.wide_share) * gauss(of.core_m) + of.wide_share * gauss(of.wide_m))
        - posterior::LN_ROOT_TAU
}
