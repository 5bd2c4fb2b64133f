//! Elementary operations in plain Rust.

use super::arithmetic::{Arithmetic, Packed};

/// Arithmetic in plain Rust: the reference for the tests of the instructions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Portable;

/// Applies `op` to the real parts, and to the imaginary parts, of two numbers.
#[inline(always)]
fn each(a: Packed, b: Packed, op: impl Fn(i32, i32) -> i32) -> Packed {
    let (re, im) = (
        op(a.re().into(), b.re().into()),
        op(a.im().into(), b.im().into()),
    );
    Packed::new(re as i16, im as i16)
}

/// Returns j·b with 17-bit parts, because the real part of -j·32768 does not fit 16 bits.
#[inline(always)]
fn times_j(b: Packed) -> (i32, i32) {
    (-i32::from(b.im()), i32::from(b.re()))
}

/// Applies `op` to the real parts, and to the imaginary parts, of a and of j·b.
#[inline(always)]
fn each_j(a: Packed, b: Packed, op: impl Fn(i32, i32) -> i32) -> Packed {
    let (re, im) = times_j(b);
    Packed::new(op(a.re().into(), re) as i16, op(a.im().into(), im) as i16)
}

/// Returns the product of two 16-bit parts.
#[inline(always)]
fn product(a: i16, b: i16) -> i32 {
    i32::from(a) * i32::from(b)
}

impl Arithmetic for Portable {
    #[inline(always)]
    fn add(a: Packed, b: Packed) -> Packed {
        each(a, b, |x, y| x + y)
    }

    #[inline(always)]
    fn sub(a: Packed, b: Packed) -> Packed {
        each(a, b, |x, y| x - y)
    }

    #[inline(always)]
    fn add_j(a: Packed, b: Packed) -> Packed {
        each_j(a, b, |x, y| x + y)
    }

    #[inline(always)]
    fn sub_j(a: Packed, b: Packed) -> Packed {
        each_j(a, b, |x, y| x - y)
    }

    #[inline(always)]
    fn half_add(a: Packed, b: Packed) -> Packed {
        each(a, b, |x, y| (x + y) >> 1)
    }

    #[inline(always)]
    fn half_sub(a: Packed, b: Packed) -> Packed {
        each(a, b, |x, y| (x - y) >> 1)
    }

    #[inline(always)]
    fn half_add_j(a: Packed, b: Packed) -> Packed {
        each_j(a, b, |x, y| (x + y) >> 1)
    }

    #[inline(always)]
    fn half_sub_j(a: Packed, b: Packed) -> Packed {
        each_j(a, b, |x, y| (x - y) >> 1)
    }

    #[inline(always)]
    fn sort(a: Packed, b: Packed) -> (Packed, Packed) {
        (Self::min(a, b), Self::max(a, b))
    }

    #[inline(always)]
    fn max(a: Packed, b: Packed) -> Packed {
        each(a, b, i32::max)
    }

    #[inline(always)]
    fn min(a: Packed, b: Packed) -> Packed {
        each(a, b, i32::min)
    }

    #[inline(always)]
    fn mul_re(a: Packed, b: Packed, acc: i32) -> i32 {
        acc.wrapping_add(product(a.re(), b.re()))
            .wrapping_sub(product(a.im(), b.im()))
    }

    #[inline(always)]
    fn mul_im(a: Packed, b: Packed, acc: i32) -> i32 {
        acc.wrapping_add(product(a.re(), b.im()))
            .wrapping_add(product(a.im(), b.re()))
    }

    #[inline(always)]
    fn dot(a: Packed, b: Packed, acc: i32) -> i32 {
        acc.wrapping_add(product(a.re(), b.re()))
            .wrapping_add(product(a.im(), b.im()))
    }

    #[inline(always)]
    fn norm(a: Packed) -> u32 {
        Self::dot(a, a, 0) as u32
    }

    #[inline(always)]
    fn scale_re(a: Packed, c: i32, acc: i32) -> i32 {
        acc.wrapping_add(product(a.re(), c as i16))
    }

    #[inline(always)]
    fn scale_im(a: Packed, c: i32, acc: i32) -> i32 {
        acc.wrapping_add(product(a.im(), c as i16))
    }

    #[inline(always)]
    fn scale_wide(a: i32, c: i32) -> i32 {
        ((i64::from(a) * i64::from(c as i16)) >> 16) as i32
    }

    #[inline(always)]
    fn mul_high(a: i32, b: i32) -> i32 {
        ((i64::from(a) * i64::from(b) + (1 << 31)) >> 32) as i32
    }

    #[inline(always)]
    fn test(bits: u32, value: u64, limit: u64, a: i32, b: i32) -> (u32, u64) {
        (
            u32::from(value >= limit) << 31 | bits >> 1,
            limit.wrapping_add_signed(i64::from(a) * i64::from(b)),
        )
    }

    #[inline(always)]
    fn pack_high(re: i32, im: i32) -> Packed {
        Packed(im as u32 & 0xffff_0000 | re as u32 >> 16)
    }

    #[inline(always)]
    fn pack_low(re: i32, im: i32) -> Packed {
        Packed::new(re as i16, im as i16)
    }
}
