//! Packed complex numbers, their elementary operations, and the stages of a transform in terms of these.

use crate::Iq;

/// A complex number of two 16-bit parts, the real part in the lower half-word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(transparent)]
pub struct Packed(pub u32);

impl Packed {
    /// Zero.
    pub const ZERO: Self = Self(0);
    /// 1 + j: the rounding constant for halving both parts.
    pub const ONES: Self = Self(0x0001_0001);
    /// Operand of [`Arithmetic::dot`] that selects the real part of the other operand.
    pub const REAL: Self = Self(0x0000_0001);
    /// Operand of [`Arithmetic::dot`] that selects the imaginary part of the other operand.
    pub const IMAGINARY: Self = Self(0x0001_0000);

    /// Creates a number from real and imaginary part.
    #[inline(always)]
    pub const fn new(re: i16, im: i16) -> Self {
        Self(re as u16 as u32 | (im as u16 as u32) << 16)
    }

    /// Returns the real part of this number with the imaginary part of the other.
    #[inline(always)]
    pub const fn with_im_of(self, other: Self) -> Self {
        Self(self.0 & 0xffff | other.0 & 0xffff_0000)
    }

    /// Real part.
    #[inline(always)]
    pub const fn re(self) -> i16 {
        self.0 as i16
    }

    /// Imaginary part.
    #[inline(always)]
    pub const fn im(self) -> i16 {
        (self.0 >> 16) as i16
    }
}

impl From<Iq> for Packed {
    #[inline(always)]
    fn from(x: Iq) -> Self {
        Self::new(x.i, x.q)
    }
}

/// Elementary operations of range processing, on packed complex numbers or 32-bit integers; all wrap on
/// overflow.
pub trait Arithmetic {
    /// a + b.
    fn add(a: Packed, b: Packed) -> Packed;
    /// a - b.
    fn sub(a: Packed, b: Packed) -> Packed;
    /// a + jb.
    fn add_j(a: Packed, b: Packed) -> Packed;
    /// a - jb.
    fn sub_j(a: Packed, b: Packed) -> Packed;
    /// ⌊(a + b) / 2⌋ of each part, without overflow.
    fn half_add(a: Packed, b: Packed) -> Packed;
    /// ⌊(a - b) / 2⌋ of each part, without overflow.
    fn half_sub(a: Packed, b: Packed) -> Packed;
    /// ⌊(a + jb) / 2⌋ of each part, without overflow.
    fn half_add_j(a: Packed, b: Packed) -> Packed;
    /// ⌊(a - jb) / 2⌋ of each part, without overflow.
    fn half_sub_j(a: Packed, b: Packed) -> Packed;
    /// The smaller and the larger of the real parts, likewise of the imaginary parts.
    fn sort(a: Packed, b: Packed) -> (Packed, Packed);
    /// The larger of the real parts with the larger of the imaginary parts.
    fn max(a: Packed, b: Packed) -> Packed;
    /// The smaller of the real parts with the smaller of the imaginary parts.
    fn min(a: Packed, b: Packed) -> Packed;

    /// acc + Re(a·b).
    fn mul_re(a: Packed, b: Packed, acc: i32) -> i32;
    /// acc + Im(a·b).
    fn mul_im(a: Packed, b: Packed, acc: i32) -> i32;
    /// acc + Re a · Re b + Im a · Im b, the sum of products of the parts.
    fn dot(a: Packed, b: Packed, acc: i32) -> i32;
    /// |a|².
    fn norm(a: Packed) -> u32;

    /// acc + Re a · c, for c of 16 bits.
    fn scale_re(a: Packed, c: i32, acc: i32) -> i32;
    /// acc + Im a · c, for c of 16 bits.
    fn scale_im(a: Packed, c: i32, acc: i32) -> i32;
    /// ⌊a·c / 2¹⁶⌋, for c of 16 bits.
    fn scale_wide(a: i32, c: i32) -> i32;
    /// a·b / 2³², rounded.
    fn mul_high(a: i32, b: i32) -> i32;

    /// Tests one cell against a running limit: shifts `bits` right by one, sets the top bit if `value` reaches
    /// `limit`, and adds a·b to the limit.
    fn test(bits: u32, value: u64, limit: u64, a: i32, b: i32) -> (u32, u64);

    /// Tests 32 neighbouring cells of a profile against their running CFAR limits, with `GUARD` guard and
    /// `TRAINING` training cells on each side; bit k is set if cell k reaches its limit.
    ///
    /// `cells` begins with the first cell's first training cell. A limit is the sum of the training cells times
    /// `unit`; it is compared with the power times the ratio. Returns the bits, and the limit of the cell after
    /// the last.
    #[inline(always)]
    fn test_word<const GUARD: usize, const TRAINING: usize>(
        cells: &[u32],
        ratios: &[u32; 32],
        mut limit: u64,
        unit: i32,
    ) -> (u32, u64) {
        let reach = GUARD + TRAINING;
        let mut bits = 0;
        for (cells, ratio) in cells.windows(2 * reach + 2).zip(ratios) {
            let value = u64::from(cells[reach]) * u64::from(*ratio);
            // Cells that enter and leave the sum when both windows move by one cell.
            let step = cells[TRAINING]
                .wrapping_add(cells[2 * reach + 1])
                .wrapping_sub(cells[reach + GUARD + 1])
                .wrapping_sub(cells[0]) as i32;
            (bits, limit) = Self::test(bits, value, limit, step, unit);
        }
        (bits, limit)
    }

