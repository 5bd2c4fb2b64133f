//! Vectors, phases and random numbers that come out the same on every host.
//!
//! The standard library's elementary functions are the platform's and differ in the last bit, which
//! would break "same seed, same bytes"; `libm`'s are plain arithmetic.

use num_complex::Complex64;
use rand_core::Rng;
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Speed of light, m/s.
pub const LIGHT: f64 = 299_792_458.0;

/// A point or direction in the plane that the mirror sweeps: forward and up, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vec2 {
    /// Forward.
    pub x: f64,
    /// Up.
    pub y: f64,
}

impl Vec2 {
    /// A vector from its parts.
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// Scalar product.
    pub fn dot(self, o: Self) -> f64 {
        self.x * o.x + self.y * o.y
    }

    /// Cross product: positive when `o` lies to the left of `self`.
    pub fn cross(self, o: Self) -> f64 {
        self.x * o.y - self.y * o.x
    }

    /// Length.
    pub fn len(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// The same direction with length 1.
    pub fn unit(self) -> Self {
        self * (1.0 / self.len())
    }

    /// Turned left by 90°.
    pub const fn left(self) -> Self {
        Self::new(-self.y, self.x)
    }

    /// `self` plus `t` times the way to `o`.
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

/// e^{jφ}.
pub fn cis(phase: f64) -> Complex64 {
    let (s, c) = libm::sincos(phase);
    Complex64::new(c, s)
}

/// sin x / x.
pub fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 {
        1.0 - x * x / 6.0
    } else {
        libm::sin(x) / x
    }
}

/// 10^(db/10).
pub fn power(db: f64) -> f64 {
    libm::exp10(db / 10.0)
}

/// 10^(db/20).
pub fn amplitude(db: f64) -> f64 {
    libm::exp10(db / 20.0)
}

/// 10 log10 of a power.
pub fn decibel(power: f64) -> f64 {
    10.0 * libm::log10(power)
}

/// Random numbers of one stream.
pub struct Random {
    rng: Xoshiro256PlusPlus,
    spare: Option<f64>,
}

impl Random {
    /// Stream `stream` of `seed`. Streams of one seed, and equal streams of different seeds, have
    /// nothing to do with each other, whatever order they are used in.
    pub fn new(seed: u64, stream: u64) -> Self {
        // SplitMix64 inside `seed_from_u64` spreads what an odd multiplier has kept apart.
        let mixed = seed ^ stream.wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(17);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(mixed);
        let again = rng.next_u64() ^ stream;
        Self {
            rng: Xoshiro256PlusPlus::seed_from_u64(again),
            spare: None,
        }
    }

    /// Uniform in 0 ≤ x < 1.
    pub fn unit(&mut self) -> f64 {
        (self.rng.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform from `low` to `high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// An index below `n` (which is above 0).
    pub fn index(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n - 1)
    }

    /// True with probability `p`.
    pub fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }

    /// Gaussian with mean 0 and variance 1 (Marsaglia's polar method).
    pub fn normal(&mut self) -> f64 {
        if let Some(x) = self.spare.take() {
            return x;
        }
        loop {
            let u = 2.0 * self.unit() - 1.0;
            let v = 2.0 * self.unit() - 1.0;
            let s = u * u + v * v;
            if s < 1.0 && s > 0.0 {
                let k = (-2.0 * libm::log(s) / s).sqrt();
                self.spare = Some(v * k);
                return u * k;
            }
        }
    }

    /// Circular complex Gaussian with mean power `power`.
    pub fn complex(&mut self, power: f64) -> Complex64 {
        let k = (power / 2.0).sqrt();
        let re = self.normal() * k;
        Complex64::new(re, self.normal() * k)
    }
}
