//! Box: a single object on the ground, too tall to climb.

use super::stairs;
use super::variation::SingleRise;
use crate::model::normal::ln;
use crate::model::surfaces::Surfaces;

/// Prior probability of a box.
const BOX: f32 = 0.06;
/// Range of a box's heights, metres.
const HEIGHTS_M: f32 = 0.55;
/// Boxes on level ground. Those without an echo do not change the answer.
pub const SINGLE: &[SingleRise] = &[
    SingleRise::new(0.32, 0.15, 0.0),
    SingleRise::new(0.50, 0.15, 0.0),
];

/// Returns the log-prior of a box, nats.
pub fn log_prior() -> f32 {
    const { ln(BOX) }
}

/// Returns the log-density of a box's height, nats.
pub fn log_prior_of_rise() -> f32 {
    -const { ln(HEIGHTS_M) }
}

/// Returns the log-likelihood ratio, from the ground's line, of a box at `x_m`, metres, to ground that goes on, nats.
pub fn ground_line(line: &Surfaces, x_m: f32, open: bool) -> f32 {
    stairs::ground_line(line, x_m, open)
}
