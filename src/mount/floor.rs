//! Check that the ground lies where mounting height and angle put it.
//!
//! Calibration corrects errors only within the tolerance of tyres, brackets and homing switch. A larger error
//! shows here: the echoes then support a ground that is higher, lower or inclined better than the configured
//! one.

use crate::math;
use crate::params::Params;
use crate::signal::echoes::{Echo, MAX_ECHOES};

/// Power n of (1 - q/n)^n, by which an echo's weight exp(-q) is approximated at a tenth of the instructions.
const REACH: f32 = 4.0;
/// Maximum number of tested ground heights to each side of the configured one.
const MAX_HEIGHT_STEPS: usize = 24;

/// Distances from the mirror at which the ground may begin to slope, metres: from where its nearest echoes show whether it
/// is level before.
const BENDS_FROM_M: [f32; 5] = [0.4, 0.6, 0.8, 1.0, 1.2];
/// Slopes of ground that a chair may drive, up or down: up to 12 % (ramps of ISO 21542 have 5 to 8 %).
const SLOPES: [f32; 6] = [0.02, 0.04, 0.06, 0.08, 0.1, 0.12];
/// Evidence by which a bend must exceed ground without one: half an echo 18 dB above the noise.
const MIN_BEND: f32 = 0.5;

/// Returns the variance of a ground echo's height at `range_m` metres from the mirror, square metres. Corners,
/// which are strong and narrow, have a smaller variance in angle and height than speckle.
pub fn floor_variance(e: &Echo, range_m: f32, p: &Params) -> f32 {
    let clean = e.snr_db > p.floor_corner_db && e.width < p.floor_corner_width;
    let (fixed_rad, rough_m) = if clean {
        (p.floor_corner_rad, p.floor_corner_m)
    } else {
        (p.floor_speckle_rad, p.floor_speckle_m)
    };
    let noise = range_m * (fixed_rad + p.floor_noise_rad * math::amplitude(-e.snr_db));
    rough_m * rough_m + noise * noise
}

/// A ground echo with its place and its weight as evidence for a ground at some height.
#[derive(Clone, Copy, Debug, Default)]
struct GroundEcho {
    x_m: f32,
    y_m: f32,
    /// Half of the inverse variance of the echo's height above the ground, 1/m².
    half_precision: f32,
    /// Height difference between echo and ground beyond which the echo is no evidence for that ground, metres.
    reach_m: f32,
    weight: f32,
}

impl GroundEcho {
    fn new(e: &Echo, bin_m: f32, p: &Params) -> Self {
        let model = p.witness_sigma_bins * bin_m * p.witness_sigma_bins * bin_m;
        let weight = (e.snr_db - p.witness_from_db) / p.witness_span_db;
        let half_precision = 0.5 / (floor_variance(e, e.range_m, p) + model);
        Self {
            x_m: e.x_m,
            y_m: e.y_m,
            half_precision,
            reach_m: math::sqrt(REACH / half_precision),
            weight: math::min(math::max(weight, 0.0), p.witness_most),
        }
    }

    /// Returns the echo's weight for a ground that lies `ground_m` metres above the configured one where the echo is.
    fn agrees(&self, ground_m: f32) -> f32 {
        let off = self.y_m - ground_m;
        let base = math::max(0.0, 1.0 - off * off * self.half_precision / REACH);
        self.weight * (base * base) * (base * base)
    }

    /// Adds the echo's weight to `supports`. Entry k is for a ground that falls forward by `slope` (radians) and that
    /// lies, straight below the mirror, `lowest_m` + k · `step_m` metres above the configured ground.
    fn support(&self, slope: f32, lowest_m: f32, step_m: f32, supports: &mut [f32]) {
        let above_m = self.y_m + slope * self.x_m - lowest_m;
        let first = math::max(math::ceil((above_m - self.reach_m) / step_m), 0.0) as usize;
        // The cast saturates: negative values become 0.
        let end = (math::floor((above_m + self.reach_m) / step_m) + 1.0) as usize;
        for (k, support) in supports.iter_mut().enumerate().take(end).skip(first) {
            *support += self.agrees(self.y_m - above_m + k as f32 * step_m);
        }
    }
}

/// Evidence for the ground at and away from its configured place, each a sum of echoes' weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundEvidence {
    /// Maximum of the evidence (sum of echoes' weights) over grounds whose height and slope are within the tolerance of
    /// the configured ones.
    pub configured: f32,
    /// Maximum of the evidence (sum of echoes' weights) over all other tested grounds: at another height, or inclined.
    pub other: f32,
    /// Distance from the mirror up to which the ground is as configured, metres; from there on it slopes. Infinite where
    /// no slope has more evidence.
    pub level_to_m: f32,
}

