//! The first pass over a chirp (mean and extremes) and the second: DC removal, normalisation,
//! window and the transform's first stage in one.

use super::fft::{self, Headroom, MAX_MAGNITUDE, MAX_POINTS};
use super::packed::{Packed, add, add_j, mul_wide, pack_high, sub, sub_j};
use crate::Iq;
use crate::math::sin_cos;

/// Hann window of Ns coefficients, scaled so that the transform's first stage cannot overflow.
///
/// The periodic form 0.5 - 0.5 cos(2πn / Ns): side lobes 31 dB down, falling 18 dB an octave
/// (Harris 1978), which keeps the radar's leakage, 50 dB above the stairs, out of their bins.
#[derive(Clone, Debug)]
pub struct Window {
    coefficients: [i16; MAX_POINTS],
    samples: usize,
    points: usize,
    sum: f32,
}

impl Window {
    /// A window for no samples, until [`Window::shape`] gives it some.
    pub const fn empty() -> Self {
        Self {
            coefficients: [0; MAX_POINTS],
            samples: 0,
            points: 0,
            sum: 0.0,
        }
    }

    /// Takes the shape for `samples` samples (16…256) in a transform of `points` points.
    pub fn shape(&mut self, samples: usize, points: usize) {
        let hann = |n: usize| {
            let (_, cos) = sin_cos(core::f32::consts::TAU * n as f32 / samples.max(1) as f32);
            0.5 - 0.5 * cos
        };
        // The first stage adds samples a quarter of the transform apart. With |x| ≤ √2 · 32767
        // after normalisation, the largest sum of their coefficients decides the scale.
        let quarter = (points / 4).max(1);
        let largest = (0..quarter)
            .map(|n| (n..samples).step_by(quarter).map(hann).sum::<f32>())
            .fold(1.0, f32::max);
        // 8 units are more than the rounding of four coefficients and four products.
        let unit = (MAX_MAGNITUDE - 8) as f32 / (core::f32::consts::SQRT_2 * largest);
        self.coefficients.fill(0);
        for (n, c) in self.coefficients.iter_mut().enumerate().take(samples) {
            *c = (unit * hann(n) + 0.5) as i16;
        }
        self.samples = samples;
        self.points = points;
        self.sum = self.coefficients.iter().map(|&c| f32::from(c)).sum();
    }

    /// Samples that the window is for.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Sum of the coefficients, Q15: the transform's value for a tone of amplitude 1.
    pub fn sum(&self) -> f32 {
        self.sum
    }

    /// Correlation of a spectrum's noise in bins `distance` apart: the transform of the squared
    /// window (real, for the window is symmetric about Ns / 2), 1 for distance 0.
    pub fn correlation(&self, distance: usize) -> f32 {
        let per_sample = core::f32::consts::TAU * distance as f32 / self.points.max(1) as f32;
        let middle = self.samples as f32 / 2.0;
        let (mut sum, mut energy) = (0.0, 0.0);
        for (n, &c) in self.coefficients.iter().enumerate().take(self.samples) {
            let square = f32::from(c) * f32::from(c);
            sum += square * sin_cos(per_sample * (n as f32 - middle)).1;
            energy += square;
        }
        if energy > 0.0 { sum / energy } else { 0.0 }
    }
}

/// What the first pass over a chirp finds.
#[derive(Clone, Copy, Debug)]
pub struct Levels {
    /// Mean of I and Q, Q16.16.
    mean: [i32; 2],
    /// Largest distance of any I or Q from its mean, rounded up.
    pub peak: u32,
    /// Samples of which a part stands at full scale.
    pub saturated: u16,
}

