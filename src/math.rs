//! The few f32 functions that `core` lacks, with error bounds that the tests assert.
//!
//! All functions use plain IEEE single precision without fused operations, so that host, emulator and chip give
//! identical bits.

/// One degree in radians.
pub const RAD_PER_DEG: f32 = core::f32::consts::PI / 180.0;

/// Correctly rounded square root; 0 for negative arguments and NaN.
#[inline]
pub fn sqrt(x: f32) -> f32 {
    if x > 0.0 { sqrt_positive(x) } else { 0.0 }
}

/// Square root by the FPU: 14 cycles, where the portable one takes some 200 instructions.
#[cfg(target_arch = "arm")]
#[inline]
fn sqrt_positive(x: f32) -> f32 {
    let bits: u32;
    // The stable compiler offers no operands in FPU registers here, so one register is saved and restored.
    // SAFETY: no register but the operands is changed, no memory is touched; the
    // target has the FPU (eabihf).
    unsafe {
        core::arch::asm!(
            "vmov {saved}, s0",
            "vmov s0, {bits}",
            "vsqrt.f32 s0, s0",
            "vmov {bits}, s0",
            "vmov s0, {saved}",
            bits = inlateout(reg) x.to_bits() => bits,
            saved = out(reg) _,
            options(pure, nomem, nostack, preserves_flags)
        )
    };
    f32::from_bits(bits)
}

#[cfg(not(target_arch = "arm"))]
#[inline]
fn sqrt_positive(x: f32) -> f32 {
    libm::sqrtf(x)
}

/// Returns the smallest whole number that is not below `x`: exact.
#[inline]
pub fn ceil(x: f32) -> f32 {
    micromath::F32(x).ceil().0
}

/// Returns the largest whole number that is not above `x`: exact.
#[inline]
pub fn floor(x: f32) -> f32 {
    micromath::F32(x).floor().0
}

/// Returns the nearest whole number, halves away from zero. Exact for |x| < 2²² except for ±0.49999997, the
/// largest number below a half, which rounds to ±1.
#[inline]
pub fn round(x: f32) -> f32 {
    micromath::F32(x).round().0
}

/// Returns the larger of two numbers in three instructions; `f32::max`, which handles NaN, is a call on this
/// core.
#[inline]
pub const fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Returns the smaller of two numbers, like [`max`].
#[inline]
pub const fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Returns the hypotenuse without handling overflow: values are metres and radians.
#[inline]
pub fn hypot(x: f32, y: f32) -> f32 {
    sqrt(x * x + y * y)
}

