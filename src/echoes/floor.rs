//! Whether the floor is where mount height and angle say that it must be.
//!
//! Only so much is taken out by calibration as tyres, brackets and a homing switch leave. What lies beyond
//! shows here: echoes then fit a floor that is higher, lower or inclined better than the one there must be.

use super::echo::Echo;
use crate::math;
use crate::params::Params;

/// Power at which (1 - q/n)^n stands for exp(-q).
const REACH: f32 = 4.0;

/// An echo as evidence for a floor.
#[derive(Clone, Copy, Debug, Default)]
struct Witness {
    x_m: f32,
    y_m: f32,
    /// Half of the inverse variance of its height.
    half_precision: f32,
    weight: f32,
}

impl Witness {
    fn new(e: &Echo, bin_m: f32, p: &Params) -> Self {
        let clean = e.snr_db > p.floor_corner_db && e.width < p.floor_corner_width;
        let (fixed_rad, rough_m) = if clean {
            (p.floor_corner_rad, p.floor_corner_m)
        } else {
            (p.floor_speckle_rad, p.floor_speckle_m)
        };
        let noise = e.range_m * (fixed_rad + p.floor_noise_rad * math::amplitude(-e.snr_db));
        let model = p.witness_sigma_bins * bin_m * p.witness_sigma_bins * bin_m;
        let weight = (e.snr_db - p.witness_from_db) / p.witness_span_db;
        Self {
            x_m: e.x_m,
            y_m: e.y_m,
            half_precision: 0.5 / (rough_m * rough_m + noise * noise + model),
            weight: weight.clamp(0.0, p.witness_most),
        }
    }

    /// How much it speaks for a floor `height_m` off its place and inclined by `slope`.
    fn support(&self, height_m: f32, slope: f32) -> f32 {
        let off = self.y_m - height_m + slope * self.x_m;
        // (1 - q/4)^4 is exp(-q) for all that matters, and a tenth of its instructions.
        let base = math::max(0.0, 1.0 - off * off * self.half_precision / REACH);
        self.weight * (base * base) * (base * base)
    }
}

/// The evidence for floors.
struct Witnesses(heapless::Vec<Witness, { super::MAX_ECHOES }>);

impl Witnesses {
    fn support(&self, height_m: f32, slope: f32) -> f32 {
        self.0.iter().map(|w| w.support(height_m, slope)).sum()
    }

    /// The best support over heights and slopes that are multiples of `steps` of the first two
    /// numbers, each within the bounds; of those that `keep` lets pass.
    fn best(&self, bounds: [i32; 2], p: &Params, keep: impl Fn(i32, i32) -> bool) -> f32 {
        let mut best = 0.0;
        for height in -bounds[0]..=bounds[0] {
            for slope in (-bounds[1]..=bounds[1]).filter(|&slope| keep(height, slope)) {
                let support = self.support(
                    height as f32 * p.floor_height_step_m,
                    slope as f32 * p.floor_slope_step_rad,
                );
                best = math::max(best, support);
            }
        }
        best
    }
}

/// Whether the echoes of a map with bins of `bin_m` metres, as they were placed before any calibration, show a floor where it must be: one
/// that is seen at all, and none elsewhere that they show better.
#[inline(never)]
pub fn in_place(echoes: &[Echo], bin_m: f32, p: &Params) -> bool {
    let near = |e: &&Echo| {
        let ahead = e.x_m > p.floor_from_m && e.x_m < p.floor_to_m;
        ahead && e.y_m.abs() < p.floor_astray_m
    };
    let all = echoes
        .iter()
        .filter(near)
        .map(|e| Witness::new(e, bin_m, p));
    let witnesses = Witnesses(all.filter(|w| w.weight > 0.0).collect());
    let (near, tilt) = (p.floor_near_steps as i32, p.floor_tilt_steps as i32);
    let (far, steep) = (p.floor_far_steps as i32, p.floor_steep_steps as i32);
    let here = witnesses.best([near, tilt], p, |_, _| true);
    let off = witnesses.best([far, tilt], p, |height, _| height.abs() > near);
    let inclined = witnesses.best([near, steep], p, |_, slope| slope.abs() > tilt);
    here >= p.floor_seen && math::max(off, inclined) - here <= p.floor_elsewhere
}
