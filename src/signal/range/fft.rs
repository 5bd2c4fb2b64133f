//! Complex transform of 16, 32, 64, 128 or 256 points in 16-bit block floating point.
//!
//! Decimation in time, radix 4, in Stockham's order: each stage reads one buffer and writes the other, so that
//! input and output are both in natural order and no bit reversal is needed. After stages of transforms of L =
//! 1, 4, 16, … points,
//!
//! ```text
//! X[k + Lm] = Σ_j (-j)^(jm) · W(4L)^(jk) · X_j[k],   j, m = 0…3,   W(n) = exp(-2πi / n)
//! ```
//!
//! joins four transforms of L points into one of 4L (Cooley and Tukey 1965; Stockham's ordering:
//! Cochran et al. 1967). Sizes that are no power of 4 end with one radix-2 stage.
//!
//! Block floating point: a stage scales by 1/2 if the block has a bit of headroom, and by 1/4 if not. Products
//! taken from the upper half-word and halving sums do the scaling without extra instructions. Each stage
//! determines the magnitude of its output while writing ([`Headroom`]). Products are rounded.
//!
//! No overflow: let every |X| be at most [`MAX_MAGNITUDE`] before a stage. Scaled by 1/4, the sum of four
//! cannot exceed that. A scale of 1/2 is used only if both parts are within ±8192, so that 4 · √2 · 8192 / 2 =
//! 23 170 is the bound. The difference to 32 767 covers the roundings.

use super::packed::{Arithmetic, Bin, Packed, halves, last_by, magnitude_bits, quarters, stage_by};
use crate::math::sin_cos;

/// Maximum number of points of a transform.
pub const MAX_POINTS: usize = 256;

/// Maximum magnitude of a complex number that the first stage puts out, units of its 16-bit parts.
pub const MAX_MAGNITUDE: i32 = 32_750;

/// Twiddle factors of a stage that joins transforms of L points.
struct Twiddles<const L: usize>;

impl<const L: usize> Twiddles<L> {
    /// Entry k: W(4L)^k, W(4L)^2k, W(4L)^3k for k = 0…L-1, with W(n) = exp(-2πi / n), Q15.
    const TABLE: [[Packed; 3]; L] = {
        let mut table = [[Packed::ZERO; 3]; L];
        let mut k = 0;
        while k < L {
            let mut j = 1;
            while j <= 3 {
                let angle = core::f32::consts::FRAC_PI_2 * (j * k) as f32 / L as f32;
                let (sin, cos) = sin_cos(angle);
                table[k][j - 1] = Packed::new(to_q15(cos), to_q15(-sin));
                j += 1;
            }
            k += 1;
        }
        table
    };
}

/// Returns the nearest Q15 number to `x`; 1 becomes 32767 / 32768.
pub(super) const fn to_q15(x: f32) -> i16 {
    // The cast from float saturates.
    (32_768.0 * x + if x < 0.0 { -0.5 } else { 0.5 }) as i16
}

/// Headroom of a block of numbers, determined while a stage writes them, without a pass of its own: the bits
/// that the largest one needs.
#[derive(Clone, Copy, Default)]
pub struct Headroom(u32);

impl Headroom {
    /// Takes one number of the block into account.
    #[inline(always)]
    pub fn see(&mut self, x: Packed) {
        self.0 |= magnitude_bits(x);
    }

    /// Returns whether the real and imaginary parts of all numbers are within -8192…8191.
    #[inline(always)]
    fn is_ample(self) -> bool {
        self.0 & 0xc000_c000 == 0
    }
}

/// Runs one radix-4 stage with the scale that the headroom `seen` of its input requires, and adds the scale's
/// exponent. Returns the headroom of the output.
#[inline(always)]
fn scaled_stage<A: Arithmetic, const N: usize, const L: usize>(
    src: &[Packed; N],
    dst: &mut [Packed; N],
    seen: Headroom,
    exponent: &mut i32,
) -> Headroom {
    if seen.is_ample() {
        *exponent += 1;
        Headroom(A::stage::<N, L, false>(src, dst, &Twiddles::<L>::TABLE))
    } else {
        *exponent += 2;
        Headroom(A::stage::<N, L, true>(src, dst, &Twiddles::<L>::TABLE))
    }
}

