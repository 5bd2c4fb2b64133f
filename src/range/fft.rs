//! Complex transform of 16, 32, 64, 128 or 256 points in 16-bit block floating point.
//!
//! Decimation in time, radix 4, in Stockham's order: each stage reads one buffer and writes the
//! other, so that input and output are both in natural order and no bit reversal is needed. After
//! the stages with L = 1, 4, 16, … points each,
//!
//! ```text
//! X[k + Lm] = Σ_j (-j)^(jm) · W(4L)^(jk) · X_j[k],   j, m = 0…3,   W(n) = exp(-2πi / n)
//! ```
//!
//! joins four transforms of L points into one of 4L (Cooley and Tukey 1965; Stockham's ordering:
//! Cochran et al. 1967). Sizes that are no power of 4 end with one radix-2 stage.
//!
//! Block floating point: a stage scales by 1/2 where the block leaves a bit of headroom and by 1/4
//! where it does not; products taken from the upper half-word and halving sums do that for nothing. Writers
//! gather the block's magnitude as they go ([`Headroom`]). Every product is rounded.
//!
//! No overflow: let every |X| be at most 32 750 before a stage. Scaled by 1/4 the sum of four
//! cannot exceed that; scaled by 1/2 it is only where both parts lie within ±8192, so that
//! 4 · √2 · 8192 / 2 = 23 170 bounds it.

use super::packed::{
    ONES, Packed, ZERO, add, add_j, half_diff, half_diff_j, half_sum, half_sum_j, mul_half, norm,
    sub, sub_j,
};
use crate::math::sin_cos;

/// Most points of a transform.
pub const MAX_POINTS: usize = 256;

/// Largest magnitude that the first stage may hand on (see the module's overflow argument; the
/// rest up to 32 767 takes the roundings of the stages).
pub const MAX_MAGNITUDE: i32 = 32_750;

/// W(4L)^k, W(4L)^2k, W(4L)^3k for k = 0…L-1.
type Twiddles<const L: usize> = [[Packed; 3]; L];

/// Twiddles of one stage of L points, Q15.
const fn twiddles<const L: usize>() -> Twiddles<L> {
    const UNIT: f32 = 32_768.0;
    let mut table = [[ZERO; 3]; L];
    let mut k = 0;
    while k < L {
        let mut j = 1;
        while j <= 3 {
            let angle = core::f32::consts::FRAC_PI_2 * (j * k) as f32 / L as f32;
            let (sin, cos) = sin_cos(angle);
            table[k][j - 1] = Packed::new(round_q15(UNIT * cos), round_q15(-UNIT * sin));
            j += 1;
        }
        k += 1;
    }
    table
}

/// Nearest 16-bit integer, saturated (1 becomes 32767 / 32768).
const fn round_q15(x: f32) -> i16 {
    // `as` from float saturates.
    (x + if x < 0.0 { -0.5 } else { 0.5 }) as i16
}

static JOIN_4: Twiddles<4> = twiddles();
static JOIN_16: Twiddles<16> = twiddles();
static JOIN_64: Twiddles<64> = twiddles();

/// Twiddles for L = 4, 16, 64.
static STAGES: [&[[Packed; 3]]; 3] = [&JOIN_4, &JOIN_16, &JOIN_64];

/// The block's magnitude, gathered from what a stage writes: no pass of its own.
#[derive(Clone, Copy, Default)]
pub struct Headroom(u32);

impl Headroom {
    /// Takes one more number into account.
    #[inline(always)]
    pub fn see(&mut self, x: Packed) {
        // Where neighbouring bits differ, the number needs the upper one: sign extension has none.
        self.0 |= x.0 ^ (x.0 << 1);
    }

    /// Whether every part seen lies in -8192…8191.
    #[inline(always)]
    fn is_ample(self) -> bool {
        self.0 & 0xc000_c000 == 0
    }
}

/// Four-point transform.
#[inline(always)]
pub fn butterfly4(t: [Packed; 4]) -> [Packed; 4] {
    let [t0, t1, t2, t3] = t;
    let (even_sum, even_diff) = (add(t0, t2), sub(t0, t2));
    let (odd_sum, odd_diff) = (add(t1, t3), sub(t1, t3));
    [
        add(even_sum, odd_sum),
        sub_j(even_diff, odd_diff),
        sub(even_sum, odd_sum),
        add_j(even_diff, odd_diff),
    ]
}

/// Twiddled four-point transform: one step of a radix-4 stage, scaled by 1/2 or 1/4.
///
/// The products are halved as they are rounded; the quarter's other half is taken from the last
/// sums, which costs less noise than rounding all four terms to it.
#[inline(always)]
fn join4<const QUARTER: bool>(x: [Packed; 4], w: &[Packed; 3]) -> [Packed; 4] {
    let [x0, x1, x2, x3] = x;
    let [w1, w2, w3] = *w;
    let (t0, t1) = (half_sum(x0, ONES), mul_half(x1, w1));
    let (t2, t3) = (mul_half(x2, w2), mul_half(x3, w3));
    if !QUARTER {
        return butterfly4([t0, t1, t2, t3]);
    }
    let (even_sum, even_diff) = (add(t0, t2), sub(t0, t2));
    let (odd_sum, odd_diff) = (add(t1, t3), sub(t1, t3));
    [
        half_sum(even_sum, odd_sum),
        half_diff_j(even_diff, odd_diff),
        half_diff(even_sum, odd_sum),
        half_sum_j(even_diff, odd_diff),
    ]
}

