//! Threshold: a single object on the ground, too low for a step.

use super::variation::SingleRise;
use crate::model::normal::ln;
use crate::model::surfaces::Surfaces;

/// Prior probability of a threshold.
const THRESHOLD: f32 = 0.05;
/// Range of a threshold's heights, metres.
const HEIGHTS_M: f32 = 0.05;
/// Thresholds on level ground. Those without an echo do not change the answer.
pub const SINGLE: &[SingleRise] = &[
    SingleRise::new(0.02, 0.5, 0.0),
    SingleRise::new(0.045, 0.05, 0.0),
];

/// Returns the log-prior of a threshold, nats.
pub fn log_prior() -> f32 {
    const { ln(THRESHOLD) }
}

/// Returns the log-density of a threshold's height, nats.
pub fn log_prior_of_rise() -> f32 {
    -const { ln(HEIGHTS_M) }
}

/// Returns the log-likelihood ratio, from the ground's line, of a threshold at `x_m`, metres, to ground that goes on,
/// nats: behind it the ground is visible again.
pub fn ground_line(line: &Surfaces, x_m: f32) -> f32 {
    line.bump_at(x_m)
}
