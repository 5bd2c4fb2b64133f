//! First two passes over a chirp: mean and extremes; then DC removal, normalisation, window and the transform's
//! first stage in one.

use super::fft::{Headroom, MAX_MAGNITUDE, MAX_POINTS};
use super::packed::{Arithmetic, Packed, quarters};
use crate::Iq;
use crate::math::sin_cos;

/// Hann window of Ns coefficients, scaled so that the transform's first stage cannot overflow.
///
/// The periodic form 0.5 - 0.5 cos(2πn / Ns): side lobes 31 dB down, falling 18 dB an octave (Harris 1978).
/// They keep the radar's leakage, 50 dB above the stairs, out of the stairs' bins.
#[derive(Clone, Debug)]
pub struct Window {
    /// Window coefficients, Q15. Entry n is that of complex sample n. For real samples (see [`Window::shape_real`]) it
    /// is that of real sample n + 1, up to the middle of the chirp: the coefficient of real sample 0 is 0, and the
    /// second half mirrors the first.
    coefficients: [i16; MAX_POINTS],
    samples: usize,
    points: usize,
    /// Whether the chirp is of real samples, stored in pairs in place of I and Q, each with its own coefficient.
    real: bool,
    sum: f32,
}

impl Window {
    /// Creates a window without samples; [`Window::shape`] sets them.
    pub const fn empty() -> Self {
        Self {
            coefficients: [0; MAX_POINTS],
            samples: 0,
            points: 0,
            real: false,
            sum: 0.0,
        }
    }

    /// Sets the window up for `samples` samples (16…256) in a transform of `points` points.
    pub fn shape(&mut self, samples: usize, points: usize) {
        self.shape_of(samples, points, false);
    }

    /// Sets the window up for `samples` pairs of real samples in a transform of `points` complex points: one window
    /// over all 2 · `samples` real samples.
    pub fn shape_real(&mut self, samples: usize, points: usize) {
        self.shape_of(samples, points, true);
    }

    #[inline(never)]
    fn shape_of(&mut self, samples: usize, points: usize, real: bool) {
        let values = 1 + usize::from(real);
        let all = samples * values;
        let hann = |n: usize| {
            let (_, cos) = sin_cos(core::f32::consts::TAU * n as f32 / all.max(1) as f32);
            0.5 - 0.5 * cos
        };
        // The first stage adds samples that are a quarter of the transform apart. With |x| ≤ √2 · 32767 after
        // normalisation, the largest sum of their coefficients decides the scale.
        let quarter = (values * points / 4).max(1);
        let largest = (0..quarter)
            .map(|n| (n..all).step_by(quarter).map(hann).sum::<f32>())
            .fold(1.0, f32::max);
        // 8 units exceed the rounding of four coefficients and four products.
        let unit = (MAX_MAGNITUDE - 8) as f32 / (core::f32::consts::SQRT_2 * largest);
        self.coefficients.fill(0);
        for (n, c) in self.coefficients.iter_mut().enumerate().take(samples) {
            // The first real value of a symmetric window has coefficient 0 and is not stored.
            *c = (unit * hann(n + values - 1) + 0.5) as i16;
        }
        self.samples = samples;
        self.points = points;
        self.real = real;
        let sum: f32 = (0..all).map(|n| f32::from(self.at(n))).sum();
        // Half of a real tone is at its negative frequency.
        self.sum = sum / values as f32;
    }

    /// Returns the window's coefficient for index `n`, Q15. `n` counts complex samples, or, if the samples are real and
    /// stored in pairs in place of I and Q, the single real samples.
    #[inline(always)]
    fn at(&self, n: usize) -> i16 {
        let place = match self.real {
            false => n,
            // The second half is the first one reversed; the coefficient of value 0 is 0.
            true => n.min((2 * self.samples).wrapping_sub(n)).wrapping_sub(1),
        };
        self.coefficients.get(place).copied().unwrap_or(0)
    }

    /// Returns the coefficient of the second real sample of a chirp, Q15; that of the first one is 0.
    pub(super) fn first(&self) -> i16 {
        self.coefficients[0]
    }

    /// Returns the coefficients of the pairs of real values in two parts: those of the pairs after the first
    /// one up to the middle, and those of the others in reverse order and with each pair reversed.
    #[inline(always)]
    pub(super) fn pairs(&self) -> (&[[i16; 2]], &[[i16; 2]]) {
        let part = |range: core::ops::Range<usize>| {
            let part = self.coefficients.get(range);
            part.unwrap_or(&[]).as_chunks().0
        };
        (part(1..self.samples), part(0..self.samples & !1))
    }

    /// Returns whether the window is for real samples, stored in pairs in place of I and Q.
    #[inline(always)]
    pub fn is_real(&self) -> bool {
        self.real
    }

    /// Returns the number of complex samples, or of pairs of real samples, that the window covers.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Returns the value of the transform at a tone of amplitude 1, Q15: the sum of the coefficients, or half of it for
    /// real samples, because half of a real tone is at its negative frequency.
    pub fn sum(&self) -> f32 {
        self.sum
    }

