//! Sum of the chirps of one row (dwell).
//!
//! In: the chirps of a row, one after the other. Out: one chirp, their mean at one phase. Echoes keep the level that
//! they have in one chirp; noise falls by the number of chirps N, 10 lg N dB.
//!
//! Coherent integration: the oscillator's phase, which all echoes of a chirp share, is measured at the mirror's own
//! echo, by one bin of a Fourier transform with a Hann window. Each chirp is turned to the phase of the row's first
//! one and added in floating point, so that no sum overflows; the mean is rounded to 16 bits once. Its phase has the
//! error of the first measurement, which the scanner takes out with the row's phase. The scanner does not add: the
//! module does, in its own firmware or in the simulator.

use core::f32::consts::TAU;

use crate::Iq;
use crate::math::{sin_cos, sqrt};

/// A complex number as real and imaginary part.
type ComplexPair = [f32; 2];

/// Sum of the chirps of one row.
///
/// ```
/// use stairscan::Iq;
/// use stairscan::signal::radar::dwell::ChirpSum;
///
/// // Two chirps of a mirror's echo with 3 periods, the second one a quarter of a period ahead.
/// let echo = |turns: f64| {
///     let wave = move |n: u32| core::f64::consts::TAU * (3.0 * f64::from(n) / 64.0 + turns);
///     (0..64).map(move |n| Iq::new((8e3 * wave(n).cos()) as i16, (8e3 * wave(n).sin()) as i16))
/// };
/// let (mut sums, mut out) = ([[0.0; 2]; 64], [Iq::default(); 64]);
/// let mut sum = ChirpSum::new(&mut sums, Some(3.0));
/// sum.add(&echo(0.0).collect::<Vec<_>>());
/// sum.add(&echo(0.25).collect::<Vec<_>>());
/// sum.finish(&mut out);
/// assert!(out.iter().zip(echo(0.0)).all(|(sum, first)| sum.i.abs_diff(first.i) < 3));
/// ```
#[derive(Debug)]
pub struct ChirpSum<'a> {
    /// Sum of each sample over the chirps; infinite where the converter was at full scale.
    sums: &'a mut [ComplexPair],
    /// Number of periods of the mirror's own echo in a chirp; `None`: the phase is not changed.
    mirror_periods: Option<f32>,
    /// Complex amplitude of the mirror's own echo in the first chirp.
    first: ComplexPair,
    /// Number of chirps in the sums.
    chirps: u16,
}

impl<'a> ChirpSum<'a> {
    /// Begins the sum of a row. `sums` is its memory, one place for each sample of a chirp. `mirror_periods` is the range
    /// of the mirror's own echo in range resolutions c / 2B, which is its number of periods in a chirp; `None` for real
    /// samples, whose phase cannot be turned: they are added as they are.
    pub fn new(sums: &'a mut [ComplexPair], mirror_periods: Option<f32>) -> Self {
        sums.fill([0.0; 2]);
        Self {
            sums,
            mirror_periods,
            first: [0.0; 2],
            chirps: 0,
        }
    }

    /// Adds one chirp.
    pub fn add(&mut self, chirp: &[Iq]) {
        let turn = match self.mirror_periods {
            None => [1.0, 0.0],
            Some(periods) => {
                let echo = amplitude(chirp, periods);
                if self.chirps == 0 {
                    self.first = echo;
                    [1.0, 0.0]
                } else {
                    phase_between(echo, self.first)
                }
            }
        };
        self.chirps = self.chirps.saturating_add(1);
        for (sum, sample) in self.sums.iter_mut().zip(chirp) {
            let [i, q] = product([f32::from(sample.i), f32::from(sample.q)], turn);
            let [re, im] = sum;
            *re = added(*re, i, sample.i);
            *im = added(*im, q, sample.q);
        }
    }

    /// Writes the mean of the chirps to `out`, rounded to the nearest; zeros without a chirp. A part of a sample that
    /// was at full scale in any chirp is at full scale, so that saturation stays visible. The mean of one chirp is that
    /// chirp.
    pub fn finish(self, out: &mut [Iq]) {
        let scale = 1.0 / f32::from(self.chirps.max(1));
        for (out, &[i, q]) in out.iter_mut().zip(self.sums.iter()) {
            *out = Iq::new(rounded(i * scale), rounded(q * scale));
        }
    }
}