/// Splits into four quarters.
#[inline(always)]
pub fn quarters<T>(x: &mut [T]) -> [&mut [T]; 4] {
    let n = x.len() / 4;
    let (lower, upper) = x.split_at_mut(2 * n);
    let (a, b) = lower.split_at_mut(n);
    let (c, d) = upper.split_at_mut(n);
    [a, b, c, d]
}

/// A radix-4 stage: reads L blocks of 4r numbers, writes four quarters of L blocks of r numbers.
#[inline(always)]
fn stage4<const QUARTER: bool>(
    src: &[Packed],
    dst: &mut [Packed],
    table: &[[Packed; 3]],
) -> Headroom {
    let mut seen = Headroom::default();
    let r = (src.len() / 4 / table.len()).max(1);
    let [a, b, c, d] = quarters(dst);
    let outputs = a
        .chunks_exact_mut(r)
        .zip(b.chunks_exact_mut(r))
        .zip(c.chunks_exact_mut(r))
        .zip(d.chunks_exact_mut(r));
    for ((block, w), (((y0, y1), y2), y3)) in src.chunks_exact(4 * r).zip(table).zip(outputs) {
        let (lower, upper) = block.split_at(2 * r);
        let (x0, x1) = lower.split_at(r);
        let (x2, x3) = upper.split_at(r);
        let inputs = x0.iter().zip(x1).zip(x2).zip(x3);
        let outputs = y0.iter_mut().zip(y1).zip(y2).zip(y3);
        for ((((x0, x1), x2), x3), (((y0, y1), y2), y3)) in inputs.zip(outputs) {
            let y = join4::<QUARTER>([*x0, *x1, *x2, *x3], w);
            for v in y {
                seen.see(v);
            }
            [*y0, *y1, *y2, *y3] = y;
        }
    }
    seen
}

/// The last radix-4 stage, straight into power.
#[inline(always)]
fn last4<const QUARTER: bool>(src: &[Packed], power: &mut [u32], table: &[[Packed; 3]]) {
    let [a, b, c, d] = quarters(power);
    let (blocks, _) = src.as_chunks::<4>();
    let outputs = a.iter_mut().zip(b).zip(c).zip(d);
    for ((x, w), (((p0, p1), p2), p3)) in blocks.iter().zip(table).zip(outputs) {
        [*p0, *p1, *p2, *p3] = join4::<QUARTER>(*x, w).map(norm);
    }
}

/// A last radix-2 stage, straight into power; its overall factor is 1/2.
///
/// W(2L)^k = W(4L)^2k, so that the radix-4 table of the same L serves.
fn last2(src: &[Packed], power: &mut [u32], table: &[[Packed; 3]]) {
    let (low, high) = power.split_at_mut(src.len() / 2);
    let (blocks, _) = src.as_chunks::<2>();
    for (([x0, x1], [_, w, _]), (p0, p1)) in blocks.iter().zip(table).zip(low.iter_mut().zip(high))
    {
        let (t0, t1) = (half_sum(*x0, ONES), mul_half(*x1, *w));
        *p0 = norm(add(t0, t1));
        *p1 = norm(sub(t0, t1));
    }
}

/// The stages after the first: `data` holds the first stage's output (four quarters of
/// four-point transforms), `spare` is of the same length, `power` receives |X|² of every bin.
///
/// Returns the exponent e: the transform's true values are 2^e times those whose power is given.
pub fn finish(
    data: &mut [Packed],
    spare: &mut [Packed],
    power: &mut [u32],
    mut seen: Headroom,
) -> i32 {
    let mut exponent = 0;
    let (mut src, mut dst) = (data, spare);
    let mut joined = 4;
    for table in STAGES {
        if joined == src.len() {
            // All joined already: only a transform of four points could be that short.
            break;
        }
        let quarter = !seen.is_ample();
        match src.len() / joined {
            2 => {
                last2(src, power, table);
                return exponent + 1;
            }
            4 => {
                if quarter {
                    last4::<true>(src, power, table);
                } else {
                    last4::<false>(src, power, table);
                }
                return exponent + 1 + i32::from(quarter);
            }
            _ => {
                seen = if quarter {
                    stage4::<true>(src, dst, table)
                } else {
                    stage4::<false>(src, dst, table)
                };
            }
        }
        exponent += 1 + i32::from(quarter);
        core::mem::swap(&mut src, &mut dst);
        joined *= 4;
    }
    exponent
}
