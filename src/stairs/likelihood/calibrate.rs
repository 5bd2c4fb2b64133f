//! Angle bias and mount-height error, taken out where the floor shows them.

use super::ascent::amplitude;
use super::echo::Echo;
use crate::math::{self, RAD_PER_DEG};
use crate::stairs::map::Geometry;

/// Standard deviation of the shaft's angle bias, radians.
const BIAS_SIGMA: f32 = 0.2 * RAD_PER_DEG;
/// Standard deviation of the mount height, metres.
const HEIGHT_SIGMA: f32 = 0.002;

/// What the floor says about the scanner's own errors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Calibration {
    /// To be taken off all angles, radians.
    pub bias_rad: f32,
    /// To be taken off all heights, metres.
    pub height_m: f32,
}

/// Least squares over the echoes that can only be floor, each height error being
/// -(range · cos angle) · bias + height, with priors; echoes off the floor lose weight (Cauchy).
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
            let noise = e.range_m * (0.1 + 0.5 * amplitude(-e.db)) * RAD_PER_DEG;
            let variance = 0.004 * 0.004 + noise * noise;
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
    Calibration { bias_rad, height_m }
}
