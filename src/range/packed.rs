//! Complex numbers packed into one word, real part in the lower half-word: the data type of the
//! Cortex-M4's DSP extension, and its instructions as functions.
//!
//! Every function is one instruction on the chip; the portable body here is its definition.

/// A complex number of two Q0.15 parts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(transparent)]
pub struct Packed(pub u32);

/// Both parts one: what rounds a halving.
pub const ONES: Packed = Packed(0x0001_0001);
/// Both parts zero.
pub const ZERO: Packed = Packed(0);

impl Packed {
    /// From real and imaginary part.
    pub const fn new(re: i16, im: i16) -> Self {
        Self(re as u16 as u32 | (im as u16 as u32) << 16)
    }

    /// Real part.
    pub const fn re(self) -> i16 {
        self.0 as i16
    }

    /// Imaginary part.
    pub const fn im(self) -> i16 {
        (self.0 >> 16) as i16
    }
}

/// a + b (`SADD16`).
#[inline(always)]
pub fn add(a: Packed, b: Packed) -> Packed {
    Packed::new(a.re().wrapping_add(b.re()), a.im().wrapping_add(b.im()))
}

/// a - b (`SSUB16`).
#[inline(always)]
pub fn sub(a: Packed, b: Packed) -> Packed {
    Packed::new(a.re().wrapping_sub(b.re()), a.im().wrapping_sub(b.im()))
}

/// a + jb (`SASX`).
#[inline(always)]
pub fn add_j(a: Packed, b: Packed) -> Packed {
    Packed::new(a.re().wrapping_sub(b.im()), a.im().wrapping_add(b.re()))
}

/// a - jb (`SSAX`).
#[inline(always)]
pub fn sub_j(a: Packed, b: Packed) -> Packed {
    Packed::new(a.re().wrapping_add(b.im()), a.im().wrapping_sub(b.re()))
}

/// ⌊(a + b) / 2⌋ of each part (`SHADD16`).
#[inline(always)]
pub fn half_sum(a: Packed, b: Packed) -> Packed {
    let half = |x: i16, y: i16| ((i32::from(x) + i32::from(y)) >> 1) as i16;
    Packed::new(half(a.re(), b.re()), half(a.im(), b.im()))
}

/// ⌊(a - b) / 2⌋ of each part (`SHSUB16`).
#[inline(always)]
pub fn half_diff(a: Packed, b: Packed) -> Packed {
    let half = |x: i16, y: i16| ((i32::from(x) - i32::from(y)) >> 1) as i16;
    Packed::new(half(a.re(), b.re()), half(a.im(), b.im()))
}

/// ⌊(a + jb) / 2⌋ of each part (`SHASX`).
#[inline(always)]
pub fn half_sum_j(a: Packed, b: Packed) -> Packed {
    let (re, im) = (i32::from(a.re()), i32::from(a.im()));
    Packed::new(
        ((re - i32::from(b.im())) >> 1) as i16,
        ((im + i32::from(b.re())) >> 1) as i16,
    )
}

/// ⌊(a - jb) / 2⌋ of each part (`SHSAX`).
#[inline(always)]
pub fn half_diff_j(a: Packed, b: Packed) -> Packed {
    let (re, im) = (i32::from(a.re()), i32::from(a.im()));
    Packed::new(
        ((re + i32::from(b.im())) >> 1) as i16,
        ((im - i32::from(b.re())) >> 1) as i16,
    )
}

/// Real part of a·b in Q30, plus `acc` (`SMLSD`).
#[inline(always)]
pub fn mul_re(a: Packed, b: Packed, acc: i32) -> i32 {
    acc.wrapping_add(i32::from(a.re()) * i32::from(b.re()))
        .wrapping_sub(i32::from(a.im()) * i32::from(b.im()))
}

/// Imaginary part of a·b in Q30, plus `acc` (`SMLADX`).
#[inline(always)]
pub fn mul_im(a: Packed, b: Packed, acc: i32) -> i32 {
    acc.wrapping_add(i32::from(a.re()) * i32::from(b.im()))
        .wrapping_add(i32::from(a.im()) * i32::from(b.re()))
}

/// The upper half-words of `re` and `im` as one complex number (`PKHTB … ASR #16`).
#[inline(always)]
pub fn pack_high(re: i32, im: i32) -> Packed {
    Packed(im as u32 & 0xffff_0000 | re as u32 >> 16)
}

/// |a|² (`SMUAD`).
#[inline(always)]
pub fn norm(a: Packed) -> u32 {
    let square = |x: i16| (i32::from(x) * i32::from(x)) as u32;
    square(a.re()) + square(a.im())
}

/// acc + ⌊a·b / 2¹⁶⌋ with the 16-bit b in the lower half-word (`SMLAWB`).
#[inline(always)]
pub fn mul_wide(a: i32, b: i16, acc: i32) -> i32 {
    acc.wrapping_add(((i64::from(a) * i64::from(b)) >> 16) as i32)
}

/// Rounded half of a·b, for |a|·|b| below √2.
///
/// The product of two Q15 numbers taken from the upper half-word is halved for nothing: that is
/// the transform's built-in headroom.
#[inline(always)]
pub fn mul_half(a: Packed, b: Packed) -> Packed {
    const ROUND: i32 = 0x8000;
    pack_high(mul_re(a, b, ROUND), mul_im(a, b, ROUND))
}
