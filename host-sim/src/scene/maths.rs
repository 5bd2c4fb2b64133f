//! Vectors, phases and random numbers with the same bits on every host.
//!
//! The standard library's elementary functions depend on the platform and differ in the last bit,
//! which would break "same seed, same bytes". Those of `libm` are plain arithmetic.

use core::f64::consts::FRAC_2_PI;

use num_complex::Complex64;
use rand_core::Rng;
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Speed of light, m/s.
pub const LIGHT: f64 = 299_792_458.0;

/// A point or direction in the plane that the mirror sweeps: forward and up, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vec2 {
    /// Forward component; of a point: metres.
    pub x: f64,
    /// Upward component; of a point: metres.
    pub y: f64,
}

impl Vec2 {
    /// Creates a vector from its components.
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// Returns the scalar product.
    pub fn dot(self, o: Self) -> f64 {
        self.x * o.x + self.y * o.y
    }

    /// Returns the cross product: positive when `o` lies to the left of `self`.
    pub fn cross(self, o: Self) -> f64 {
        self.x * o.y - self.y * o.x
    }

    /// Returns the length.
    pub fn len(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// Returns the vector scaled to length 1.
    pub fn unit(self) -> Self {
        self * (1.0 / self.len())
    }

    /// Returns the vector turned left by 90°.
    pub const fn left(self) -> Self {
        Self::new(-self.y, self.x)
    }

    /// Returns the point at the fraction `t` of the way from `self` to `o`.
    pub fn towards(self, o: Self, t: f64) -> Self {
        self + (o - self) * t
    }
}

impl core::ops::Add for Vec2 {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self::new(self.x + o.x, self.y + o.y)
    }
}

impl core::ops::Sub for Vec2 {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self::new(self.x - o.x, self.y - o.y)
    }
}

impl core::ops::Mul<f64> for Vec2 {
    type Output = Self;
    fn mul(self, k: f64) -> Self {
        Self::new(self.x * k, self.y * k)
    }
}

/// Returns e^{jφ}.
pub fn cis(phase: f64) -> Complex64 {
    let (s, c) = libm::sincos(phase);
    Complex64::new(c, s)
}

/// 1.5 · 2^52: adding it to a number rounds the number to an integer, which is then in the sum's lowest bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// Maximum magnitude of a phase, radians, that [`cis_all`] reduces with two parts of π/2; larger ones are passed to
/// `libm`.
const LARGE_PHASE: f64 = 1e5;

/// Returns the cosines and sines of `phases`, to 3e-16. It has no branches, so that the compiler
/// vectorises it: a scan needs a million. Reduction and polynomials are those of fdlibm.
pub fn cis_all<const N: usize>(phases: &[f64; N]) -> ([f64; N], [f64; N]) {
    if phases.iter().any(|x| x.abs() > LARGE_PHASE) {
        let pairs = phases.map(libm::sincos);
        return (pairs.map(|(_, cos)| cos), pairs.map(|(sin, _)| sin));
    }
    let (mut cosines, mut sines) = ([0.0; N], [0.0; N]);
    for ((x, c), s) in phases.iter().zip(&mut cosines).zip(&mut sines) {
        let shifted = x * FRAC_2_PI + ROUND;
        let n = shifted - ROUND;
        let r = (x - n * 1.570_796_326_734_125_6) - n * 6.077_100_506_506_192e-11;
        let z = r * r;
        let odd = 8.333_333_333_322_49e-3
            + z * (-1.984_126_982_985_795e-4
                + z * (2.755_731_370_707_006_8e-6
                    + z * (-2.505_076_025_340_686_3e-8 + z * 1.589_690_995_211_55e-10)));
        let sin = r + z * r * (-1.666_666_666_666_663_2e-1 + z * odd);
        let even = 4.166_666_666_666_66e-2
            + z * (-1.388_888_888_887_411e-3
                + z * (2.480_158_728_947_673e-5
                    + z * (-2.755_731_435_139_066_3e-7
                        + z * (2.087_572_321_298_175e-9 - z * 1.135_964_755_778_819_5e-11))));
        let cos = 1.0 - (0.5 * z - z * z * even);
        // Odd quarters of a turn swap the two; the second bit is the sign.
        let quarter = shifted.to_bits();
        let swap = 0_u64.wrapping_sub(quarter & 1);
        let (a, b) = (sin.to_bits(), cos.to_bits());
        let differ = (a ^ b) & swap;
        *s = f64::from_bits(a ^ differ ^ ((quarter & 2) << 62));
        *c = f64::from_bits(b ^ differ ^ ((quarter.wrapping_add(1) & 2) << 62));
    }
    (cosines, sines)
}