/// Returns `sum` with `part` added, the turned value of `sample`; infinite once a sample was at full scale.
fn added(sum: f32, part: f32, sample: i16) -> f32 {
    match sample {
        _ if sum.is_infinite() => sum,
        i16::MAX => f32::INFINITY,
        i16::MIN => f32::NEG_INFINITY,
        _ => sum + part,
    }
}

/// Rounds to the nearest 16-bit value, halves away from zero, limited to full scale.
fn rounded(value: f32) -> i16 {
    // `as` truncates and saturates.
    (value + if value < 0.0 { -0.5 } else { 0.5 }) as i16
}

/// Returns the complex amplitude of an echo with `periods` periods in `chirp`, times half the number of samples.
fn amplitude(chirp: &[Iq], periods: f32) -> ComplexPair {
    let step = 1.0 / chirp.len().max(1) as f32;
    let mut sum = [0.0; 2];
    for (n, sample) in chirp.iter().enumerate() {
        let place = (n as f32 + 0.5) * step;
        let weight = 0.5 - 0.5 * sin_cos(TAU * place).1;
        let turns = periods * place;
        let (sin, cos) = sin_cos(TAU * (turns - (turns as i32) as f32));
        let [i, q] = product([f32::from(sample.i), f32::from(sample.q)], [cos, -sin]);
        sum = [sum[0] + weight * i, sum[1] + weight * q];
    }
    sum
}

/// Returns the phase of `to` relative to `from` as a number of absolute value 1; 1 if either is 0.
fn phase_between([i, q]: ComplexPair, to: ComplexPair) -> ComplexPair {
    let [re, im] = product(to, [i, -q]);
    let size = sqrt(re * re + im * im);
    if size > 0.0 {
        [re / size, im / size]
    } else {
        [1.0, 0.0]
    }
}

