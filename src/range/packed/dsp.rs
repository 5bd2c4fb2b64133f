//! The instructions of the ARMv7E-M DSP extension (ARM DDI 0403E, A7.7).
//!
//! None touches memory or the stack. Some set the GE or Q flags, which compiled code never reads;
//! they are left declared as clobbered.

use super::{Arithmetic, Packed};
use core::arch::asm;

/// Arithmetic by the chip's own packed instructions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Dsp;

/// A function that is one instruction: result, operands in the instruction's order.
macro_rules! instruction {
    (($($operand:ident),+) = $text:literal) => {{
        let result: u32;
        // SAFETY: the instruction reads its operands and writes its result, nothing else.
        unsafe {
            asm!(
                $text,
                r = lateout(reg) result,
                $($operand = in(reg) $operand,)+
                options(pure, nomem, nostack)
            )
        };
        result
    }};
}

/// An instruction on two packed numbers.
macro_rules! packed {
    ($a:ident, $b:ident, $text:literal) => {{
        let (a, b) = ($a.0, $b.0);
        Packed(instruction!((a, b) = $text))
    }};
}

impl Arithmetic for Dsp {
    // Both halves added, subtracted, or crosswise: the products with j cost nothing.
    #[inline(always)]
    fn add(a: Packed, b: Packed) -> Packed {
        packed!(a, b, "sadd16 {r}, {a}, {b}")
    }

    #[inline(always)]
    fn sub(a: Packed, b: Packed) -> Packed {
        packed!(a, b, "ssub16 {r}, {a}, {b}")
    }

    #[inline(always)]
    fn add_j(a: Packed, b: Packed) -> Packed {
        packed!(a, b, "sasx {r}, {a}, {b}")
    }

    #[inline(always)]
    fn sub_j(a: Packed, b: Packed) -> Packed {
        packed!(a, b, "ssax {r}, {a}, {b}")
    }

    // The same with the 17-bit results halved: scaling costs nothing.
    #[inline(always)]
    fn half_add(a: Packed, b: Packed) -> Packed {
        packed!(a, b, "shadd16 {r}, {a}, {b}")
    }

    #[inline(always)]
    fn half_sub(a: Packed, b: Packed) -> Packed {
        packed!(a, b, "shsub16 {r}, {a}, {b}")
    }

    #[inline(always)]
    fn half_add_j(a: Packed, b: Packed) -> Packed {
        packed!(a, b, "shasx {r}, {a}, {b}")
    }

    #[inline(always)]
    fn half_sub_j(a: Packed, b: Packed) -> Packed {
        packed!(a, b, "shsax {r}, {a}, {b}")
    }

    // SSUB16 leaves a half's GE flags set where its difference is not negative (of the full 17
    // bits), SEL chooses by them.
    #[inline(always)]
    fn max(a: Packed, b: Packed) -> Packed {
        let (a, b) = (a.0, b.0);
        let result: u32;
        // SAFETY: reads its operands, writes its result, declares the flags clobbered.
        unsafe {
            asm!(
                "ssub16 {r}, {a}, {b}",
                "sel {r}, {a}, {b}",
                r = out(reg) result,
                a = in(reg) a,
                b = in(reg) b,
                options(pure, nomem, nostack)
            )
        };
        Packed(result)
    }

    #[inline(always)]
    fn min(a: Packed, b: Packed) -> Packed {
        let (a, b) = (a.0, b.0);
        let result: u32;
        // SAFETY: reads its operands, writes its result, declares the flags clobbered.
        unsafe {
            asm!(
                "ssub16 {r}, {a}, {b}",
                "sel {r}, {b}, {a}",
                r = out(reg) result,
                a = in(reg) a,
                b = in(reg) b,
                options(pure, nomem, nostack)
            )
        };
        Packed(result)
    }

    // Two products and their sum or difference in one cycle.
    #[inline(always)]
    fn mul_re(a: Packed, b: Packed, acc: i32) -> i32 {
        let (a, b) = (a.0, b.0);
        instruction!((a, b, acc) = "smlsd {r}, {a}, {b}, {acc}") as i32
    }

    #[inline(always)]
    fn mul_im(a: Packed, b: Packed, acc: i32) -> i32 {
        let (a, b) = (a.0, b.0);
        instruction!((a, b, acc) = "smladx {r}, {a}, {b}, {acc}") as i32
    }

    #[inline(always)]
    fn dot(a: Packed, b: Packed, acc: i32) -> i32 {
        let (a, b) = (a.0, b.0);
        instruction!((a, b, acc) = "smlad {r}, {a}, {b}, {acc}") as i32
    }

    #[inline(always)]
    fn norm(a: Packed) -> u32 {
        let a = a.0;
        instruction!((a) = "smuad {r}, {a}, {a}")
    }

    // 16 × 16 bits from either half, 32 × 16 bits, and the upper word of 32 × 32 bits.
    #[inline(always)]
    fn scale_re(a: Packed, c: i32, acc: i32) -> i32 {
        let a = a.0;
        instruction!((a, c, acc) = "smlabb {r}, {a}, {c}, {acc}") as i32
    }

    #[inline(always)]
    fn scale_im(a: Packed, c: i32, acc: i32) -> i32 {
        let a = a.0;
        instruction!((a, c, acc) = "smlatb {r}, {a}, {c}, {acc}") as i32
    }

    #[inline(always)]
    fn scale_wide(a: i32, c: i32) -> i32 {
        instruction!((a, c) = "smulwb {r}, {a}, {c}") as i32
    }

    #[inline(always)]
    fn mul_high(a: i32, b: i32) -> i32 {
        instruction!((a, b) = "smmulr {r}, {a}, {b}") as i32
    }

    #[inline(always)]
    fn pack_high(re: i32, im: i32) -> Packed {
        Packed(instruction!((re, im) = "pkhtb {r}, {im}, {re}, asr #16"))
    }

    #[inline(always)]
    fn pack_low(re: i32, im: i32) -> Packed {
        Packed(instruction!((re, im) = "pkhbt {r}, {re}, {im}, lsl #16"))
    }
}
