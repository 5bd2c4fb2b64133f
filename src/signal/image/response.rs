//! Response of a point over the range: the transform of the window, centred.

use crate::math;

/// Half-extent of the response that is subtracted, stored bins.
pub const REACH: usize = 8;

/// Distance from its limits within which the response is computed from its own sine.
const NEAR_LIMIT: f32 = 0.1;
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

    /// Writes to `out` the response in each bin from `off` stored bins behind a point on, relative to the point's amplitude,
    /// `[re, im]`.
    #[inline(never)]
    pub fn along(&self, off: f32, out: &mut [[f32; 2]]) {
        let mut phase = Phasor::new(-self.radians_per_bin, off);
        let mut sine = Phasor::new(core::f32::consts::PI * self.native_per_bin, off);
        let mut x = off * self.native_per_bin;
        for out in out {
            let ([cos, sin], [_, wave]) = (phase.next(), sine.next());
            let size = hann_with(x, wave);
            *out = [size * cos, size * sin];
            x += self.native_per_bin;
        }
    }

    /// Returns the phasor of a stored bin, as [`RangeResponse::at`] takes it.
    pub fn phasor(&self, bin: f32) -> [f32; 2] {
        let (sin, cos) = math::sin_cos(self.radians_per_bin * bin);
        [cos, sin]
    }

    /// Returns the response `off` stored bins behind a point, relative to the point's amplitude, `[re, im]`, with the phasors
    /// of the bin and of the point. The response turns by π a native bin.
    pub fn at(&self, off: f32, [a, b]: [f32; 2], [c, d]: [f32; 2]) -> [f32; 2] {
        let (cos, sin) = (a * c + b * d, b * c - a * d);
        let x = off * self.native_per_bin;
        let size = hann_with(x, sin);
        [size * cos, -size * sin]
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

/// A phasor that turns by the same angle from place to place.
struct Phasor {
    now: [f32; 2],
    step: [f32; 2],
}

impl Phasor {
    /// Returns the phasor at `from` times an angle, which turns by that angle, radians.
    fn new(angle_rad: f32, from: f32) -> Self {
        let phasor = |angle_rad| {
            let (sin, cos) = math::sin_cos(angle_rad);
            [cos, sin]
        };
        Self {
            now: phasor(angle_rad * from),
            step: phasor(angle_rad),
        }
    }

    /// Returns the phasor, `[cos, sin]`, and turns it.
    fn next(&mut self) -> [f32; 2] {
        let ([a, b], [c, d]) = (self.now, self.step);
        self.now = [a * c - b * d, a * d + b * c];
        [a, b]
    }
}

/// Returns what [`hann`] does at `x` native bins, with sin(πx) at hand.
#[inline(always)]
fn hann_with(x: f32, sin: f32) -> f32 {
    let left = 1.0 - x * x;
    if x.abs() < NEAR_LIMIT || left.abs() < NEAR_LIMIT {
        hann(x)
    } else {
        sin / (core::f32::consts::PI * x * left)
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