    /// Returns the correlation of a spectrum's noise in bins `distance` apart: the transform of the squared
    /// window (real, because the window is symmetric about Ns / 2), 1 for distance 0.
    pub fn correlation(&self, distance: usize) -> f32 {
        let values = 1 + usize::from(self.real);
        let points = values * self.points;
        let per_sample = core::f32::consts::TAU * distance as f32 / points.max(1) as f32;
        let all = values * self.samples;
        let middle = all as f32 / 2.0;
        let (mut sum, mut energy) = (0.0, 0.0);
        for n in 0..all {
            let c = f32::from(self.at(n));
            let square = c * c;
            sum += square * sin_cos(per_sample * (n as f32 - middle)).1;
            energy += square;
        }
        if energy > 0.0 { sum / energy } else { 0.0 }
    }
}

/// Levels of a chirp, the results of the first pass over it.
#[derive(Clone, Copy, Debug)]
pub struct ChirpLevels {
    /// Mean of I, then of Q, over the chirp, Q16.16 units of a 16-bit sample.
    mean: [i32; 2],
    /// Maximum distance of any I or Q from its mean, rounded up, units of 16-bit samples.
    pub swing: u32,
    /// Number of samples whose I or Q is at full scale.
    pub saturated: u16,
    /// Minima of I and of Q over the chirp, then their maxima, units of 16-bit samples.
    pub extremes: [Iq; 2],
}

impl ChirpLevels {
    /// Measures mean, extremes, swing and saturation of a chirp of 1 to 256 samples.
    pub fn of<A: Arithmetic>(chirp: &[Iq]) -> Self {
        let (mut sum_i, mut sum_q) = (0, 0);
        let mut low = Packed::new(i16::MAX, i16::MAX);
        let mut high = Packed::new(i16::MIN, i16::MIN);
        let mut see = |low_high: (Packed, Packed)| {
            low = A::min(low, low_high.0);
            high = A::max(high, low_high.1);
        };
        let mut add = |x: Iq| {
            let x = Packed::from(x);
            sum_i = A::dot(x, Packed::REAL, sum_i);
            sum_q = A::dot(x, Packed::IMAGINARY, sum_q);
            x
        };
        // Four at a time: sorted pairs save a comparison, and fewer iterations save loop overhead.
        let (fours, rest) = chirp.as_chunks::<4>();
        for four in fours {
            let [x0, x1, x2, x3] = four.map(&mut add);
            see(A::sort(x0, x1));
            see(A::sort(x2, x3));
        }
        for &x in rest {
            let x = add(x);
            see((x, x));
        }
        // 2^31 / n, so that a mean needs a multiplication instead of a division.
        let reciprocal = i64::from((1u32 << 31) / (chirp.len() as u32).max(1));
        let mean = [sum_i, sum_q].map(|sum| ((i64::from(sum) * reciprocal) >> 15) as i32);
        let swing_i = swing(mean[0], low.re(), high.re());
        let swing_q = swing(mean[1], low.im(), high.im());
        let extremes = [low, high].map(|x| Iq::new(x.re(), x.im()));
        let saturated = if extremes.iter().any(at_full_scale) {
            count_saturated(chirp)
        } else {
            0
        };
        Self {
            mean,
            swing: swing_i.max(swing_q),
            saturated,
            extremes,
        }
    }

    /// Returns the levels of a chirp of real values, whose I and Q have one common mean and common extremes.
    pub fn of_real(&self) -> Self {
        // Halved first, because the sum does not fit Q16.16.
        let mean = self.mean.iter().map(|mean| mean >> 1).sum();
        let [low, high] = self.extremes;
        let (low, high) = (low.i.min(low.q), high.i.max(high.q));
        Self {
            mean: [mean; 2],
            swing: swing(mean, low, high),
            extremes: [low, high].map(|x| Iq::new(x, x)),
            ..*self
        }
    }

    /// Returns the chirp's means of I and of Q, rounded to units of a 16-bit sample.
    pub fn mean(&self) -> Iq {
        let [i, q] = self.mean.map(|mean| ((mean + (1 << 15)) >> 16) as i16);
        Iq::new(i, q)
    }

    /// Returns 2^32 times the factor that scales the swing to full scale and removes the factor of a Q15
    /// coefficient.
    pub fn gain(&self) -> i32 {
        // Below a swing of 3 the gain would not fit 32 bits; such a chirp has no signal.
        ((32_767u32 << 17) / self.swing.clamp(3, 65_535)) as i32
    }
}

/// Returns the larger distance of `low` and `high` from a mean in Q16.16, rounded up.
#[inline(always)]
fn swing(mean: i32, low: i16, high: i16) -> u32 {
    // In Q15, because the largest differences do not fit Q16.
    let mean = mean >> 1;
    let above = (i32::from(high) << 15).saturating_sub(mean);
    let below = mean.saturating_sub(i32::from(low) << 15);
    (above.max(below).max(0) as u32).div_ceil(1 << 15)
}

/// Returns whether I or Q of `x` is at the converter's full scale.
fn at_full_scale(x: &Iq) -> bool {
    [x.i, x.q]
        .iter()
        .any(|&part| part == i16::MAX || part <= -i16::MAX)
}