    /// Combines the upper half-words of `re` and `im` to one complex number.
    fn pack_high(re: i32, im: i32) -> Packed;
    /// Combines the lower half-words of `re` and `im` to one complex number.
    fn pack_low(re: i32, im: i32) -> Packed;

    /// a·b / 2, rounded, of Q15 numbers with |a|·|b| below √2.
    ///
    /// The upper half-word of the product of two Q15 numbers is half the product: the transform's headroom
    /// without an extra instruction.
    #[inline(always)]
    fn mul_half(a: Packed, b: Packed) -> Packed {
        const ROUND: i32 = 0x8000;
        Self::pack_high(Self::mul_re(a, b, ROUND), Self::mul_im(a, b, ROUND))
    }

    /// Four-point transform of t0…t3, without scaling.
    #[inline(always)]
    fn butterfly([t0, t1, t2, t3]: [Packed; 4]) -> [Packed; 4] {
        let (even_sum, even_diff) = (Self::add(t0, t2), Self::sub(t0, t2));
        let (odd_sum, odd_diff) = (Self::add(t1, t3), Self::sub(t1, t3));
        [
            Self::add(even_sum, odd_sum),
            Self::sub_j(even_diff, odd_diff),
            Self::sub(even_sum, odd_sum),
            Self::add_j(even_diff, odd_diff),
        ]
    }

    /// Half the four-point transform of t0…t3.
    #[inline(always)]
    fn half_butterfly([t0, t1, t2, t3]: [Packed; 4]) -> [Packed; 4] {
        let (even_sum, even_diff) = (Self::add(t0, t2), Self::sub(t0, t2));
        let (odd_sum, odd_diff) = (Self::add(t1, t3), Self::sub(t1, t3));
        [
            Self::half_add(even_sum, odd_sum),
            Self::half_sub_j(even_diff, odd_diff),
            Self::half_sub(even_sum, odd_sum),
            Self::half_add_j(even_diff, odd_diff),
        ]
    }

    /// A radix-4 stage of the transform of N points: joins transforms of L points by fours, scaled
    /// by 1/2 or 1/4. Reads L blocks of N / L numbers, writes four quarters of L blocks.
    ///
    /// Returns the bits that the numbers written need (see [`magnitude_bits`]).
    #[inline(always)]
    fn stage<const N: usize, const L: usize, const QUARTER: bool>(
        src: &[Packed; N],
        dst: &mut [Packed; N],
        table: &[[Packed; 3]; L],
    ) -> u32 {
        stage_by::<Self>(src, dst, table, QUARTER)
    }

    /// Runs the last stage of the transform, N = 4L, and writes the bins in the form `B`, complex or power.
    #[inline(always)]
    fn last<B: Bin, const N: usize, const L: usize, const QUARTER: bool>(
        src: &[Packed; N],
        bins: &mut [B; N],
        table: &[[Packed; 3]; L],
    ) {
        last_by::<Self, B>(src, bins, table, QUARTER);
    }

    /// Runs the last stage of the transform, N = 4L, and writes the power of the bins.
    #[inline(always)]
    fn last_power<const N: usize, const L: usize, const QUARTER: bool>(
        src: &[Packed; N],
        power: &mut [u32; N],
        table: &[[Packed; 3]; L],
    ) {
        Self::last::<u32, N, L, QUARTER>(src, power, table);
    }
}

/// Multiplies all numbers by a phasor in Q15, rounded.
#[inline(always)]
pub fn turn<A: Arithmetic + ?Sized>(numbers: &mut [Packed], phasor: Packed) {
    const HALF: i32 = 1 << 14;
    for x in numbers {
        let (re, im) = (A::mul_re(*x, phasor, HALF), A::mul_im(*x, phasor, HALF));
        *x = Packed::new((re >> 15) as i16, (im >> 15) as i16);
    }
}

/// Form in which the transform's last stage writes a bin: complex, or power.
pub trait Bin: Copy {
    /// Returns the bin in this form for its complex value `x`.
    fn of<A: Arithmetic + ?Sized>(x: Packed) -> Self;

    /// Returns the bin in this form for the complex conjugate of `x`.
    fn of_conjugate<A: Arithmetic + ?Sized>(x: Packed) -> Self;

    /// Returns the bin's power.
    fn power<A: Arithmetic + ?Sized>(self) -> u32;

    /// Runs the last stage of the transform with bins of this form as output; for power there is a faster
    /// function.
    #[inline(always)]
    fn last<A: Arithmetic, const N: usize, const L: usize, const QUARTER: bool>(
        src: &[Packed; N],
        bins: &mut [Self; N],
        table: &[[Packed; 3]; L],
    ) {
        A::last::<Self, N, L, QUARTER>(src, bins, table);
    }
}

