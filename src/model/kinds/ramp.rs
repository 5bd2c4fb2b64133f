//! Ramp: ground with a constant slope from a place on. Going up, a gentle one is found before all else, with the mounting
//! ([`crate::mount`]), and what stands ahead stands on it; here are those that are steeper.

use crate::answer::Slope;
use crate::model::normal::ln;

/// Prior probability of a ramp, shared among [`RAMPS`] slopes.
const RAMP: f32 = 0.08;
/// Number of slopes that share [`RAMP`].
const RAMPS: f32 = 12.0;
/// Distances from the mirror at which the ramps going up begin, metres.
const FROM_M: [f32; 5] = [0.4, 0.55, 0.7, 0.85, 1.0];
/// Slopes of the ramps going up, metres of rise per metre: beyond those of the ground, up to 12 degrees.
const STEEP: [f32; 4] = [0.13, 0.155, 0.18, 0.21];
/// Distances at which ramps downwards begin, metres from the mirror.
const DOWN_FROM_M: [f32; 3] = [0.0, -0.1, -0.2];
/// Slopes of ramps downwards: tan of 1° … 12° in steps of a degree.
const DOWN_SLOPES: [f32; 12] = [
    0.0175, 0.0349, 0.0524, 0.0699, 0.0875, 0.1051, 0.1228, 0.1405, 0.1584, 0.1763, 0.1944, 0.2126,
];

/// Returns the log-prior of a ramp, nats.
pub fn log_prior() -> f32 {
    const { ln(RAMP / RAMPS) }
}

/// Returns the ramps going up that are tried.
pub fn steep() -> impl Iterator<Item = Slope> {
    let slopes = |from_m| STEEP.into_iter().map(move |slope| Slope { from_m, slope });
    FROM_M.into_iter().flat_map(slopes)
}

/// Returns the ramps going down that are tried.
pub fn down() -> impl Iterator<Item = Slope> {
    let places = |fall: f32| {
        DOWN_FROM_M.into_iter().map(move |from_m| Slope {
            from_m,
            slope: -fall,
        })
    };
    DOWN_SLOPES.into_iter().flat_map(places)
}