/// Returns the number of samples whose I or Q is at full scale; rarely called.
#[cold]
fn count_saturated(chirp: &[Iq]) -> u16 {
    chirp.iter().filter(|&x| at_full_scale(x)).count() as u16
}

/// Windowing of the samples of a chirp: (x - mean) · c · gain, rounded, with window coefficient c.
#[derive(Clone, Copy)]
pub(super) struct Weigher {
    minus_mean: [i32; 2],
    gain: i32,
}

impl Weigher {
    /// Creates the windowing of a chirp with these levels.
    #[inline(always)]
    pub(super) fn new(levels: &ChirpLevels) -> Self {
        Self {
            minus_mean: levels.mean.map(i32::saturating_neg),
            gain: levels.gain(),
        }
    }

    /// Returns a pair of real values windowed, each with its own coefficient.
    #[inline(always)]
    pub(super) fn weigh_pair<A: Arithmetic>(self, x: Iq, pair: [i16; 2]) -> Packed {
        let (x, [c, d]) = (Packed::from(x), pair.map(i32::from));
        let [mean, _] = self.minus_mean;
        A::pack_low(
            A::mul_high(A::scale_re(x, c, A::scale_wide(mean, c)), self.gain),
            A::mul_high(A::scale_im(x, d, A::scale_wide(mean, d)), self.gain),
        )
    }

    #[inline(always)]
    fn weigh<A: Arithmetic>(self, x: Iq, c: i16) -> Packed {
        let (x, c) = (Packed::from(x), i32::from(c));
        // The mean keeps its fraction: half a unit of it would be as large as a chirp of a few units.
        let [re, im] = self.minus_mean.map(|mean| A::scale_wide(mean, c));
        A::pack_low(
            A::mul_high(A::scale_re(x, c, re), self.gain),
            A::mul_high(A::scale_im(x, c, im), self.gain),
        )
    }

    /// Returns sample `k` of `x` windowed with coefficient `k` of `c`; 0 beyond the end.
    #[inline(always)]
    fn tap<A: Arithmetic>(self, x: &[Iq], c: &[i16], k: usize) -> Packed {
        match (x.get(k), c.get(k)) {
            (Some(&x), Some(&c)) => self.weigh::<A>(x, c),
            _ => Packed::ZERO,
        }
    }
}

/// DC removal, normalisation, window and the first radix-4 stage: four-point transforms of samples a quarter of
/// the transform apart, written to `out`. Returns the headroom of `out`. Taps in the zero padding are left out.
#[inline(never)]
pub fn window_and_first_stage<A: Arithmetic, const N: usize>(
    chirp: &[Iq],
    levels: &ChirpLevels,
    window: &Window,
    out: &mut [Packed; N],
) -> Headroom {
    let quarter = N / 4;
    let mut out = quarters(out);
    let weigher = Weigher::new(levels);
    let mut seen = Headroom::default();
    let mut write = |n: usize, y: [Packed; 4]| {
        for (out, v) in out.iter_mut().zip(y) {
            seen.see(v);
            // `quarter` is a power of two; the remainder spares the bounds check.
            if let Some(place) = out.get_mut(n % quarter) {
                *place = v;
            }
        }
    };
    let samples = chirp.iter().zip(&window.coefficients).len();
    let (chirp, c) = (&chirp[..samples], &window.coefficients[..samples]);
    let tap = |x, c, j| weigher.tap::<A>(x, c, j * quarter);
    // A chirp is longer than half the transform: the first two taps always exist, the third up to `three`, the
    // fourth up to `four`. Each window of the samples contains the taps of one point.
    let taps_of = |j: usize| samples.saturating_sub(j * quarter).min(quarter);
    let (three, four) = (taps_of(2), taps_of(3));
    let taps = |from: usize, count: usize| {
        let span = (count - 1) * quarter + 1;
        let (x, c) = (chirp.get(from..), c.get(from..));
        x.unwrap_or(&[])
            .windows(span)
            .zip(c.unwrap_or(&[]).windows(span))
    };
    for (n, (x, c)) in (0..four).zip(taps(0, 4)) {
        let taps = [tap(x, c, 0), tap(x, c, 1), tap(x, c, 2), tap(x, c, 3)];
        write(n, A::butterfly(taps));
    }
    for (n, (x, c)) in (four..three).zip(taps(four, 3)) {
        let [t0, t1, t2] = [tap(x, c, 0), tap(x, c, 1), tap(x, c, 2)];
        let (sum, diff) = (A::add(t0, t2), A::sub(t0, t2));
        write(
            n,
            [
                A::add(sum, t1),
                A::sub_j(diff, t1),
                A::sub(sum, t1),
                A::add_j(diff, t1),
            ],
        );
    }
    for (n, (x, c)) in (three..quarter).zip(taps(three, 2)) {
        let [t0, t1] = [tap(x, c, 0), tap(x, c, 1)];
        write(
            n,
            [
                A::add(t0, t1),
                A::sub_j(t0, t1),
                A::sub(t0, t1),
                A::add_j(t0, t1),
            ],
        );
    }
    seen
}