/// Bin as a complex number.
impl Bin for Packed {
    #[inline(always)]
    fn of<A: Arithmetic + ?Sized>(x: Packed) -> Self {
        x
    }

    fn of_conjugate<A: Arithmetic + ?Sized>(x: Packed) -> Self {
        Self::new(x.re(), x.im().saturating_neg())
    }

    fn power<A: Arithmetic + ?Sized>(self) -> u32 {
        A::norm(self)
    }
}

/// Bin as power, the squared magnitude.
impl Bin for u32 {
    #[inline(always)]
    fn of<A: Arithmetic + ?Sized>(x: Packed) -> Self {
        A::norm(x)
    }

    #[inline(always)]
    fn of_conjugate<A: Arithmetic + ?Sized>(x: Packed) -> Self {
        A::norm(x)
    }

    #[inline(always)]
    fn power<A: Arithmetic + ?Sized>(self) -> u32 {
        self
    }

    #[inline(always)]
    fn last<A: Arithmetic, const N: usize, const L: usize, const QUARTER: bool>(
        src: &[Packed; N],
        bins: &mut [Self; N],
        table: &[[Packed; 3]; L],
    ) {
        A::last_power::<N, L, QUARTER>(src, bins, table);
    }
}

/// Returns the four quarters of a slice whose length is divisible by four.
#[inline(always)]
pub fn quarters<T>(x: &mut [T]) -> [&mut [T]; 4] {
    let (lower, upper) = halves(x);
    let ((a, b), (c, d)) = (halves(lower), halves(upper));
    [a, b, c, d]
}

#[inline(always)]
pub(in crate::signal::range) fn halves<T>(x: &mut [T]) -> (&mut [T], &mut [T]) {
    let middle = x.len() / 2;
    x.split_at_mut_checked(middle).unwrap_or_default()
}

/// Reference implementation of [`Arithmetic::stage`] for any length N of `src` and `dst` and L of `table`.
#[inline(always)]
pub(in crate::signal::range) fn stage_by<A: Arithmetic + ?Sized>(
    src: &[Packed],
    dst: &mut [Packed],
    table: &[[Packed; 3]],
    quarter: bool,
) -> u32 {
    let r = src.len() / 4 / table.len().max(1);
    let mut seen = 0;
    let mut part = {
        let mut rest = src;
        move || rest.split_off(..r).unwrap_or_default().iter()
    };
    let mut blocks = quarters(dst);
    for w in table {
        let inputs = part().zip(part()).zip(part().zip(part()));
        let [y0, y1, y2, y3] =
            (blocks.each_mut()).map(|y| y.split_off_mut(..r).unwrap_or_default());
        let outputs = y0.iter_mut().zip(y1).zip(y2.iter_mut().zip(y3));
        for (((x0, x1), (x2, x3)), ((y0, y1), (y2, y3))) in inputs.zip(outputs) {
            let y = join::<A>([*x0, *x1, *x2, *x3], w, quarter);
            seen |= y.into_iter().fold(0, |bits, y| bits | magnitude_bits(y));
            [*y0, *y1, *y2, *y3] = y;
        }
    }
    seen
}

/// Reference implementation of [`Arithmetic::last`] for any length.
#[inline(always)]
pub(in crate::signal::range) fn last_by<A: Arithmetic + ?Sized, B: Bin>(
    src: &[Packed],
    bins: &mut [B],
    table: &[[Packed; 3]],
    quarter: bool,
) {
    let [y0, y1, y2, y3] = quarters(bins);
    let (blocks, _) = src.as_chunks::<4>();
    let outputs = y0.iter_mut().zip(y1).zip(y2.iter_mut().zip(y3));
    for ((x, w), ((y0, y1), (y2, y3))) in blocks.iter().zip(table).zip(outputs) {
        [*y0, *y1, *y2, *y3] = join::<A>(*x, w, quarter).map(B::of::<A>);
    }
}

/// Returns a word in which those bits are set that differ from the next lower bit of `x`. The highest one set
/// gives the number of significant bits of a part (real or imaginary): the bits of a sign extension are all
/// equal.
#[inline(always)]
pub fn magnitude_bits(x: Packed) -> u32 {
    x.0 ^ (x.0 << 1)
}

/// One step of a radix-4 stage: the four-point transform of x0 and of the products of x1, x2, x3
/// with `w`, scaled by 1/2 or 1/4, products and x0 rounded.
///
/// With scale 1/4 the second halving is done in the last sums, which has less noise than rounding the terms to
/// quarters.
#[inline(always)]
fn join<A: Arithmetic + ?Sized>(
    [x0, x1, x2, x3]: [Packed; 4],
    [w1, w2, w3]: &[Packed; 3],
    quarter: bool,
) -> [Packed; 4] {
    let terms = [
        A::half_add(x0, Packed::ONES),
        A::mul_half(x1, *w1),
        A::mul_half(x2, *w2),
        A::mul_half(x3, *w3),
    ];
    if quarter {
        A::half_butterfly(terms)
    } else {
        A::butterfly(terms)
    }
}
