//! Elementary operations by instructions of the ARMv7E-M DSP extension (ARM DDI 0403E, A7.7).
//!
//! None accesses memory or the stack. Some set the GE or Q flags, which compiled code never reads; the flags
//! remain declared as clobbered.

use super::arithmetic::{Arithmetic, Packed};
use core::arch::asm;

/// Arithmetic by the chip's packed instructions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Dsp;

/// Emits one instruction; the operands are in the order of the instruction.
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

/// Emits an instruction on two packed numbers.
macro_rules! packed {
    ($a:ident, $b:ident, $text:literal) => {{
        let (a, b) = ($a.0, $b.0);
        Packed(instruction!((a, b) = $text))
    }};
}

/// Butterfly on x0…x3 in r2…r5, with twiddles in r8…r10 and 0x8000 in r12; overwrites r11.
///
/// Output: y0 in r2, y1 in r3, y2 in r4, y3 in r5. The arguments are the instructions of the last sums.
macro_rules! butterfly {
    ($add:literal, $sub:literal, $add_j:literal, $sub_j:literal) => {
        concat!(
            // x1·w1, x2·w2, x3·w3: real and imaginary part, rounded into the upper half-words.
            "smlsd r11, r3, r8, r12\n smladx r3, r3, r8, r12\n pkhtb r3, r3, r11, asr #16\n",
            "smlsd r11, r4, r9, r12\n smladx r4, r4, r9, r12\n pkhtb r4, r4, r11, asr #16\n",
            "smlsd r11, r5, r10, r12\n smladx r5, r5, r10, r12\n pkhtb r5, r5, r11, asr #16\n",
            // (x0 + 1) / 2.
            "mov r11, #0x00010001\n shadd16 r2, r2, r11\n",
            // Sums and differences of the even terms, then of the odd ones, then of both.
            "sadd16 r11, r2, r4\n ssub16 r4, r2, r4\n",
            "sadd16 r2, r3, r5\n ssub16 r5, r3, r5\n",
            $sub_j,
            " r3, r4, r5\n",
            $add_j,
            " r5, r4, r5\n",
            $sub,
            " r4, r11, r2\n",
            $add,
            " r2, r11, r2\n",
        )
    };
}

/// One step of a stage: reads four numbers from [r0], writes four to [lr], and adds their magnitude bits to r1.
macro_rules! step {
    ($add:literal, $sub:literal, $add_j:literal, $sub_j:literal) => {
        concat!(
            "ldr r3, [r0, #{row}]\n ldr r4, [r0, #2 * {row}]\n ldr r5, [r0, #3 * {row}]\n",
            "ldr r2, [r0], #4\n",
            butterfly!($add, $sub, $add_j, $sub_j),
            "str r3, [lr, #{quarter}]\n str r4, [lr, #2 * {quarter}]\n",
            "str r5, [lr, #3 * {quarter}]\n str r2, [lr], #4\n",
            // Bits that differ from their lower neighbour, see `magnitude_bits`.
            "eor r2, r2, r2, lsl #1\n orr r1, r1, r2\n eor r3, r3, r3, lsl #1\n orr r1, r1, r3\n",
            "eor r4, r4, r4, lsl #1\n orr r1, r1, r4\n eor r5, r5, r5, lsl #1\n orr r1, r1, r5\n",
        )
    };
}

/// A radix-4 stage. Its loops are written in assembly, because the compiler runs out of registers in them (the
/// loops use all available ones and also r6 and r7) and would unroll the outer one.
macro_rules! stage {
    ($n:ident, $l:ident, $src:ident, $dst:ident, $table:ident, $($op:literal),+) => {{
        let twiddles = $table.as_ptr_range();
        let seen: u32;
        // SAFETY: for each of the L twiddles, N / 4L numbers are read from each quarter of a block of N / L of
        // `src`, and as many are written to each quarter of `dst`, consecutively: N of both in total. r6, r7
        // and the stack pointer are restored.
        unsafe {
            asm!(
                "push {{r6, r7}}",
                "push {{r9}}",
                "mov r7, r8",
                "1:",
                "ldm r7!, {{r8, r9, r10}}",
                "mov r6, #{rounds}",
                "2:",
                step!($($op),+),
                step!($($op),+),
                "subs r6, r6, #1",
                "bne 2b",
                "add r0, r0, #3 * {row}",
                "ldr r11, [sp]",
                "cmp r7, r11",
                "bne 1b",
                "pop {{r9}}",
                "pop {{r6, r7}}",
                row = const $n / $l,
                quarter = const $n,
                rounds = const $n / $l / 8,
                inout("r0") $src.as_ptr() => _,
                inout("r1") 0u32 => seen,
                inout("lr") $dst.as_mut_ptr() => _,
                inout("r8") twiddles.start => _,
                inout("r9") twiddles.end => _,
                in("r12") 0x8000,
                out("r2") _,
                out("r3") _,
                out("r4") _,
                out("r5") _,
                out("r10") _,
                out("r11") _,
            );
        }
        seen
    }};
}

