//! Transform of real samples: 2 Ns samples in Ns complex points, with half the arithmetic.
//!
//! A chirp of real values is stored as pairs (x[2n], x[2n+1]) in place of I and Q. Its transform Z of N points
//! contains those of the even and of the odd values (Brigham, The Fast Fourier Transform and its Applications,
//! sec. 9.3). With W = exp(-πi / N),
//!
//! ```text
//! S = Z[k] + Z*[N-k],   D = Z[k] - Z*[N-k],   T = j W^k D
//! X[k] = (S - T) / 2,   X*[N-k] = (S + T) / 2
//! ```
//!
//! for k = 0…N/2, where Z[N] is Z[0]. X[N], at half the sampling rate, is not kept.
//!
//! No overflow: |S|² + |D|² = 2 (|Z[k]|² + |Z[N-k]|²), so that |X| is at most √2 times the larger |Z|, and S
//! and D at most twice. If every |Z| is below 16 384, this fits; else all values are halved.
//!
//! The stages are those of complex chirps, with power as output, which gives the magnitude of the bins. The
//! last stage is then repeated with complex bins as output. One copy serves all sizes.

use super::fft::{self, Headroom, to_q15};
use super::packed::{Arithmetic, Bin, Packed, halves, quarters};
use super::window::{ChirpLevels, Weigher, Window};
use crate::Iq;
use crate::config::MAX_SAMPLES;
use crate::math::sin_cos;

/// Entry k: twiddle factor j W^k for k = 0…N/2, where W = exp(-πi / N) and N is the largest size, Q15.
static TWIDDLES: [Packed; MAX_SAMPLES / 2 + 1] = {
    let mut table = [Packed::ZERO; MAX_SAMPLES / 2 + 1];
    let mut k = 0;
    while k < table.len() {
        let (sin, cos) = sin_cos(core::f32::consts::PI * k as f32 / MAX_SAMPLES as f32);
        table[k] = Packed::new(to_q15(sin), to_q15(cos));
        k += 1;
    }
    table
};

/// Power of a bin (|Z| = 16 384) from which all bins are halved before they are combined.
const LARGE: u32 = 1 << 28;

/// Transforms a chirp of pairs of real values into `bins`; its `levels` of I and Q are replaced by those of
/// real values. The first `points` numbers of both buffers are used.
///
/// Returns the exponent e: the true values of the bins are 2^e times `bins`; and whether the bins had to be halved.
#[inline(never)]
pub fn transform<A: Arithmetic, B: Bin>(
    chirp: &[Iq],
    levels: &mut ChirpLevels,
    window: &Window,
    points: usize,
    [data, spare]: &mut [[Packed; MAX_SAMPLES]; 2],
    bins: &mut [B],
) -> (i32, bool) {
    *levels = levels.of_real();
    let (Some(data), Some(spare), Some(bins)) = (
        data.get_mut(..points),
        spare.get_mut(..points),
        bins.get_mut(..points),
    ) else {
        return (0, false);
    };
    weigh::<A>(chirp, levels, window, spare);
    let seen = first_stage::<A>(spare, data);
    let exponent = fft::finish_any::<A, B>(data, spare, bins, seen);
    let all = bins.iter().fold(0, |all, bin| all | bin.power::<A>());
    let half = all >= LARGE;
    let z = fft::last_stage_complex::<A>(data, spare);
    combine_even_odd::<A, B>(z, half, bins);
    (exponent + i32::from(half), half)
}

/// Combines the bins of the last [`transform`] once more, as complex numbers, into the buffer that is free; `half` is
/// what the transform returned. Returns the buffer with the bins.
#[inline(never)]
pub fn combine_complex<'b, A: Arithmetic>(
    data: &'b mut [Packed],
    spare: &'b mut [Packed],
    half: bool,
) -> &'b mut [Packed] {
    let (z, bins) = match data.len() {
        32 | 64 => (data, spare),
        _ => (spare, data),
    };
    combine_even_odd::<A, Packed>(z, half, bins);
    bins
}