/// Returns sine and cosine of `angle` (radians, |angle| ≤ 100). Absolute error below 3e-7; maximum in the tests
/// 1.1e-7.
///
/// Reduced to ±π/4 by the nearest quarter turn, then Taylor polynomials to the 9th and 8th order.
pub const fn sin_cos(angle: f32) -> (f32, f32) {
    // π/2 in two parts: k times the first one is exact, because its mantissa ends with many zeros.
    const HALF_PI_HIGH: f32 = 1.570_312_5;
    const HALF_PI_LOW: f32 = 4.838_268e-4;
    let turns = angle * core::f32::consts::FRAC_2_PI;
    let quarter = (turns + if turns < 0.0 { -0.5 } else { 0.5 }) as i32;
    let k = quarter as f32;
    let x = (angle - k * HALF_PI_HIGH) - k * HALF_PI_LOW;
    let z = x * x;
    let s = x + x * z * (-1.0 / 6.0 + z * (1.0 / 120.0 + z * (-1.0 / 5040.0 + z / 362_880.0)));
    let c = 1.0 + z * (-0.5 + z * (1.0 / 24.0 + z * (-1.0 / 720.0 + z / 40_320.0)));
    match quarter & 3 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Returns the angle of the point (x, y) from the x axis, radians in -π…π; 0 at the origin. Absolute error
/// below 1e-6.
///
/// Reduced to the first octant and then by atan(1/2), where a short Taylor series suffices.
pub fn atan2(y: f32, x: f32) -> f32 {
    use core::f32::consts::{FRAC_PI_2, PI};
    let (ax, ay) = (x.abs(), y.abs());
    let (small, large) = if ax < ay { (ax, ay) } else { (ay, ax) };
    if large.is_nan() || large <= 0.0 {
        return 0.0;
    }
    let octant = atan_unit(small / large);
    let quadrant = if ax < ay { FRAC_PI_2 - octant } else { octant };
    let half = if x < 0.0 { PI - quadrant } else { quadrant };
    if y < 0.0 { -half } else { half }
}

/// Returns the arctangent of `t` in 0…1.
fn atan_unit(t: f32) -> f32 {
    const ATAN_HALF: f32 = 0.463_647_6;
    // atan t = atan ½ + atan u with |u| ≤ 1/2 … 1/3 of the argument's distance from ½.
    let (base, u) = if t > 0.2 {
        (ATAN_HALF, (t - 0.5) / (1.0 + 0.5 * t))
    } else {
        (0.0, t)
    };
    let z = u * u;
    let series = 1.0 / 9.0 + z * (-1.0 / 11.0 + z / 13.0);
    base + u * (1.0 + z * (-1.0 / 3.0 + z * (0.2 + z * (-1.0 / 7.0 + z * series))))
}

/// Returns 2 to the power `x`, relative error below 1e-6; 0 below -126, the largest finite value above 127.
pub fn exp2(x: f32) -> f32 {
    if x >= 127.0 {
        return f32::MAX;
    }
    // False for NaN, too.
    let above = x > -126.0;
    if !above {
        return 0.0;
    }
    let whole = (x + if x < 0.0 { -0.5 } else { 0.5 }) as i32;
    let t = (x - whole as f32) * core::f32::consts::LN_2;
    let p = 1.0
        + t * (1.0
            + t * (0.5 + t * (1.0 / 6.0 + t * (1.0 / 24.0 + t * (1.0 / 120.0 + t / 720.0)))));
    p * f32::from_bits(((whole + 127) as u32) << 23)
}

/// Returns e to the power `x`, with the error bounds of [`exp2`].
#[inline]
pub fn exp(x: f32) -> f32 {
    exp2(x * core::f32::consts::LOG2_E)
}

/// Returns the natural logarithm, with the error bounds of [`log2`].
#[inline]
pub const fn ln(x: f32) -> f32 {
    core::f32::consts::LN_2 * log2(x)
}

/// Returns the natural logarithm of the gamma function of a positive number, absolute error below 2e-5 up to
/// 30: Stirling's series, shifted by the recurrence.
pub fn ln_gamma(x: f32) -> f32 {
    /// Minimum argument of Stirling's series: the third term, which is left out, is below 1e-6.
    const FAR: f32 = 6.0;
    /// ln √(2π).
    const LN_ROOT_TAU: f32 = 0.918_938_5;
    let (mut x, mut product) = (x, 1.0);
    while x < FAR {
        product *= x;
        x += 1.0;
    }
    let per = 1.0 / x;
    (x - 0.5) * ln(x) - x + LN_ROOT_TAU + per * (1.0 / 12.0 - per * per / 360.0) - ln(product)
}

/// Decibels of a doubled power: 10 lg 2.
pub const DB_PER_OCTAVE: f32 = 3.010_3;

/// Returns the power ratio of `db` decibels, with the error bounds of [`exp2`].
#[inline]
pub fn power_ratio(db: f32) -> f32 {
    exp2(db / DB_PER_OCTAVE)
}

/// Decibels of a doubled amplitude: 20 lg 2.
const DB_PER_DOUBLING: f32 = 6.020_6;

/// Returns the amplitude ratio of `db` decibels, with the error bounds of [`exp2`].
#[inline]
pub fn amplitude(db: f32) -> f32 {
    exp2(db * (1.0 / DB_PER_DOUBLING))
}

/// Returns the binary logarithm of a positive, normal number, absolute error below 2e-6 near 1 and relative
/// error below 1e-6 elsewhere; -127 for anything else.
#[inline(never)]
pub const fn log2(x: f32) -> f32 {
    if x.is_nan() || x < f32::MIN_POSITIVE || x > f32::MAX {
        return -127.0;
    }
    let bits = x.to_bits();
    let mut exponent = (bits >> 23) as i32 - 127;
    let mut m = f32::from_bits((bits & 0x007f_ffff) | 0x3f80_0000);
    if m > core::f32::consts::SQRT_2 {
        m *= 0.5;
        exponent += 1;
    }
    // ln m = 2 artanh((m - 1) / (m + 1)), |argument| ≤ 0.172.
    let u = (m - 1.0) / (m + 1.0);
    let z = u * u;
    let ln = 2.0 * u * (1.0 + z * (1.0 / 3.0 + z * (0.2 + z * (1.0 / 7.0 + z / 9.0))));
    exponent as f32 + ln * core::f32::consts::LOG2_E
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep(from: f64, to: f64, n: usize) -> impl Iterator<Item = f64> {
        (0..=n).map(move |k| from + (to - from) * k as f64 / n as f64)
    }

    #[test]
    fn gamma_function_within_bound() {
        // Γ(k) = (k - 1)!, and Γ(1/2) = √π.
        let mut ln_factorial = 0.0_f64;
        for k in 1..=30_u8 {
            let off = f64::from(ln_gamma(f32::from(k))) - ln_factorial;
            assert!(off.abs() < 2e-5, "{k}: {off}");
            ln_factorial += f64::from(k).ln();
        }
        let half = 0.5 * core::f64::consts::PI.ln();
        assert!((f64::from(ln_gamma(0.5)) - half).abs() < 2e-5);
    }

    #[test]
    fn sine_and_cosine_within_bound() {
        for a in sweep(-100.0, 100.0, 400_000).chain(sweep(-3.2, 3.2, 100_000)) {
            let a = a as f32;
            let (s, c) = sin_cos(a);
            assert!((f64::from(s) - f64::from(a).sin()).abs() < 3e-7, "sin {a}");
            assert!((f64::from(c) - f64::from(a).cos()).abs() < 3e-7, "cos {a}");
        }
    }

    #[test]
    fn arctangent_within_bound() {
        for a in sweep(-3.15, 3.13, 100_000) {
            let (y, x) = (a.sin() as f32, a.cos() as f32);
            let exact = f64::from(y).atan2(f64::from(x));
            assert!((f64::from(atan2(y, x)) - exact).abs() < 1e-6, "{a}");
        }
        assert_eq!(atan2(0.0, 0.0), 0.0);
        assert_eq!(atan2(f32::NAN, f32::NAN), 0.0);
    }

    #[test]
    fn exponential_within_bound() {
        for x in sweep(-125.0, 126.0, 100_000) {
            let x = x as f32;
            let exact = f64::from(x).exp2();
            assert!((f64::from(exp2(x)) / exact - 1.0).abs() < 1e-6, "{x}");
        }
        assert_eq!(exp2(f32::NAN), 0.0);
        assert_eq!(exp2(1e9), f32::MAX);
    }

    #[test]
    fn logarithm_within_bound() {
        for x in sweep(-120.0, 120.0, 100_000) {
            let v = x.exp2() as f32;
            let exact = f64::from(v).log2();
            let bound = 2e-6_f64.max(1e-6 * exact.abs());
            assert!((f64::from(log2(v)) - exact).abs() < bound, "{x}");
        }
        assert_eq!(log2(0.0), -127.0);
        assert_eq!(log2(f32::NAN), -127.0);
    }

    #[test]
    fn whole_numbers_are_those_of_the_standard_library() {
        let halves = (-4000..4000).map(|k| k as f32 * 0.5);
        let odd = [0.499_999_94, 4_194_303.5, -4_194_303.5, 1e-20];
        for x in halves
            .chain(sweep(-300.0, 300.0, 100_000).map(|x| x as f32))
            .chain(odd)
        {
            assert_eq!(ceil(x), x.ceil(), "ceil {x}");
            assert_eq!(floor(x), x.floor(), "floor {x}");
            assert_eq!(round(x), x.round(), "round {x}");
        }
    }

    #[test]
    fn square_root_of_nonsense_is_zero() {
        assert_eq!(sqrt(-1.0), 0.0);
        assert_eq!(sqrt(f32::NAN), 0.0);
        assert_eq!(sqrt(2.0), 2f32.sqrt());
    }
}