impl Levels {
    /// Measures `chirp` (at most 256 samples).
    pub fn of(chirp: &[Iq]) -> Self {
        let (mut sum, mut low, mut high) = ([0i32; 2], [i16::MAX; 2], [i16::MIN; 2]);
        for x in chirp {
            for (part, value) in [x.i, x.q].into_iter().enumerate() {
                sum[part] += i32::from(value);
                low[part] = low[part].min(value);
                high[part] = high[part].max(value);
            }
        }
        // 2^31 / n, so that the mean costs a multiplication.
        let reciprocal = (1u32 << 31) / (chirp.len() as u32).max(1);
        let mean = sum.map(|s| ((i64::from(s) * i64::from(reciprocal)) >> 15) as i32);
        let swing = |part: usize| {
            let above = (i32::from(high[part]) << 15).saturating_sub(mean[part] >> 1);
            let below = (mean[part] >> 1).saturating_sub(i32::from(low[part]) << 15);
            (above.max(below).max(0) as u32).div_ceil(1 << 15)
        };
        let full_scale = |x: i16| x == i16::MAX || x <= -i16::MAX;
        let saturated = if high.into_iter().chain(low).any(full_scale) {
            let touched = chirp.iter().filter(|x| full_scale(x.i) || full_scale(x.q));
            touched.count() as u16
        } else {
            0
        };
        Self {
            mean,
            peak: if chirp.is_empty() {
                0
            } else {
                swing(0).max(swing(1))
            },
            saturated,
        }
    }

    /// Power of two that brings the peak into 2^14…2^15 - 1: -1…14.
    fn normalisation(&self) -> i32 {
        (self.peak.max(1).leading_zeros() as i32 - 17).clamp(-1, 14)
    }
}

/// Windows single samples: (x - mean) · c · 2^shift in Q15, rounded.
#[derive(Clone, Copy)]
struct Weigher {
    minus_mean: [i32; 2],
    left: u32,
    round: i32,
}

impl Weigher {
    #[inline(always)]
    fn weigh(self, x: Iq, c: i16) -> Packed {
        let part = |value: i16, minus_mean: i32| {
            mul_wide(minus_mean, c, self.round)
                .wrapping_add(i32::from(value) * i32::from(c))
                .wrapping_shl(self.left)
        };
        pack_high(part(x.i, self.minus_mean[0]), part(x.q, self.minus_mean[1]))
    }
}

/// DC removal, window and the first radix-4 stage, four-point transforms of samples a quarter of
/// the transform apart; the zero padding takes part in none of them.
///
/// Returns the block's headroom and the exponent e: true values are 2^e times the stored ones.
pub fn open(chirp: &[Iq], levels: &Levels, window: &Window, out: &mut [Packed]) -> (Headroom, i32) {
    let shift = levels.normalisation();
    let left = (shift + 1) as u32;
    let weigher = Weigher {
        minus_mean: levels.mean.map(i32::saturating_neg),
        left,
        round: 0x8000 >> left,
    };
    let mut seen = Headroom::default();
    let quarter = out.len() / 4;
    let mut taps = chirp
        .chunks(quarter.max(1))
        .zip(window.coefficients.chunks(quarter.max(1)));
    let mut tap = || {
        let (x, c) = taps.next().unwrap_or((&[], &[]));
        x.iter().zip(c).map(move |(&x, &c)| weigher.weigh(x, c))
    };
    let (mut x0, mut x1, mut x2, mut x3) = (tap(), tap(), tap(), tap());
    let [a, b, c, d] = fft::quarters(out);
    let outputs = a.iter_mut().zip(b).zip(c).zip(d);
    for (((y0, y1), y2), y3) in outputs {
        let (Some(t0), Some(t1)) = (x0.next(), x1.next()) else {
            break;
        };
        let y = match (x2.next(), x3.next()) {
            (Some(t2), Some(t3)) => fft::butterfly4([t0, t1, t2, t3]),
            (Some(t2), _) => {
                let (sum, diff) = (add(t0, t2), sub(t0, t2));
                [add(sum, t1), sub_j(diff, t1), sub(sum, t1), add_j(diff, t1)]
            }
            _ => [add(t0, t1), sub_j(t0, t1), sub(t0, t1), add_j(t0, t1)],
        };
        for v in y {
            seen.see(v);
        }
        [*y0, *y1, *y2, *y3] = y;
    }
    (seen, -shift)
}
