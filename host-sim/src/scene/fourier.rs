//! Fast Fourier transforms of two signals at once: radix 4, self-sorting (Stockham), lengths of
//! powers of two.
//!
//! Only plain arithmetic is used, for the same bits on every host. Two signals fit the vector width
//! that is available everywhere.

use core::f64::consts::TAU;

use num_complex::Complex64;

use super::maths::cis;

/// One complex number of each of the two signals.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pair {
    /// Real parts.
    pub re: [f64; 2],
    /// Imaginary parts.
    pub im: [f64; 2],
}

impl Pair {
    fn plus(self, o: Self) -> Self {
        Self {
            re: [self.re[0] + o.re[0], self.re[1] + o.re[1]],
            im: [self.im[0] + o.im[0], self.im[1] + o.im[1]],
        }
    }

    fn minus(self, o: Self) -> Self {
        Self {
            re: [self.re[0] - o.re[0], self.re[1] - o.re[1]],
            im: [self.im[0] - o.im[0], self.im[1] - o.im[1]],
        }
    }

    /// Returns the pair times j, the imaginary unit.
    fn turned(self) -> Self {
        Self {
            re: [-self.im[0], -self.im[1]],
            im: self.re,
        }
    }

    fn times(self, w: Complex64) -> Self {
        Self {
            re: [
                self.re[0] * w.re - self.im[0] * w.im,
                self.re[1] * w.re - self.im[1] * w.im,
            ],
            im: [
                self.re[0] * w.im + self.im[0] * w.re,
                self.re[1] * w.im + self.im[1] * w.re,
            ],
        }
    }

    /// Adds `o` times the real number `k` to both signals.
    pub fn add_scaled(&mut self, o: &Self, k: f64) {
        for lane in 0..2 {
            self.re[lane] += o.re[lane] * k;
            self.im[lane] += o.im[lane] * k;
        }
    }

    /// Returns the complex number of signal `lane`, 0 or 1.
    pub fn lane(&self, lane: usize) -> Complex64 {
        Complex64::new(self.re[lane], self.im[lane])
    }
}

/// Inverse Fourier transform of one length, for two signals at once.
#[derive(Clone)]
pub struct Fourier {
    length: usize,
    /// Twiddle factors by radix-4 stage: e^{jφ}, e^{2jφ}, e^{3jφ} with φ = 2πp / n for p = 0, 1, …, where n is the
    /// length of the transforms that remain, in the first stage all points.
    stages: Vec<Vec<[Complex64; 3]>>,
}

impl Fourier {
    /// Creates a transform of 2^`log2` points.
    pub fn new(log2: u32) -> Self {
        let length = 1 << log2;
        let stages = (0..log2 / 2).map(|stage| {
            let n = length >> (2 * stage);
            let turn = |p: usize| cis(TAU * p as f64 / n as f64);
            (0..n / 4)
                .map(|p| [turn(p), turn(2 * p), turn(3 * p)])
                .collect()
        });
        Self {
            length,
            stages: stages.collect(),
        }
    }

    /// Returns the number of points.
    pub fn length(&self) -> usize {
        self.length
    }

    /// Returns Σ x_p e^{2πjpk/length} of both signals for every k, unscaled.
    pub fn inverse(&self, mut x: Vec<Pair>) -> Vec<Pair> {
        let mut y = vec![Pair::default(); self.length];
        let mut stride = 1;
        for turns in &self.stages {
            fourths(turns, stride, &x, &mut y);
            stride *= 4;
            core::mem::swap(&mut x, &mut y);
        }
        if stride < self.length {
            let (a, b) = x.split_at(stride);
            let (sums, differences) = y.split_at_mut(stride);
            for (k, (a, b)) in a.iter().zip(b).enumerate() {
                sums[k] = a.plus(*b);
                differences[k] = a.minus(*b);
            }
            core::mem::swap(&mut x, &mut y);
        }
        x
    }
}

/// Computes one radix-4 stage from `x` to `y`: for every element of `turns`, its twiddle factors, `stride` transforms
/// of four points.
fn fourths(turns: &[[Complex64; 3]], stride: usize, x: &[Pair], y: &mut [Pair]) {
    let quarter = turns.len() * stride;
    let (first, second) = x.split_at(2 * quarter);
    let ((a, b), (c, d)) = (first.split_at(quarter), second.split_at(quarter));
    let inputs = (a.chunks_exact(stride).zip(b.chunks_exact(stride)))
        .zip(c.chunks_exact(stride).zip(d.chunks_exact(stride)));
    let outputs = y.chunks_exact_mut(4 * stride);
    for ((w, ((a, b), (c, d))), out) in turns.iter().zip(inputs).zip(outputs) {
        let (first, second) = out.split_at_mut(2 * stride);
        let (out0, out1) = first.split_at_mut(stride);
        let (out2, out3) = second.split_at_mut(stride);
        let points = a.iter().zip(b).zip(c.iter().zip(d));
        let outputs = out0.iter_mut().zip(out1).zip(out2.iter_mut().zip(out3));
        for (((a, b), (c, d)), ((out0, out1), (out2, out3))) in points.zip(outputs) {
            let (even, even_off) = (a.plus(*c), a.minus(*c));
            let (odd, odd_off) = (b.plus(*d), b.minus(*d).turned());
            *out0 = even.plus(odd);
            *out1 = even_off.plus(odd_off).times(w[0]);
            *out2 = even.minus(odd).times(w[1]);
            *out3 = even_off.minus(odd_off).times(w[2]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::maths::Random;

    #[test]
    fn a_fast_transform_is_the_sum_that_it_stands_for() {
        let mut random = Random::new(1, 1);
        for log2 in 0..10 {
            let fourier = Fourier::new(log2);
            let length = fourier.length();
            let x: Vec<Pair> = (0..length)
                .map(|_| Pair {
                    re: [random.normal(), random.normal()],
                    im: [random.normal(), random.normal()],
                })
                .collect();
            let y = fourier.inverse(x.clone());
            for lane in 0..2 {
                for (k, y) in y.iter().enumerate() {
                    let turn = |p: usize| cis(TAU * ((p * k) % length) as f64 / length as f64);
                    let terms = x.iter().enumerate();
                    let sum: Complex64 = terms.map(|(p, x)| x.lane(lane) * turn(p)).sum();
                    assert!((y.lane(lane) - sum).l1_norm() < 1e-12, "{length} {k}");
                }
            }
        }
    }
}
