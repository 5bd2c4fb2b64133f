//! Response of a point over the range: the transform of the window, centred.

use crate::math;

/// Half-extent of the response that is subtracted, stored bins.
pub const REACH: usize = 8;

/// Returns the response of a Hann window of N samples at an offset of `native` native bins (1/N of the sampling rate),
/// relative to its peak, for a transform whose phase refers to the middle of the window.
pub fn hann(native: f32) -> f32 {
    let x = native.abs();
    // sin(πx) / (πx (1 - x²)), with its limits at 0 and 1.
    if x < 1e-3 {
        return 1.0;
    }
    let left = 1.0 - x * x;
    if left.abs() < 1e-3 {
        return 0.5;
    }
    let (sin, _) = math::sin_cos(core::f32::consts::PI * (x % 2.0));
    sin / (core::f32::consts::PI * x * left)
}