/// Runs the last radix-4 stage with the scale that the headroom `seen` of its input requires, and returns the
/// scale's exponent.
#[inline(always)]
fn scaled_last<A: Arithmetic, B: Bin, const N: usize, const L: usize>(
    src: &[Packed; N],
    bins: &mut [B; N],
    seen: Headroom,
) -> i32 {
    if seen.is_ample() {
        B::last::<A, N, L, false>(src, bins, &Twiddles::<L>::TABLE);
        1
    } else {
        B::last::<A, N, L, true>(src, bins, &Twiddles::<L>::TABLE);
        2
    }
}

/// Runs all stages of a transform after the first. `data` contains the first stage's output (four quarters;
/// quarter m has the bins m of four-point transforms) and is overwritten, as is `spare`.
///
/// Returns the exponent e: the true values of the bins are 2^e times `bins`.
pub fn finish<A: Arithmetic, B: Bin, const N: usize>(
    data: &mut [Packed; N],
    spare: &mut [Packed; N],
    bins: &mut [B; N],
    seen: Headroom,
) -> i32 {
    if N < MAX_POINTS {
        return finish_short::<A, B>(data, spare, bins, seen);
    }
    let mut exponent = 0;
    let seen = scaled_stage::<A, N, 4>(data, spare, seen, &mut exponent);
    let seen = scaled_stage::<A, N, 16>(spare, data, seen, &mut exponent);
    exponent + scaled_last::<A, B, N, 64>(data, bins, seen)
}

/// Runs [`finish`], all stages after the first, for a number of points that is known at run time only.
pub(super) fn finish_any<A: Arithmetic, B: Bin>(
    data: &mut [Packed],
    spare: &mut [Packed],
    bins: &mut [B],
    seen: Headroom,
) -> i32 {
    if let (Some(data), Some(spare), Some(bins)) = (
        data.first_chunk_mut(),
        spare.first_chunk_mut(),
        bins.first_chunk_mut(),
    ) {
        return finish::<A, B, MAX_POINTS>(data, spare, bins, seen);
    }
    finish_short::<A, B>(data, spare, bins, seen)
}

/// Repeats the last stage of a transform after [`finish`], now with complex bins as output: its input is still
/// in one of the two buffers. Returns the buffer with the bins.
pub(super) fn last_stage_complex<'b, A: Arithmetic>(
    data: &'b mut [Packed],
    spare: &'b mut [Packed],
) -> &'b mut [Packed] {
    let points = data.len();
    let (src, out, table): (_, _, &[[Packed; 3]]) = match points {
        256 | 128 => (data, spare, &Twiddles::<64>::TABLE),
        64 | 32 => (spare, data, &Twiddles::<16>::TABLE),
        _ => (data, spare, &Twiddles::<4>::TABLE),
    };
    if points == 4 * table.len() {
        let mut seen = Headroom::default();
        src.iter().for_each(|&x| seen.see(x));
        last_by::<A, Packed>(src, out, table, !seen.is_ample());
    } else {
        last_pairs::<A, Packed>(src, out, table);
    }
    out
}

/// Returns one bin of the transform of `points` points that [`finish`] made of `data` and `spare`: repeats the
/// last stage for that bin, whose input is still in one of the buffers. The bin is given as `[re, im]`, without
/// the exponent.
pub fn bin(data: &[Packed], spare: &[Packed], points: usize, bin: usize) -> [f32; 2] {
    let (last, table): (_, &[[Packed; 3]]) = match points {
        256 | 128 => (data, &Twiddles::<64>::TABLE),
        64 | 32 => (spare, &Twiddles::<16>::TABLE),
        _ => (data, &Twiddles::<4>::TABLE),
    };
    let (k, m) = (bin % table.len(), bin / table.len());
    let fours = points == 4 * table.len();
    let block = last.chunks_exact(if fours { 4 } else { 2 }).nth(k);
    let (Some(block), Some(&[w, square, cube])) = (block, table.get(k)) else {
        return [0.0; 2];
    };
    let twiddles: &[Packed] = if fours {
        &[Packed::new(i16::MAX, 0), w, square, cube]
    } else {
        // Radix-2 stage: W(2L)^k = W(4L)^2k, and its factor (-1)^(jm) is (-j)^(2jm).
        &[Packed::new(i16::MAX, 0), square]
    };
    let quarters = if fours { m } else { 2 * m };
    let mut sum = [0.0; 2];
    for (j, (x, w)) in block.iter().zip(twiddles).enumerate() {
        let [a, b, c, d] = [x.re(), x.im(), w.re(), w.im()].map(|x| f32::from(x) / 32_768.0);
        let (re, im) = (a * c - b * d, a * d + b * c);
        // Times (-j)^(jm).
        let (re, im) = match j * quarters % 4 {
            0 => (re, im),
            1 => (im, -re),
            2 => (-re, -im),
            _ => (-im, re),
        };
        sum = [sum[0] + re, sum[1] + im];
    }
    sum
}