/// Writes the chirp to `out` after DC removal, normalisation and window, and fills `out` up with zeros.
#[inline(always)]
fn weigh<A: Arithmetic>(chirp: &[Iq], levels: &ChirpLevels, window: &Window, out: &mut [Packed]) {
    let weigher = Weigher::new(levels);
    let (rising, falling) = window.pairs();
    out.fill(Packed::ZERO);
    let (before, behind) = chirp
        .split_at_checked(chirp.len().div_ceil(2))
        .unwrap_or_default();
    let (low, high) = out.split_at_mut_checked(before.len()).unwrap_or_default();
    if let ([first, ..], [x, ..]) = (&mut *low, before) {
        *first = weigher.weigh_pair::<A>(*x, [0, window.first()]);
    }
    let from_second = low.iter_mut().zip(before).skip(1);
    for ((out, &x), &pair) in from_second.zip(rising) {
        *out = weigher.weigh_pair::<A>(x, pair);
    }
    for ((out, &x), &[second, first]) in high.iter_mut().zip(behind).zip(falling.iter().rev()) {
        *out = weigher.weigh_pair::<A>(x, [first, second]);
    }
}

/// Runs the first radix-4 stage, for which the window's scale leaves the headroom. Returns the headroom of the
/// output.
#[inline(always)]
fn first_stage<A: Arithmetic>(src: &mut [Packed], dst: &mut [Packed]) -> Headroom {
    let mut seen = Headroom::default();
    let ([x0, x1, x2, x3], [a, b, c, d]) = (quarters(src), quarters(dst));
    let inputs = x0.iter().zip(x1).zip(x2.iter().zip(x3));
    let outputs = a.iter_mut().zip(b).zip(c.iter_mut().zip(d));
    for (((x0, x1), (x2, x3)), ((y0, y1), (y2, y3))) in inputs.zip(outputs) {
        let y = A::butterfly([*x0, *x1, *x2, *x3]);
        y.into_iter().for_each(|v| seen.see(v));
        [*y0, *y1, *y2, *y3] = y;
    }
    seen
}

/// Combines `z`, the transform of pairs (even value, odd value), into `bins`, the transform of all values, or
/// (`half`) into half of it.
#[inline(always)]
fn combine_even_odd<A: Arithmetic, B: Bin>(z: &[Packed], half: bool, bins: &mut [B]) {
    let step = MAX_SAMPLES / z.len().max(1);
    let (low, high) = z.split_at(z.len() / 2);
    let (low_bins, high_bins) = halves(bins);
    if let ([bin, low_bins @ ..], [x, low @ ..]) = (&mut *low_bins, low) {
        // Bin 0 is its own partner, and real.
        let sum = i32::from(x.re()) + i32::from(x.im());
        *bin = B::of::<A>(Packed::new((sum >> i32::from(half)) as i16, 0));
        let outputs = low_bins.iter_mut().zip(high_bins.iter_mut().rev());
        let inputs = low.iter().zip(high.iter().rev());
        let mut k = 0;
        for ((&x, &partner), (bin, partner_bin)) in inputs.zip(outputs) {
            k += step;
            let twiddle = TWIDDLES.get(k).copied().unwrap_or_default();
            let (plus, minus) = match half {
                false => (A::add(x, partner), A::sub(x, partner)),
                true => (A::half_add(x, partner), A::half_sub(x, partner)),
            };
            let sum = A::half_add(plus.with_im_of(minus), Packed::ONES);
            let turned = A::mul_half(minus.with_im_of(plus), twiddle);
            *bin = B::of::<A>(A::sub(sum, turned));
            *partner_bin = B::of_conjugate::<A>(A::add(sum, turned));
        }
    }
    if let ([bin, ..], [x, ..]) = (high_bins, high) {
        // The middle bin is its own partner, too.
        let x = if half {
            A::half_add(*x, Packed::ZERO)
        } else {
            *x
        };
        *bin = B::of_conjugate::<A>(x);
    }
}

/// Returns one bin of the last [`transform`] as `[re, im]` from its buffers, without the exponent.
#[inline(never)]
pub fn bin(data: &[Packed], spare: &[Packed], points: usize, bin: usize) -> [f32; 2] {
    let z = match points {
        32 | 64 => data,
        _ => spare,
    };
    let at = |k: usize| {
        let z = z.get(k).copied().unwrap_or_default();
        [z.re(), z.im()].map(f32::from)
    };
    let ([a, b], [c, d]) = (at(bin), at(points.saturating_sub(bin) % points.max(1)));
    let (plus, minus) = ([a + c, b - d], [a - c, b + d]);
    let (sin, cos) = sin_cos(core::f32::consts::PI * bin as f32 / points.max(1) as f32);
    // minus · j (cos - j sin).
    let turned = [
        minus[0] * sin - minus[1] * cos,
        minus[0] * cos + minus[1] * sin,
    ];
    [plus[0] - turned[0], plus[1] - turned[1]]
}
