//! Angle bias, mounting-height error and slope of the ground of one scan, estimated on the ground and subtracted.

use super::variance::floor_variance;
use crate::answer::Slope;
use crate::math;
use crate::params::Params;
use crate::signal::echoes::Echo;
use crate::signal::grid::Geometry;

/// Errors of the beam angle and of the mounting height in one scan, estimated on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Angle bias, subtracted from the beam angles of all echoes, radians.
    pub bias_rad: f32,
    /// Height error, subtracted from the heights of all echoes above the ground, metres.
    pub height_m: f32,
    /// Standard deviation of the angle bias that remains after the subtraction, radians.
    pub bias_sigma_rad: f32,
    /// Slope of the ground, whose height was subtracted from the heights of all echoes.
    pub bend: Slope,
    /// Sum of the squares of both errors, each in units of its prior standard deviation.
    pub chi_square: f32,
}

impl Calibration {
    /// Returns whether angle bias and height error are within the tolerance of tyres, brackets and homing
    /// switch.
    pub fn fits(&self, p: &Params) -> bool {
        self.chi_square <= p.calibration_strain
    }
}

/// Returns the horizontal part of an echo's range, metres: what an angle error in radians is multiplied by to be one in
/// height.
fn lever(e: &Echo) -> f32 {
    e.range_m * math::sin_cos(e.angle_rad).1
}

impl Calibration {
    /// Returns an echo's height by this calibration of level ground, metres.
    pub fn height_of(&self, e: &Echo) -> f32 {
        e.y_m + lever(e) * self.bias_rad - self.height_m
    }

    /// Estimates angle bias and height error by least squares over the echoes that can only be ground of this slope. The
    /// measured height of a ground echo is modelled as -(range · cos angle) · bias + height error, with priors on both
    /// errors; echoes off the ground lose weight (Cauchy).
    #[inline(never)]
    pub fn fit(echoes: &[Echo], bend: Slope, geometry: &Geometry, p: &Params) -> Self {
        let precision = |sigma: f32| 1.0 / (sigma * sigma);
        let prior = [
            precision(p.angle_bias_sigma_rad),
            precision(p.mount_height_sigma_m),
        ];
        let mut a = [prior[0], 0.0, prior[1]];
        let mut b = [0.0f32; 2];
        for e in echoes {
            let y_m = e.y_m - bend.height_m(e.x_m);
            let is_floor = y_m.abs() < p.floor_reach_m
                && e.snr_db > p.floor_least_db
                && e.range_m > geometry.mount_height_m;
            if !is_floor {
                continue;
            }
            let lever = lever(e);
            let variance = floor_variance(e, e.range_m, p);
            let tails = p.floor_cauchy_sigmas * p.floor_cauchy_sigmas;
            let k = 1.0 / (variance * (1.0 + y_m * y_m / (tails * variance)));
            a[0] += k * lever * lever;
            a[1] -= k * lever;
            a[2] += k;
            b[0] -= k * lever * y_m;
            b[1] += k * y_m;
        }
        let det = a[0] * a[2] - a[1] * a[1];
        let bias_rad = (b[0] * a[2] - b[1] * a[1]) / det;
        let height_m = (a[0] * b[1] - a[1] * b[0]) / det;
        Self {
            bias_rad,
            height_m,
            bias_sigma_rad: math::sqrt(a[2] / det),
            bend,
            chi_square: bias_rad * bias_rad * prior[0] + height_m * height_m * prior[1],
        }
    }

    /// Subtracts the errors and the slope from the echoes: then all heights are above the ground.
    pub fn subtract(&self, echoes: &mut [Echo], geometry: &Geometry) {
        for e in echoes {
            e.angle_rad -= self.bias_rad;
            let (x, y) = geometry.point(e.range_m, e.angle_rad);
            e.x_m = x;
            e.y_m = y - self.height_m - self.bend.height_m(x);
        }
    }
}