impl Default for GroundEvidence {
    fn default() -> Self {
        Self {
            configured: 0.0,
            other: 0.0,
            level_to_m: f32::INFINITY,
        }
    }
}

impl GroundEvidence {
    /// Returns whether the ground is at its configured place: no other place has much more evidence, and the
    /// configured one is not without evidence beside a well supported other.
    pub fn in_place(&self, p: &Params) -> bool {
        let alone = self.other > p.floor_alone && self.configured < p.floor_here_share * self.other;
        self.other - self.configured <= p.floor_elsewhere && !alone
    }

    /// Returns whether the evidence confirms the configured mounting: it is clearly larger than for any other
    /// ground.
    pub fn confirmed(&self, p: &Params) -> bool {
        self.configured > self.other + p.floor_firm
    }

    /// Computes the evidence from the echoes of a map with bins of `bin_m` metres, placed without any
    /// calibration.
    #[inline(never)]
    pub fn of(echoes: &[Echo], bin_m: f32, p: &Params) -> Self {
        let mut witnesses = heapless::Vec::<GroundEcho, MAX_ECHOES>::new();
        for e in echoes {
            let ahead = e.x_m > p.floor_from_m && e.x_m < p.floor_to_m;
            if ahead && e.y_m.abs() < p.floor_astray_m && e.snr_db > p.witness_from_db {
                // The vector has room for all echoes.
                let _ = witnesses.push(GroundEcho::new(e, bin_m, p));
            }
        }
        let step_m = p.floor_height_step_m;
        let (near, tilt) = (p.floor_near_steps as i32, p.floor_tilt_steps as i32);
        let far = (p.floor_far_steps as i32).min(MAX_HEIGHT_STEPS as i32);
        let steep = p.floor_steep_steps as i32;
        let mut found = Self::default();
        for slope in -steep..=steep {
            // An inclined ground passes through the wheels' contact point.
            let tilted = slope.abs() > tilt;
            let most = if tilted { near } else { far };
            let mut supports = [0.0; 2 * MAX_HEIGHT_STEPS + 1];
            let supports = supports.get_mut(..2 * most as usize + 1).unwrap_or(&mut []);
            for w in &witnesses {
                let slope = slope as f32 * p.floor_slope_step_rad;
                w.support(slope, -(most as f32) * step_m, step_m, supports);
            }
            for (height, &mut support) in (-most..=most).zip(supports) {
                let best = if tilted || height.abs() > near {
                    &mut found.other
                } else {
                    &mut found.configured
                };
                *best = math::max(*best, support);
            }
        }
        found.bend(&witnesses);
        found
    }

    /// Counts grounds as configured, too, that are level at the configured height and slope from some distance on. A
    /// mounting that is tilted shows no level ground before the slope.
    #[inline(never)]
    fn bend(&mut self, witnesses: &[GroundEcho]) {
        for from_m in BENDS_FROM_M {
            for slope in SLOPES.into_iter().flat_map(|slope| [slope, -slope]) {
                let height_m = |x_m: f32| slope * math::max(x_m - from_m, 0.0);
                let agree = witnesses.iter().map(|w| w.agrees(height_m(w.x_m)));
                let support: f32 = agree.sum();
                if support > self.configured + MIN_BEND {
                    (self.configured, self.level_to_m) = (support - MIN_BEND, from_m);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const P: &Params = &Params::DEFAULT;

    #[test]
    fn a_floor_that_is_only_seen_elsewhere_is_out_of_place() {
        let floor = |configured, other| GroundEvidence {
            configured,
            other,
            ..GroundEvidence::default()
        };
        for fits in [(0.0, 0.0), (0.0, 0.4), (0.3, 1.0), (1.5, 1.5), (3.0, 4.3)] {
            assert!(floor(fits.0, fits.1).in_place(P), "{fits:?}");
        }
        for off in [(0.0, 0.6), (0.2, 1.0), (0.0, 1.5), (3.0, 4.5)] {
            assert!(!floor(off.0, off.1).in_place(P), "{off:?}");
        }
        assert!(floor(1.5, 1.3).confirmed(P) && !floor(1.5, 1.5).confirmed(P));
        assert!(!floor(0.0, 0.0).confirmed(P));
    }
}