fn product([a, b]: ComplexPair, [c, d]: ComplexPair) -> ComplexPair {
    [a * c - b * d, a * d + b * c]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    const SAMPLES: usize = 200;
    /// Periods of the mirror's own echo: 0.22 m in resolutions of 15 mm.
    const MIRROR: f32 = 14.68;
    /// Periods of a target.
    const TARGET: f32 = 80.3;

    /// Normally distributed numbers, as the sum of twelve uniform ones.
    struct Noise(Xoshiro128PlusPlus);

    impl Noise {
        fn new(seed: u64) -> Self {
            Self(Xoshiro128PlusPlus::seed_from_u64(seed))
        }

        fn next(&mut self) -> f32 {
            let uniform = |random: u32| random as f32 / u32::MAX as f32;
            (0..12).map(|_| uniform(self.0.next_u32())).sum::<f32>() - 6.0
        }
    }

    /// Returns a chirp of the mirror's echo and a target of a tenth of it, both turned by `turns`, with noise of the
    /// standard deviation `sigma` in I and in Q.
    fn chirp(level: f32, turns: f32, sigma: f32, noise: &mut Noise) -> Vec<Iq> {
        (0..SAMPLES)
            .map(|n| {
                let wave = |periods: f32| {
                    let phase = periods * n as f32 / SAMPLES as f32 + turns;
                    sin_cos(TAU * phase.fract())
                };
                let ((sm, cm), (st, ct)) = (wave(MIRROR), wave(TARGET));
                let part = |m: f32, t: f32, noise: &mut Noise| {
                    rounded(level * m + 0.1 * level * t + sigma * noise.next())
                };
                Iq::new(part(cm, ct, noise), part(sm, st, noise))
            })
            .collect()
    }

    fn mean(chirps: &[Vec<Iq>], periods: Option<f32>) -> Vec<Iq> {
        let mut sums = vec![[f32::NAN; 2]; chirps[0].len()];
        let mut sum = ChirpSum::new(&mut sums, periods);
        chirps.iter().for_each(|chirp| sum.add(chirp));
        let mut out = vec![Iq::default(); chirps[0].len()];
        sum.finish(&mut out);
        out
    }

    /// Returns the mean square of the differences of two chirps, units of a sample.
    fn difference(a: &[Iq], b: &[Iq]) -> f32 {
        let square = |a: i16, b: i16| (f32::from(a) - f32::from(b)).powi(2);
        let sum: f32 = (a.iter().zip(b))
            .map(|(a, b)| square(a.i, b.i) + square(a.q, b.q))
            .sum();
        sum / a.len() as f32
    }

    /// Returns the ratio of the noise in one chirp to that in the mean of `n` chirps, over 20 rows. `turns` is the
    /// phase of chirp k of a row.
    fn gain(n: usize, turns: impl Fn(usize) -> f32) -> f32 {
        const SIGMA: f32 = 40.0;
        let mut noise = Noise::new(n as u64);
        let mut powers = [0.0; 2];
        for _ in 0..20 {
            let clean = chirp(1_600.0, turns(0), 0.0, &mut noise);
            let row: Vec<_> = (0..n)
                .map(|k| chirp(1_600.0, turns(k), SIGMA, &mut noise))
                .collect();
            powers[0] += difference(&row[0], &clean);
            powers[1] += difference(&mean(&row, Some(MIRROR)), &clean);
        }
        powers[0] / powers[1]
    }

    #[test]
    fn noise_falls_by_the_number_of_chirps_whatever_their_phases_are() {
        for n in [2, 8, 16, 32] {
            for step in [0.0, 0.37] {
                let gain = gain(n, |k| step * k as f32);
                println!("{n} chirps, {step} turns apart: noise / {gain:.2}");
                assert!((gain / n as f32 - 1.0).abs() < 0.1, "{n} {step}: {gain}");
            }
        }
    }

    #[test]
    fn without_one_phase_the_echoes_would_cancel() {
        let mut noise = Noise::new(1);
        let row = [0.0, 0.5].map(|turns| chirp(1_600.0, turns, 0.0, &mut noise));
        let silent = vec![Iq::default(); SAMPLES];
        assert!(difference(&mean(&row, None), &silent) < 1.0);
        assert!(difference(&mean(&row, Some(MIRROR)), &row[0]) < 1.0);
    }

    #[test]
    fn full_scale_does_not_overflow_and_stays_visible() {
        let ends = [i16::MIN, i16::MAX, i16::MIN + 1, i16::MAX - 1];
        let full: Vec<Iq> = (0..SAMPLES)
            .map(|n| Iq::new(ends[n % 4], ends[n / 4 % 4]))
            .collect();
        assert_eq!(mean(&vec![full.clone(); 32], Some(MIRROR)), full);
        let loud: Vec<_> = (0..32)
            .map(|k| chirp(40_000.0, 0.11 * k as f32, 0.0, &mut Noise::new(1)))
            .collect();
        let out = mean(&loud, Some(MIRROR));
        let clipped = |x: &Iq| x.i == i16::MAX || x.i == i16::MIN;
        for (n, sample) in loud[0].iter().enumerate() {
            assert!(!clipped(sample) || clipped(&out[n]), "{n}");
        }
    }

    #[test]
    fn a_row_without_chirps_is_silent() {
        let (mut sums, mut out) = ([[1.0; 2]; 4], [Iq::new(7, 7); 4]);
        ChirpSum::new(&mut sums, Some(MIRROR)).finish(&mut out);
        assert_eq!(out, [Iq::default(); 4]);
        let silent = vec![vec![Iq::default(); 4]; 3];
        assert_eq!(mean(&silent, Some(MIRROR)), silent[0]);
    }

    proptest! {
        #[test]
        fn the_mean_of_one_chirp_is_that_chirp(
            parts in proptest::collection::vec(any::<(i16, i16)>(), 1..=256),
            periods in proptest::option::of(0.0_f32..256.0),
        ) {
            let chirp: Vec<Iq> = parts.iter().map(|&(i, q)| Iq::new(i, q)).collect();
            prop_assert_eq!(mean(std::slice::from_ref(&chirp), periods), chirp);
        }

        #[test]
        fn any_chirps_have_a_mean(
            parts in proptest::collection::vec(any::<(i16, i16)>(), 64), rows in 1_usize..40,
            periods: f32,
        ) {
            let chirp: Vec<Iq> = parts.iter().map(|&(i, q)| Iq::new(i, q)).collect();
            mean(&vec![chirp; rows], Some(periods));
        }
    }
}