/// One step of the last stage: reads four numbers from [r0] and twiddles from [r1], writes powers to [lr].
macro_rules! last_step {
    ($($op:literal),+) => {
        concat!(
            "ldm r0!, {{r2, r3, r4, r5}}\n ldm r1!, {{r8, r9, r10}}\n",
            butterfly!($($op),+),
            "smuad r3, r3, r3\n str r3, [lr, #{quarter}]\n",
            "smuad r4, r4, r4\n str r4, [lr, #2 * {quarter}]\n",
            "smuad r5, r5, r5\n str r5, [lr, #3 * {quarter}]\n",
            "smuad r2, r2, r2\n str r2, [lr], #4\n",
        )
    };
}

/// Last radix-4 stage with power as output.
macro_rules! last_power {
    ($n:ident, $l:ident, $src:ident, $power:ident, $table:ident, $($op:literal),+) => {
        // SAFETY: L times four numbers of `src` and three of `table` are read, which is all of them, and one
        // number is written to each quarter of `power`. r6 is restored.
        unsafe {
            asm!(
                "push {{r6}}",
                "mov r6, #{rounds}",
                "2:",
                last_step!($($op),+),
                last_step!($($op),+),
                "subs r6, r6, #1",
                "bne 2b",
                "pop {{r6}}",
                quarter = const $n,
                rounds = const $l / 2,
                inout("r0") $src.as_ptr() => _,
                inout("r1") $table.as_ptr() => _,
                inout("lr") $power.as_mut_ptr() => _,
                in("r12") 0x8000,
                out("r2") _,
                out("r3") _,
                out("r4") _,
                out("r5") _,
                out("r8") _,
                out("r9") _,
                out("r10") _,
                out("r11") _,
            );
        }
    };
}

/// Tests two neighbouring cells against their running CFAR limits: [r0] first training cell, [r1] ratios, r3:r2
/// limit, r4 bits, r5 unit. Every load reads two words.
macro_rules! test_pair {
    () => {
        concat!(
            // Power times ratio of both cells.
            "ldrd r8, r9, [r0, #{tested}]\n ldrd r10, r11, [r1], #8\n",
            "umull r8, r10, r8, r10\n umull r9, r11, r9, r11\n",
            // Compares the first with its limit: RRX shifts the carry into the bits.
            "subs r8, r8, r2\n sbcs r10, r10, r3\n rrx r4, r4\n",
            // Cells that enter and leave the sums of both.
            "ldrd r8, r10, [r0, #{enters_first}]\n ldrd r12, lr, [r0, #{enters_last}]\n",
            "add r8, r8, r12\n add r10, r10, lr\n ldrd r12, lr, [r0, #{leaves_last}]\n",
            "sub r8, r8, r12\n sub r10, r10, lr\n ldrd r12, lr, [r0], #8\n",
            "sub r8, r8, r12\n sub r10, r10, lr\n smlal r2, r3, r8, r5\n",
            // Compares the second with its limit.
            "subs r9, r9, r2\n sbcs r11, r11, r3\n rrx r4, r4\n smlal r2, r3, r10, r5\n",
        )
    };
}

impl Arithmetic for Dsp {
    // Sums and differences of both halves, or crosswise for the products with j, which need no extra
    // instruction.
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

    // Sums and differences halved from 17-bit results: the scaling needs no extra instruction.
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

    // SSUB16 sets the GE flags of a half if its difference (of the full 17 bits) is not negative; SEL selects
    // by them.
    #[inline(always)]
    fn sort(a: Packed, b: Packed) -> (Packed, Packed) {
        let (mut low, high) = (a.0, b.0);
        let larger: u32;
        // SAFETY: reads its operands, writes its results, declares the flags clobbered.
        unsafe {
            asm!(
                "ssub16 {r}, {a}, {b}",
                "sel {r}, {a}, {b}",
                "sel {a}, {b}, {a}",
                r = out(reg) larger,
                a = inout(reg) low,
                b = in(reg) high,
                options(pure, nomem, nostack)
            )
        };
        (Packed(low), Packed(larger))
    }

    #[inline(always)]
    fn max(a: Packed, b: Packed) -> Packed {
        let (mut a, b) = (a.0, b.0);
        // SAFETY: reads its operands, writes its result, declares the flags clobbered.
        unsafe {
            asm!(
                "ssub16 {r}, {a}, {b}",
                "sel {a}, {a}, {b}",
                r = out(reg) _,
                a = inout(reg) a,
                b = in(reg) b,
                options(pure, nomem, nostack)
            )
        };
        Packed(a)
    }

