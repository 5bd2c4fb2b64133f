//! Complex numbers packed into one word, and the arithmetic on them.
//!
//! The Cortex-M4's DSP extension works on two 16-bit halves of a word at a time. Each function of
//! [`Arithmetic`] stands for one of its instructions; [`Portable`] spells out what it means and
//! runs anywhere, `Dsp` is the instruction itself. Both give the same bits.

#[cfg(target_arch = "arm")]
mod dsp;
mod portable;

#[cfg(target_arch = "arm")]
pub use dsp::Dsp;
pub use portable::Portable;

use crate::Iq;

/// What this target computes with.
#[cfg(target_arch = "arm")]
pub type Native = Dsp;
/// What this target computes with.
#[cfg(not(target_arch = "arm"))]
pub type Native = Portable;

/// A complex number of two 16-bit parts, the real part in the lower half-word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(transparent)]
pub struct Packed(pub u32);

impl Packed {
    /// Zero.
    pub const ZERO: Self = Self(0);
    /// 1, or what rounds the halving of both parts, times 1 + j.
    pub const ONES: Self = Self(0x0001_0001);
    /// The unit that picks the real part out of a [`Arithmetic::dot`].
    pub const REAL: Self = Self(0x0000_0001);
    /// The unit that picks the imaginary part.
    pub const IMAGINARY: Self = Self(0x0001_0000);

    /// From real and imaginary part.
    #[inline(always)]
    pub const fn new(re: i16, im: i16) -> Self {
        Self(re as u16 as u32 | (im as u16 as u32) << 16)
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

/// The instructions that range processing is made of, all on packed complex numbers or 32-bit
/// integers, all wrapping where they overflow.
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
    /// The larger of each part.
    fn max(a: Packed, b: Packed) -> Packed;
    /// The smaller of each part.
    fn min(a: Packed, b: Packed) -> Packed;

    /// acc + Re(a·b).
    fn mul_re(a: Packed, b: Packed, acc: i32) -> i32;
    /// acc + Im(a·b).
    fn mul_im(a: Packed, b: Packed, acc: i32) -> i32;
    /// acc + Re a · Re b + Im a · Im b.
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

    /// The upper half-words of `re` and `im` as one complex number.
    fn pack_high(re: i32, im: i32) -> Packed;
    /// The lower half-words of `re` and `im` as one complex number.
    fn pack_low(re: i32, im: i32) -> Packed;

    /// a·b / 2, rounded, of Q15 numbers with |a|·|b| below √2.
    ///
    /// The product of two Q15 numbers, taken from the upper half-word, is halved for nothing: that
    /// is the transform's headroom.
    #[inline(always)]
    fn mul_half(a: Packed, b: Packed) -> Packed {
        const ROUND: i32 = 0x8000;
        Self::pack_high(Self::mul_re(a, b, ROUND), Self::mul_im(a, b, ROUND))
    }
}
