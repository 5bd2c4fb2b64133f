//! Stairs going up: risers, with the heights of their tops. A single step is a staircase of one riser.
//!
//! The search (`infer::propose`) proposes them.

use super::variation::{SingleRise, Variation};
use crate::math;
use crate::model::normal::{ln, shoulder};
use crate::model::surfaces::Surfaces;
use crate::params::posterior::Limits;

/// Prior probability of stairs that begin at one place.
const STAIRS: f32 = 0.10;
/// Minimum usual rise of a flight, metres.
const LOWEST_RISE_M: f32 = 0.085;
/// Minimum usual rise of a single step, metres.
const LOWEST_STEP_M: f32 = 0.05;
/// Maximum usual rise, metres.
const HIGHEST_RISE_M: f32 = 0.22;
/// Standard deviation of the Gaussian shoulders of the usual rises, metres.
const RISE_SHOULDER_M: f32 = 0.02;
/// Integral of the rises' prior with its shoulders, metres.
const RISE_VOLUME_M: f32 = 0.15;
/// Variants of stairs.
pub const VARIATIONS: &[Variation] = &[
    Variation::FewerRisers,
    Variation::OneMoreRiser,
    Variation::IrregularRiser,
];
/// Single steps on level ground. Those without an echo look the same at any height.
pub const SINGLE: &[SingleRise] = &[
    SingleRise::new(0.075, 0.08, 0.13),
    SingleRise::new(0.11, 0.10, 0.0),
    SingleRise::new(0.16, 0.14, 0.25),
    SingleRise::new(0.22, 0.06, 0.0),
];

/// Returns the log-prior of stairs, nats.
pub fn log_prior() -> f32 {
    const { ln(STAIRS) }
}

/// Returns the log-density of the mean rise `rise_m` of `risers` risers, metres; nats.
pub fn log_prior_of_rise(risers: usize, rise_m: f32) -> f32 {
    let lowest = if risers > 1 {
        LOWEST_RISE_M
    } else {
        LOWEST_STEP_M
    };
    shoulder(rise_m, Limits::new(lowest, HIGHEST_RISE_M), RISE_SHOULDER_M)
        - const { ln(RISE_VOLUME_M) }
}

/// Returns the log-likelihood ratio, from the ground's line, of a first riser at `x_m`, metres, to ground that goes on,
/// nats. With `open` treads the ground may still be visible between them.
pub fn ground_line(line: &Surfaces, x_m: f32, open: bool) -> f32 {
    if open {
        math::max(line.rise_at(x_m), line.bump_at(x_m))
    } else {
        line.rise_at(x_m)
    }
}