    #[inline(always)]
    fn min(a: Packed, b: Packed) -> Packed {
        let (mut a, b) = (a.0, b.0);
        // SAFETY: reads its operands, writes its result, declares the flags clobbered.
        unsafe {
            asm!(
                "ssub16 {r}, {a}, {b}",
                "sel {a}, {b}, {a}",
                r = out(reg) _,
                a = inout(reg) a,
                b = in(reg) b,
                options(pure, nomem, nostack)
            )
        };
        Packed(a)
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

    // The subtraction leaves value ≥ limit in the carry flag, which RRX shifts in at the top: no branch and no
    // conditional move. SMLAL adds a 64-bit product.
    #[inline(always)]
    fn test(mut bits: u32, value: u64, limit: u64, a: i32, b: i32) -> (u32, u64) {
        let (mut low, mut high) = (limit as u32, (limit >> 32) as u32);
        // SAFETY: reads its operands, writes its results, declares the flags clobbered.
        unsafe {
            asm!(
                "subs {value_low}, {value_low}, {low}",
                "sbcs {value_high}, {value_high}, {high}",
                "rrx {bits}, {bits}",
                "smlal {low}, {high}, {a}, {b}",
                bits = inout(reg) bits,
                value_low = inout(reg) value as u32 => _,
                value_high = inout(reg) (value >> 32) as u32 => _,
                low = inout(reg) low,
                high = inout(reg) high,
                a = in(reg) a,
                b = in(reg) b,
                options(pure, nomem, nostack)
            )
        };
        (bits, u64::from(high) << 32 | u64::from(low))
    }

    #[inline(always)]
    fn pack_high(re: i32, im: i32) -> Packed {
        Packed(instruction!((re, im) = "pkhtb {r}, {im}, {re}, asr #16"))
    }

    #[inline(always)]
    fn pack_low(re: i32, im: i32) -> Packed {
        Packed(instruction!((re, im) = "pkhbt {r}, {re}, {im}, lsl #16"))
    }

    #[inline(always)]
    fn test_word<const GUARD: usize, const TRAINING: usize>(
        cells: &[u32],
        ratios: &[u32; 32],
        limit: u64,
        unit: i32,
    ) -> (u32, u64) {
        if cells.len() < 2 * (GUARD + TRAINING) + 33 {
            return super::Portable::test_word::<GUARD, TRAINING>(cells, ratios, limit, unit);
        }
        let (mut low, mut high) = (limit as u32, (limit >> 32) as u32);
        let mut bits = 0u32;
        // SAFETY: the last of the 32 cells reads 2 (G + T) + 32 words after the first one's first training
        // cell; the length was checked. r6 is restored.
        unsafe {
            asm!(
                "push {{r6}}",
                "mov r6, #8",
                "2:",
                test_pair!(),
                test_pair!(),
                "subs r6, r6, #1",
                "bne 2b",
                "pop {{r6}}",
                tested = const 4 * (GUARD + TRAINING),
                enters_first = const 4 * TRAINING,
                enters_last = const 4 * (2 * (GUARD + TRAINING) + 1),
                leaves_last = const 4 * (2 * GUARD + TRAINING + 1),
                inout("r0") cells.as_ptr() => _,
                inout("r1") ratios.as_ptr() => _,
                inout("r2") low,
                inout("r3") high,
                inout("r4") bits,
                in("r5") unit,
                out("r8") _,
                out("r9") _,
                out("r10") _,
                out("r11") _,
                out("r12") _,
                out("lr") _,
            );
        }
        (bits, u64::from(high) << 32 | u64::from(low))
    }

    #[inline(always)]
    fn stage<const N: usize, const L: usize, const QUARTER: bool>(
        src: &[Packed; N],
        dst: &mut [Packed; N],
        table: &[[Packed; 3]; L],
    ) -> u32 {
        if !N.is_multiple_of(8 * L) {
            // The loop does two steps per iteration.
            return super::Portable::stage::<N, L, QUARTER>(src, dst, table);
        }
        if QUARTER {
            stage!(
                N, L, src, dst, table, "shadd16", "shsub16", "shasx", "shsax"
            )
        } else {
            stage!(N, L, src, dst, table, "sadd16", "ssub16", "sasx", "ssax")
        }
    }

    #[inline(always)]
    fn last_power<const N: usize, const L: usize, const QUARTER: bool>(
        src: &[Packed; N],
        power: &mut [u32; N],
        table: &[[Packed; 3]; L],
    ) {
        if N != 4 * L || !L.is_multiple_of(2) {
            // The loop does two steps per iteration.
            return super::Portable::last_power::<N, L, QUARTER>(src, power, table);
        }
        if QUARTER {
            last_power!(
                N, L, src, power, table, "shadd16", "shsub16", "shasx", "shsax"
            )
        } else {
            last_power!(N, L, src, power, table, "sadd16", "ssub16", "sasx", "ssax")
        }
    }
}
