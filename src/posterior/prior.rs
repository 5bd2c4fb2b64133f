//! What stairs people build, and what else stands about: the prior of a hypothesis.

use super::staircase::{GroundKind, LONGEST_GOING_M, Staircase};
use crate::math;

/// Spread that the echoes leave of a place, a rise and one step's own departure, times √(2π), metres:
/// the volume by which a hypothesis with one more of them is the rarer.
const PLACE_M: f32 = 0.006;
/// See [`PLACE_M`].
const RISE_M: f32 = 0.012;
/// See [`PLACE_M`].
const DEPARTURE_M: f32 = 0.008;
/// A flight goes on after a step so often.
pub const GOES_ON: f32 = 0.87;
/// A staircase floats so often.
const FLOATS: f32 = 0.2;
/// A wall stands behind, over the 2.5 m ahead, so often.
const WALL: f32 = 0.4;
/// The way that is looked at, metres.
const WAY_M: f32 = 2.5;
/// Goings that are not those of the flight: so often, evenly over 0.4 m.
const IRREGULAR: f32 = 0.07;

/// Density of a landing's length, per metre: one in thirty flights goes on after one, of up to a metre
/// and more.
pub const LANDING: f32 = 0.03;

/// Natural logarithm of a positive number; that of 10^-30 for what is less.
pub const fn ln(x: f32) -> f32 {
    math::ln(math::max(x, 1e-30))
}

/// Cost of what lies outside a box, with Gaussian shoulders, nats.
fn shoulder(v: f32, low: f32, high: f32, sigma: f32) -> f32 {
    let d = math::max(math::max(low - v, v - high), 0.0) / sigma;
    -0.5 * d * d
}

/// Logarithm of the density of a departure: as a rule small, now and then large.
fn departure(z: f32, core: f32, wide: f32, share: f32) -> f32 {
    let gauss = |s: f32| math::exp(-0.5 * (z / s) * (z / s)) / s;
    ln((1.0 - share) * gauss(core) + share * gauss(wide)) - 0.919
}

/// Overhangs are mostly none.
#[inline(never)]
pub fn overhang(overhang_m: f32) -> f32 {
    let z = overhang_m / 0.002;
    ln(0.5 * math::exp(-0.5 * z * z) + 0.5 * 0.15)
}

/// Density of the going to one more riser, per metre, where the mean of the flight's is known or not.
#[inline(never)]
pub fn going(going_m: f32, mean_m: Option<f32>) -> f32 {
    let within = |low: f32, high: f32| {
        if (low..=high).contains(&going_m) {
            1.0 / (high - low)
        } else {
            0.0
        }
    };
    let wide = within(0.18, 0.60);
    let usual = match mean_m {
        None => within(0.22, 0.40),
        Some(mean_m) => {
            let z = (going_m - mean_m) / 0.012;
            0.4 / 0.012 * math::exp(-0.5 * z * z)
        }
    };
    (1.0 - IRREGULAR) * usual + IRREGULAR * wide
}

/// Logarithm of a hypothesis's prior, times the volume that the echoes leave it.
#[inline(never)]
pub fn prior(s: &Staircase) -> f32 {
    let n = s.len();
    let wall = if s.wall().is_finite() {
        const { ln(WALL / WAY_M * PLACE_M) }
    } else {
        const { ln(1.0 - WALL) }
    };
    let mut p = wall
        + match s.kind {
            GroundKind::Nothing => const { ln(0.31) },
            GroundKind::Ramp => const { ln(0.08 / 12.0) },
            GroundKind::Drop => const { ln(0.03) },
            GroundKind::Stairs => const { ln(0.10) },
            GroundKind::Box => const { ln(0.06) },
            GroundKind::Threshold => const { ln(0.05) },
        };
    if n == 0 {
        return p;
    }
    p += if s.open {
        const { ln(FLOATS) }
    } else {
        const { ln(1.0 - FLOATS) }
    } + const { ln(PLACE_M / WAY_M) }
        + const { ln(RISE_M) };
    let rise = s.rise();
    p += match s.kind {
        GroundKind::Box => -const { ln(0.55) },
        GroundKind::Threshold => -const { ln(0.05) },
        _ => shoulder(rise, if n > 1 { 0.085 } else { 0.05 }, 0.22, 0.02) - const { ln(0.15) },
    };
    if let Some(going) = s.going() {
        p += shoulder(going, 0.22, 0.40, 0.03) + const { ln(PLACE_M / 0.22) };
        for k in 1..n {
            let going_m = s.x(k) - s.x(k - 1);
            p += const { ln(GOES_ON * PLACE_M) }
                + if going_m > LONGEST_GOING_M {
                    const { ln(LANDING) }
                } else {
                    departure(going_m - going, 0.004, 0.02, 0.05)
                };
        }
        for k in 0..n {
            let off = s.level(k + 1) - s.level(k) - rise;
            p += const { ln(DEPARTURE_M) } + departure(off, 0.0035, 0.025, 0.05);
        }
    }
    if !s.open {
        p += overhang(s.overhang_m);
    }
    p
}
