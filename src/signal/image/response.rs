//! Response of a point over the range: the transform of the window, centred.

use crate::math;

/// Half-extent of the response that is subtracted, stored bins.
pub const REACH: usize = 8;

/// Entries of the table of the response's power per native bin.
const PER_NATIVE: f32 = 16.0;
/// Entries of that table: up to 4 native bins.
const ENTRIES: usize = 65;

/// Power of the window's response, by the offset in native bins.
static POWER: [f32; ENTRIES] = {
    let mut table = [0.0; ENTRIES];
    let mut k = 0;
    while k < ENTRIES {
        let w = hann(k as f32 / PER_NATIVE);
        table[k] = w * w;
        k += 1;
    }
    table
};

/// Response over the range, on the grid of the bins.
#[derive(Clone, Copy, Debug)]
pub struct RangeResponse {
    /// Native bins per stored bin.
    pub native_per_bin: f32,
    /// Turn of the phase from bin to bin, radians: that of the window's middle.
    pub radians_per_bin: f32,
    /// Native bin of the first stored bin.
    pub first_native: f32,
    /// Sum of the native bins of an echo and of its I/Q image; infinite without images.
    pub image_sum: f32,
}

impl RangeResponse {
    /// Returns the native bin of a stored bin.
    pub fn native(&self, bin: f32) -> f32 {
        self.first_native + bin * self.native_per_bin
    }

    /// Returns the response `off` stored bins behind a point, relative to the point's amplitude, `[re, im]`.
    pub fn at(&self, off: f32) -> [f32; 2] {
        let (sin, cos) = math::sin_cos(-self.radians_per_bin * off);
        let size = hann(off * self.native_per_bin);
        [size * cos, size * sin]
    }

    /// Returns the power of the response `off` stored bins beside a point, relative to the point's.
    pub fn power(&self, off: f32) -> f32 {
        let at = off * self.native_per_bin * PER_NATIVE;
        // The cast saturates.
        let k = at as usize;
        match POWER.get(k..k + 2) {
            Some(&[low, high]) => low + (at - k as f32) * (high - low),
            _ => 0.0,
        }
    }
}

/// Returns the response of a Hann window of N samples at an offset of `native` native bins (1/N of the sampling rate),
/// relative to its peak, for a transform whose phase refers to the middle of the window.
const fn hann(native: f32) -> f32 {
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
