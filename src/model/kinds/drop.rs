//! Drop: ground that ends at an edge to lower ground, or at a hole.

use crate::model::normal::ln;
use crate::model::surfaces::{SLOT_M, SLOTS, Surfaces};
use crate::params::posterior;

/// Prior probability of a drop.
const DROP: f32 = 0.03;
/// Density of echoes behind a drop's edge, relative to that in the air.
const DENSITY_FACTOR: f32 = 3.0;
/// Minimum distance from the mirror at which a scan can show that the ground ends, metres.
const FIRST_M: f32 = 0.3;
/// Prior odds of a drop anywhere ahead against level ground.
const ODDS: f32 = 0.3;

/// Returns the log-prior of a drop, nats.
pub fn log_prior() -> f32 {
    const { ln(DROP) }
}

/// Returns the log-likelihood ratio, from the ground's line, of ground that ends at `at_m`, metres, to ground that goes
/// on, nats.
pub fn ground_line(line: &Surfaces, at_m: f32) -> f32 {
    line.drop_at(at_m)
}

/// Returns the density of echoes behind the edge from that of echoes in the air.
pub fn density(air: f32) -> f32 {
    DENSITY_FACTOR * air
}

/// Returns the places at which the ground's end is tried before a wall at `wall_m`, one for each slot of the ground's
/// line; metres.
pub fn places(wall_m: f32) -> impl Iterator<Item = f32> {
    let (first, end) = (FIRST_M / SLOT_M, wall_m / SLOT_M);
    (first as usize..SLOTS.min(end as usize)).map(|k| (k as f32 + 0.5) * SLOT_M)
}

/// Returns the logarithm of the prior odds of a drop at one of these places against level ground, nats.
pub fn log_odds() -> f32 {
    ln(ODDS * SLOT_M / posterior::FLOOR_WAY_M)
}
