//! Ramp: ground that falls with a constant slope, beside stairs going down. Going up, the slope of the ground is found before
//! all else ([`crate::mount`]), and what stands ahead stands on it.

use crate::answer::Slope;
use crate::model::normal::ln;

/// Prior probability of a ramp, shared among [`RAMPS`] slopes.
const RAMP: f32 = 0.08;
/// Number of slopes that share [`RAMP`].
const RAMPS: f32 = 12.0;
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

/// Proposes the ramps going down of a grid. `weigh` returns the log-weight of a ramp, nats.
pub fn propose_down(weigh: &mut dyn FnMut(Slope) -> f32) {
    for fall in DOWN_SLOPES {
        for from_m in DOWN_FROM_M {
            weigh(Slope {
                from_m,
                slope: -fall,
            });
        }
    }
}