/// Runs all stages after the first, see [`finish`], for all transforms but the longest. One copy serves all
/// sizes, with loop counts known at run time only: shorter chirps leave enough time.
fn finish_short<A: Arithmetic, B: Bin>(
    data: &mut [Packed],
    spare: &mut [Packed],
    bins: &mut [B],
    mut seen: Headroom,
) -> i32 {
    let points = data.len();
    let (mut src, mut dst) = (data, spare);
    let mut exponent = 0;
    let tables: [&[[Packed; 3]]; 3] = [
        &Twiddles::<4>::TABLE,
        &Twiddles::<16>::TABLE,
        &Twiddles::<64>::TABLE,
    ];
    for table in tables {
        if points == 2 * table.len() {
            last_pairs::<A, B>(src, bins, table);
            return exponent + 1;
        }
        let quarter = !seen.is_ample();
        exponent += 1 + i32::from(quarter);
        if points == 4 * table.len() {
            last_by::<A, B>(src, bins, table, quarter);
            break;
        }
        seen = Headroom(stage_by::<A>(src, dst, table, quarter));
        core::mem::swap(&mut src, &mut dst);
    }
    exponent
}

/// Runs the radix-2 stage that ends a transform whose size is no power of 4, scaled by 1/2.
///
/// W(2L)^k = W(4L)^2k, so the radix-4 table of the same L can be used.
#[inline(always)]
fn last_pairs<A: Arithmetic, B: Bin>(src: &[Packed], bins: &mut [B], table: &[[Packed; 3]]) {
    let (blocks, _) = src.as_chunks::<2>();
    let (low, high) = halves(bins);
    let outputs = low.iter_mut().zip(high);
    for (([x0, x1], [_, w, _]), (y0, y1)) in blocks.iter().zip(table).zip(outputs) {
        let (t0, t1) = (A::half_add(*x0, Packed::ONES), A::mul_half(*x1, *w));
        *y0 = B::of::<A>(A::add(t0, t1));
        *y1 = B::of::<A>(A::sub(t0, t1));
    }
}

/// Transforms N points (16, 32, 64, 128 or 256) of magnitude up to [`MAX_MAGNITUDE`].
///
/// Returns the exponent e: the true values of the bins are 2^e times `bins`.
pub fn transform<A: Arithmetic, B: Bin, const N: usize>(
    input: &[Packed; N],
    [data, spare]: &mut [[Packed; N]; 2],
    bins: &mut [B; N],
) -> i32 {
    let mut seen = Headroom::default();
    let (lower, upper) = input.split_at(N / 2);
    let (x0, x1) = lower.split_at(N / 4);
    let (x2, x3) = upper.split_at(N / 4);
    let [a, b, c, d] = quarters(data);
    let inputs = x0.iter().zip(x1).zip(x2.iter().zip(x3));
    let outputs = a.iter_mut().zip(b).zip(c.iter_mut().zip(d));
    for (((x0, x1), (x2, x3)), ((y0, y1), (y2, y3))) in inputs.zip(outputs) {
        let halves = [*x0, *x1, *x2, *x3].map(|x| A::half_add(x, Packed::ONES));
        let y = A::half_butterfly(halves);
        y.into_iter().for_each(|v| seen.see(v));
        [*y0, *y1, *y2, *y3] = y;
    }
    2 + finish::<A, B, N>(data, spare, bins, seen)
}
