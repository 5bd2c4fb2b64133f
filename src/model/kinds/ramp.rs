//! Ramp: ground with a constant slope from a place on.

use crate::math;
use crate::model::normal::ln;
use crate::model::surfaces::{SLOT_M, Surfaces};

/// Prior probability of a ramp, shared among [`RAMPS`] slopes.
const RAMP: f32 = 0.08;
/// Number of slopes that share [`RAMP`].
const RAMPS: f32 = 12.0;
/// Number of slots of the ground's line from a ramp's beginning after which the ramp has left that line.
const LEAVES: usize = 8;
/// Distances from the mirror at which the ramps of the grid begin, going up, metres.
const FROM_M: [f32; 3] = [0.4, 0.8, 1.2];
/// Slopes of the ramps of the grid, going up, metres of rise per metre.
const SLOPES: [f32; 4] = [0.06, 0.09, 0.13, 0.18];
/// Steps by which the best ramp of the grid is moved to each side: coarse, then fine. A move is kept if it increases the
/// weight.
const MOVES: [Slope; 2] = [
    Slope {
        from_m: 0.2,
        slope: 0.02,
    },
    Slope {
        from_m: 0.1,
        slope: 0.01,
    },
];
/// Distances at which ramps downwards begin, metres from the mirror.
const DOWN_FROM_M: [f32; 3] = [0.0, -0.1, -0.2];
/// Slopes of ramps downwards: tan of 1° … 12° in steps of a degree.
const DOWN_SLOPES: [f32; 12] = [
    0.0175, 0.0349, 0.0524, 0.0699, 0.0875, 0.1051, 0.1228, 0.1405, 0.1584, 0.1763, 0.1944, 0.2126,
];

/// Beginning and slope of a ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// Distance from the mirror at which the slope begins, metres.
    pub from_m: f32,
    /// Rise per metre; negative going down.
    pub slope: f32,
}

impl Slope {
    /// Returns the height of the ramp at distance `x_m`, metres above the ground before it.
    pub fn height_m(&self, x_m: f32) -> f32 {
        self.slope * math::max(x_m - self.from_m, 0.0)
    }
}

/// Returns the log-prior of a ramp, nats.
pub fn log_prior() -> f32 {
    const { ln(RAMP / RAMPS) }
}

/// Returns the log-likelihood ratio, from the ground's line, of a ramp that begins at `from_m`, metres, to ground that
/// goes on, nats.
pub fn ground_line(line: &Surfaces, from_m: f32) -> f32 {
    let places = (0..LEAVES).map(|k| line.rise_at(from_m + SLOT_M * k as f32));
    places.fold(0.0, math::max)
}

/// Proposes ramps going up: those of a grid, and the best of them moved by coordinate search. `weigh` returns the
/// log-weight of a ramp, nats.
pub fn propose(weigh: &mut dyn FnMut(Slope) -> f32) {
    let mut best = Best::default();
    for from_m in FROM_M {
        for slope in SLOPES {
            best.add(Slope { from_m, slope }, weigh);
        }
    }
    for by in MOVES {
        let Some(Slope { from_m, slope }) = best.slope else {
            return;
        };
        for (from_m, slope) in [
            (from_m - by.from_m, slope),
            (from_m + by.from_m, slope),
            (from_m, slope - by.slope),
            (from_m, slope + by.slope),
        ] {
            best.add(Slope { from_m, slope }, weigh);
        }
    }
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

/// The ramp of the greatest weight so far; the first of equal ones.
#[derive(Default)]
struct Best {
    slope: Option<Slope>,
    log_weight: f32,
}

impl Best {
    fn add(&mut self, slope: Slope, weigh: &mut dyn FnMut(Slope) -> f32) {
        let log_weight = weigh(slope);
        if self.slope.is_none() || log_weight > self.log_weight {
            (self.slope, self.log_weight) = (Some(slope), log_weight);
        }
    }
}
