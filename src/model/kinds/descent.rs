//! Stairs going down: edges, with the heights of the treads below them.
//!
//! `infer::propose::descending` proposes them; [`crate::model::treads`] is their measurement model. All hypotheses are
//! proposed, and none is varied.

use super::stairs;
use crate::model::surfaces::Surfaces;

/// Returns the log-prior of stairs going down, nats: that of stairs going up.
pub fn log_prior() -> f32 {
    stairs::log_prior()
}

/// Returns the log-density of the mean rise `rise_m` of `edges` edges, metres, negative; nats.
pub fn log_prior_of_rise(edges: usize, rise_m: f32) -> f32 {
    stairs::log_prior_of_rise(edges, rise_m)
}

/// Returns the log-likelihood ratio, from the ground's line, of a first edge at `x_m`, metres, to ground that goes on,
/// nats.
pub fn ground_line(line: &Surfaces, x_m: f32, open: bool) -> f32 {
    stairs::ground_line(line, x_m, open)
}
