//! Angle bias and mount-height error, taken out where the floor shows them.

use super::dimension::amplitude;
use super::echo::Echo;
use crate::math::{self, RAD_PER_DEG};
use crate::stairs::map::Geometry;

/// Standard deviation of the shaft's angle bias, radians.
const BIAS_SIGMA: f32 = 0.25 * RAD_PER_DEG;
/// Standard deviation of the mount height, metres.
const HEIGHT_SIGMA: f32 = 0.002;

/// A corner at the foot of the first riser is strong, a single scatterer …
const CORNER_DB: f32 = 20.0;
/// … no wider than this in units of a point scatterer's lobe …
const CLEAN: f32 = 1.15;
/// … and exact: degrees and metres.
const CORNER: (f32, f32) = (0.06, 0.001);
/// Speckle of the floor is less so.
const FLOOR: (f32, f32) = (0.15, 0.004);

/// What the floor says about the scanner's own errors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Calibration {
    /// To be taken off all angles, radians.
    pub bias_rad: f32,
    /// To be taken off all heights, metres.
    pub height_m: f32,
    /// Standard deviation of the bias that is left, radians.
    pub bias_sigma: f32,
}

/// Least squares over the echoes that can only be floor, each height error being
/// -(range · cos angle) · bias + height, with priors; echoes off the floor lose weight (Cauchy).
#[inline(never)]
pub fn calibrate(echoes: &mut [Echo], geometry: &Geometry) -> Calibration {
    let mut a = [
        1.0 / (BIAS_SIGMA * BIAS_SIGMA),
        0.0,
        1.0 / (HEIGHT_SIGMA * HEIGHT_SIGMA),
    ];
    let mut b = [0.0f32; 2];
    for e in echoes.iter() {
        if e.y.abs() < 0.03 && e.db > 8.0 && e.range_m > geometry.mount_height_m {
            let lever = e.range_m * math::sin_cos(e.angle_rad).1;
            let (fixed, rough) = if e.db > CORNER_DB && e.width < CLEAN {
                CORNER
            } else {
                FLOOR
            };
            let noise = e.range_m * (fixed + 0.5 * amplitude(-e.db)) * RAD_PER_DEG;
            let variance = rough * rough + noise * noise;
            let k = 1.0 / (variance * (1.0 + e.y * e.y / (9.0 * variance)));
            a[0] += k * lever * lever;
            a[1] -= k * lever;
            a[2] += k;
            b[0] -= k * lever * e.y;
            b[1] += k * e.y;
        }
    }
    let det = a[0] * a[2] - a[1] * a[1];
    let bias_rad = (b[0] * a[2] - b[1] * a[1]) / det;
    let height_m = (a[0] * b[1] - a[1] * b[0]) / det;
    for e in echoes.iter_mut() {
        e.angle_rad -= bias_rad;
        let (x, y) = geometry.point(e.range_m, e.angle_rad);
        e.x = x;
        e.y = y - height_m;
    }
    Calibration {
        bias_rad,
        height_m,
        bias_sigma: math::sqrt(a[2] / det),
    }
}