/// Returns the natural logarithm of a normal number between 0 and 1, to a relative 3e-16 (fdlibm's,
/// without branches).
#[inline]
fn log_of_share(x: f64) -> f64 {
    // x = 2^k (1 + f) with √½ < 1 + f < √2.
    const ROOT_HALF: u64 = 0x3FE6_A09E << 32;
    const ONE: u64 = 0x3FF0_0000 << 32;
    let bits = x.to_bits() + (ONE - ROOT_HALF);
    let fraction = (bits & 0x000F_FFFF_FFFF_FFFF) + ROOT_HALF;
    // The exponent, above 2^52, as a number.
    let k = f64::from_bits((bits >> 52) | (0x4330 << 48)) - (4_503_599_627_370_496.0 + 1023.0);
    let f = f64::from_bits(fraction) - 1.0;
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let even = w
        * (3.999_999_999_940_942e-1
            + w * (2.222_219_843_214_978_4e-1 + w * 1.531_383_769_920_937_3e-1));
    let odd = z
        * (6.666_666_666_666_735e-1
            + w * (2.857_142_874_366_239e-1
                + w * (1.818_357_216_161_805e-1 + w * 1.479_819_860_511_658_6e-1)));
    let half = 0.5 * f * f;
    let low = k * 1.908_214_929_270_587_7e-10;
    s * (half + (even + odd)) + low - half + f + k * 6.931_471_803_691_238e-1
}

/// Returns sin x / x.
pub fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 {
        1.0 - x * x / 6.0
    } else {
        libm::sin(x) / x
    }
}

/// Returns 10^(db/10).
pub fn power(db: f64) -> f64 {
    libm::exp10(db / 10.0)
}

/// Returns 10^(db/20).
pub fn amplitude(db: f64) -> f64 {
    libm::exp10(db / 20.0)
}

/// Returns 10 log10 of a power.
pub fn decibel(power: f64) -> f64 {
    10.0 * libm::log10(power)
}

/// Number of pairs of Gaussian random numbers that are computed at once.
const PAIRS: usize = 16;

/// Random number generator of one stream.
#[derive(Clone)]
pub struct Random {
    rng: Xoshiro256PlusPlus,
    spare: Option<f64>,
}

impl Random {
    /// Creates stream `stream` of `seed`. Streams of one seed, and equal streams of different
    /// seeds, are independent, in any order of use.
    pub fn new(seed: u64, stream: u64) -> Self {
        // The odd multiplier keeps streams distinct; SplitMix64 inside `seed_from_u64` mixes the bits.
        let mixed = seed ^ stream.wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(17);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(mixed);
        let again = rng.next_u64() ^ stream;
        Self {
            rng: Xoshiro256PlusPlus::seed_from_u64(again),
            spare: None,
        }
    }

