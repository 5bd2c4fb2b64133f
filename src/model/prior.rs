//! Prior of a hypothesis: frequency of stairs as they are built, and of the alternatives.

use super::kinds::{WAY_M, wall};
use super::normal::{departure, ln, shoulder};
use super::staircase::Staircase;
use crate::math;
use crate::params::posterior::{
    self, LANDING_PER_M, Limits, P_CONTINUES, P_IRREGULAR_GOING, P_OPEN,
};

/// Width of the posterior of each place, height and deviation of a hypothesis, metres: √(2π) times their standard
/// deviation of 9 mm. It is the penalty of a hypothesis with one more of them. With less than half of it flights end
/// too early, with twice as much they go on too long.
const VOLUME_M: f32 = 0.0225;

/// Returns the log-prior of an overhang, nats: a narrow normal density about 0, and an even density of large overhangs.
#[inline(never)]
pub fn overhang(overhang_m: f32) -> f32 {
    let z = overhang_m / posterior::OVERHANG_SIGMA_M;
    ln(0.5 * math::exp(-0.5 * z * z) + 0.5 * posterior::OVERHANG_LARGE)
}

/// Returns the density of the going to one more riser, per metre. `mean_m` is the mean going of the flight, if known.
#[inline(never)]
pub fn going(going_m: f32, mean_m: Option<f32>) -> f32 {
    let within = |Limits { low, high }| {
        if (low..=high).contains(&going_m) {
            1.0 / (high - low)
        } else {
            0.0
        }
    };
    let wide = within(posterior::GOINGS_M);
    let usual = match mean_m {
        None => within(posterior::USUAL_GOINGS_M),
        Some(mean_m) => {
            let z = (going_m - mean_m) / posterior::GOING_SIGMA_M;
            posterior::PER_ROOT_TAU / posterior::GOING_SIGMA_M * math::exp(-0.5 * z * z)
        }
    };
    (1.0 - P_IRREGULAR_GOING) * usual + P_IRREGULAR_GOING * wide
}

/// Returns the log-prior of a hypothesis, nats, plus the logarithm of the volume of its parameters after the echoes are
/// known: both together weight its log-likelihood at the best parameters.
#[inline(never)]
pub fn prior(s: &Staircase) -> f32 {
    let n = s.len();
    let mut p = wall::log_prior(s.wall_m) + s.kind.log_prior();
    if n == 0 {
        return p;
    }
    p += if s.open {
        const { ln(P_OPEN) }
    } else {
        const { ln(1.0 - P_OPEN) }
    } + const { ln(VOLUME_M / WAY_M) }
        + const { ln(VOLUME_M) };
    let rise = s.rise();
    p += s.kind.log_prior_of_rise(n, rise);
    if let Some(going) = s.going() {
        p += shoulder(
            going,
            posterior::USUAL_GOINGS_M,
            posterior::GOING_SHOULDER_M,
        ) + const { ln(VOLUME_M / posterior::GOING_VOLUME_M) };
        for k in 1..n {
            let going_m = s.x(k) - s.x(k - 1);
            p += const { ln(P_CONTINUES * VOLUME_M) }
                + if going_m > posterior::GOINGS_M.high {
                    const { ln(LANDING_PER_M) }
                } else {
                    departure(going_m - going, posterior::GOING_DEPARTS)
                };
        }
        for k in 0..n {
            let off = s.level(k + 1) - s.level(k) - rise;
            p += const { ln(VOLUME_M) } + departure(off, posterior::RISE_DEPARTS);
        }
    }
    if !s.open {
        p += overhang(s.overhang_m);
    }
    p
}