    /// Returns a random number, uniform in 0 ≤ x < 1.
    pub fn unit(&mut self) -> f64 {
        (self.rng.next_u64() >> 11).cast_signed() as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Returns a random number, uniform from `low` to `high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Returns a random index, uniform from 0 to `n - 1`; `n` must be above 0.
    pub fn index(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n - 1)
    }

    /// Returns true with probability `p`.
    pub fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }

    /// Returns a Gaussian random number with mean 0 and variance 1 (Marsaglia's polar method).
    pub fn normal(&mut self) -> f64 {
        if let Some(x) = self.spare.take() {
            return x;
        }
        let [(first, second)] = self.pairs();
        self.spare = Some(second);
        first
    }

    /// Fills `to` with the values that as many calls of [`Random::normal`] would return, several at
    /// once.
    pub fn normals(&mut self, to: &mut [f64]) {
        let kept = usize::from(self.spare.is_some()).min(to.len());
        let (first, others) = to.split_at_mut(kept);
        first.fill_with(|| self.normal());
        let (blocks, rest) = others.as_chunks_mut::<{ 2 * PAIRS }>();
        for block in blocks {
            let (twos, _) = block.as_chunks_mut::<2>();
            for (two, (a, b)) in twos.iter_mut().zip(self.pairs::<PAIRS>()) {
                *two = [a, b];
            }
        }
        rest.fill_with(|| self.normal());
    }

    /// Returns the next `N` pairs of independent Gaussian numbers with mean 0 and variance 1.
    fn pairs<const N: usize>(&mut self) -> [(f64, f64); N] {
        let (mut us, mut vs, mut squares) = ([0.0; N], [0.0; N], [0.5; N]);
        let mut found = 0;
        while found < N {
            let u = 2.0 * self.unit() - 1.0;
            let v = 2.0 * self.unit() - 1.0;
            let s = u * u + v * v;
            (us[found], vs[found], squares[found]) = (u, v, s);
            // A point outside the circle is overwritten by the next one.
            found += usize::from((s < 1.0) & (s > 0.0));
        }
        for s in &mut squares {
            *s = (-2.0 * log_of_share(*s) / *s).sqrt();
        }
        core::array::from_fn(|k| (us[k] * squares[k], vs[k] * squares[k]))
    }

    /// Returns a circular complex Gaussian number with mean power `power`.
    pub fn complex(&mut self, power: f64) -> Complex64 {
        let k = (power / 2.0).sqrt();
        let re = self.normal() * k;
        Complex64::new(re, self.normal() * k)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_phases_are_as_exact_as_one() {
        let mut random = Random::new(1, 2);
        for scale in [1.0, 30.0, 5000.0, 1e5, 1e7] {
            for _ in 0..200 {
                let phases: [f64; 16] = core::array::from_fn(|_| random.between(-scale, scale));
                let (cosines, sines) = cis_all(&phases);
                for ((x, c), s) in phases.iter().zip(cosines).zip(sines) {
                    let (sin, cos) = libm::sincos(*x);
                    assert!((c - cos).abs() < 4e-16 && (s - sin).abs() < 4e-16, "{x}");
                }
            }
        }
        let (cosines, sines) = cis_all(&[0.0, -0.0]);
        assert_eq!((cosines, sines), ([1.0; 2], [0.0; 2]));
    }

    #[test]
    fn logarithms_are_those_of_libm() {
        let mut random = Random::new(2, 2);
        for k in 0..100_000 {
            let x = random.unit() * libm::exp2(-f64::from(k % 60)) + f64::MIN_POSITIVE;
            let exact = libm::log(x);
            assert!(
                (log_of_share(x) - exact).abs() <= 4e-16 * exact.abs(),
                "{x}"
            );
        }
    }

    #[test]
    fn many_normals_are_those_drawn_one_by_one() {
        for (count, before) in [(0, 1), (1, 1), (7, 0), (64, 0), (65, 1), (1001, 3)] {
            let (mut one, mut many) = (Random::new(5, 6), Random::new(5, 6));
            for _ in 0..before {
                assert_eq!(one.normal(), many.normal());
            }
            let mut drawn = vec![0.0; count];
            many.normals(&mut drawn);
            assert!(drawn.iter().all(|x| *x == one.normal()));
            assert_eq!(one.normal(), many.normal());
            assert_eq!(one.unit(), many.unit());
        }
    }
}
