//! From echoes to beat tones: sums thousands of ranges into one chirp without a loop over both.
//!
//! Each echo is spread over a few points of a grid of beat frequencies, the grid is transformed to
//! the samples, and the kernel's own transform is divided out (non-uniform Fourier transform;
//! Barnett, Magland, af Klinteberg, SIAM J. Sci. Comput. 41, 2019). Sample times need not be even,
//! so that the sweep's deviation from a straight line is exact rather than a correction.
//!
//! The transform from the grid to the samples works the same way in reverse: a fast transform to
//! even times, four per sample, and a second kernel from these to the samples' times. That step
//! adds an error below -200 dB, so that the error is that of the first kernel.

use core::f64::consts::TAU;

use num_complex::Complex64;

use super::fourier::{Fourier, Pair};
use super::maths::cis;

/// Number of grid points over which an echo is spread. Six leave an error below -90 dB.
const TAPS: usize = 6;

/// Kernel that spreads an echo over the grid of beat frequencies. The midpoint rule of 400 points for its transform is
/// exact to 1e-8; at its ends the kernel has fallen to e^-β.
const SPREAD: Kernel = Kernel {
    taps: TAPS as f64,
    beta: 2.30 * TAPS as f64,
    steps: 400,
};

/// Number of places between two grid points for which the table holds weights; they are 0.2 mm of range apart at the
/// most usual bandwidth.
const SPREADS: usize = 32;

/// Table of the weights with which a tone at a place between two grid points is spread: entry k for k / `SPREADS` of
/// the way from one to the next.
pub struct Spread {
    weights: [[f64; TAPS]; SPREADS],
}

impl Default for Spread {
    fn default() -> Self {
        let weights = core::array::from_fn(|k| {
            let at = k as f64 / SPREADS as f64;
            let first = libm::ceil(at) - 0.5 * TAPS as f64;
            core::array::from_fn(|tap| SPREAD.at((first + tap as f64 - at) / (0.5 * TAPS as f64)))
        });
        Self { weights }
    }
}

/// Number of evenly spaced times from which a sample is interpolated.
const TIMES: usize = 14;

/// Kernel that interpolates the samples from evenly spaced times.
const INTERPOLATE: Kernel = Kernel {
    taps: TIMES as f64,
    beta: 2.27 * TIMES as f64,
    steps: 128,
};

/// Maximum of half the band of beat frequencies as a fraction of the rate of the evenly spaced times. The interpolation
/// kernel's transform has then fallen to 1e-13 where the band repeats.
const HALF_BAND: f64 = 0.2615;

/// Maximum beat frequency on the grid, cycles per sample. The anti-alias filter suppresses all beyond, or the echo is
/// too far.
pub const HIGHEST: f64 = 2.0;

/// Place of a beat tone on the grid of beat frequencies.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Index of the first grid point over which the tone is spread.
    pub first: usize,
    /// Weights of point `first` and the next ones.
    pub weights: [f64; TAPS],
    /// Phase factor that moves the origin of time from the first sample to the middle of the chirp.
    pub centre: Complex64,
}

/// A sample's value, and its derivative by time, per sample.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moving {
    /// Value at the sample's own time.
    pub value: Complex64,
    /// Derivative of the value by time, per sample period.
    pub slope: Complex64,
}

impl Moving {
    /// Returns the value `by` sample periods later, to first order.
    pub fn moved(&self, by: f64) -> Complex64 {
        self.value + self.slope * by
    }
}

/// Grid of beat frequencies and its transform to the samples of a chirp.
///
/// Grid points with even and with odd indices are transformed separately, as two signals with half the period.
pub struct Tones {
    /// Number of grid points per unit of beat frequency, cycles per sample.
    density: f64,
    /// Weight of every grid point in the transform: the receiver's response at its frequency divided by the
    /// interpolation kernel's transform.
    shares: Vec<Complex64>,
    transform: Fourier,
    samples: Vec<Sample>,
    middle: f64,
}

/// Interpolation of one sample from evenly spaced times.
struct Sample {
    /// Index of the first of these times.
    first: usize,
    /// Weights of these times: entry k holds the weights of time k in the sample's value and in its slope.
    weights: [[f64; 2]; TIMES],
    /// Phase factor at the middle frequency of each of the two signals, divided by the transform of the spreading
    /// kernel.
    turns: [Complex64; 2],
}

/// Returns the angular frequencies of the middle grid points of the two signals (even and odd indices), radians per
/// sample.
fn middles(density: f64) -> [f64; 2] {
    [0.0, 1.0].map(|lane| TAU * (1.0 + lane / density))
}

impl Tones {
    /// Creates the transform for the sample times `times` (in samples, 0 for the first, nearly
    /// even). `response` is the receiver's response to a tone's frequency.
    pub fn new(times: &[f64], response: impl Fn(f64) -> Complex64) -> Self {
        let middle = 0.5 * (times.len() as f64 - 1.0);
        // Twice as dense as the chirp's length requires, with a reserve for uneven times.
        let density = 2.0 * (times.len() as f64 + 8.0);
        let points = (HIGHEST * density) as usize + 2 * TAPS;
        let needed = 0.5 * (density + TAPS as f64) / HALF_BAND;
        let log2 = (0..).find(|k| f64::from(1_u32 << k) >= needed);
        let transform = Fourier::new(log2.unwrap_or(0));
        let per_cycle = transform.length() as f64;
        let nodes = INTERPOLATE.nodes();
        let shares = (0..points).map(|m| {
            let frequency = (m as f64 - TAPS as f64) / density;
            let steps = (offset(m, density) as f64).abs();
            response(frequency) / INTERPOLATE.transform(&nodes, steps / per_cycle)
        });
        let nodes = SPREAD.nodes();
        let samples = times.iter().map(|time| {
            let u = time - middle;
            let scale = 1.0 / SPREAD.transform(&nodes, u.abs() / density);
            let turns = middles(density).map(|omega| cis(omega * u) * scale);
            Sample::new(
                u * 2.0 * per_cycle / density,
                2.0 * per_cycle / density,
                turns,
            )
        });
        Self {
            density,
            shares: shares.collect(),
            samples: samples.collect(),
            transform,
            middle,
        }
    }

    /// Returns the place on the grid of a tone of `frequency` cycles per sample; `None` beyond the grid.
    pub fn place(&self, frequency: f64) -> Option<Place> {
        let at = frequency * self.density + TAPS as f64;
        let first = libm::ceil(at - 0.5 * TAPS as f64);
        if !(0.0..=(self.shares.len() - TAPS) as f64).contains(&first) {
            return None;
        }
        let mut weights = [0.0; TAPS];
        for (k, w) in weights.iter_mut().enumerate() {
            *w = SPREAD.at((first + k as f64 - at) / (0.5 * TAPS as f64));
        }
        Some(Place {
            first: first as usize,
            weights,
            centre: cis(TAU * frequency * self.middle),
        })
    }

    /// Returns the position of `frequency`, cycles per sample, on the grid, in grid points.
    pub fn at(&self, frequency: f64) -> f64 {
        frequency * self.density + TAPS as f64
    }

    /// Returns the place on the grid of a tone at position `at`, in grid points, with weights from the table `spread`
    /// and the phase factor `centre`; `None` beyond the grid.
    pub fn place_by(&self, spread: &Spread, at: f64, centre: Complex64) -> Option<Place> {
        let fine = (at * SPREADS as f64 + 0.5) as usize;
        // The first grid point that a kernel covers is the one after its lower end.
        let first = fine.div_ceil(SPREADS);
        let first = first.checked_sub(TAPS / 2)?;
        if first > self.shares.len() - TAPS {
            return None;
        }
        Some(Place {
            first,
            weights: spread.weights[fine % SPREADS],
            centre,
        })
    }

    /// Returns a grid without tones.
    pub fn grid(&self) -> Vec<Complex64> {
        vec![Complex64::ZERO; self.shares.len()]
    }

    /// Adds a tone to `grid`; the phase of `amplitude` is that in the middle of the chirp.
    pub fn add(grid: &mut [Complex64], place: &Place, amplitude: Complex64) {
        if let Some(points) = grid.get_mut(place.first..place.first + TAPS) {
            for (g, w) in points.iter_mut().zip(place.weights) {
                *g += amplitude * w;
            }
        }
    }

    /// Multiplies the tones of `grid` by the phases that they have `delay` sample periods later.
    pub fn delay(&self, grid: &mut [Complex64], delay: f64) {
        for (m, point) in grid.iter_mut().enumerate() {
            *point *= cis(TAU * delay * (m as f64 - TAPS as f64) / self.density);
        }
    }

    /// Adds the grid's transform to the samples. `warp` shifts the time of every sample, in sample periods, far below
    /// one, to first order.
    pub fn sum(&self, grid: &[Complex64], warp: &[f64], samples: &mut [Complex64]) {
        let sums = self.sums(grid);
        for ((sum, w), sample) in sums.zip(warp).zip(samples) {
            *sample += sum.moved(*w);
        }
    }

    /// Returns the grid's transform at the sample times: value and slope of every sample.
    pub fn sums(&self, grid: &[Complex64]) -> impl Iterator<Item = Moving> {
        let times = self.even_times(grid);
        let middles = middles(self.density);
        self.samples.iter().map(move |s| s.sum(&times, middles))
    }

    /// Returns both signals at the evenly spaced times, with the first [`TIMES`] repeated at the end.
    fn even_times(&self, grid: &[Complex64]) -> Vec<Pair> {
        let length = self.transform.length();
        let mut lines = vec![Pair::default(); length];
        for (m, (g, share)) in grid.iter().zip(&self.shares).enumerate() {
            let line = g * share;
            let at = offset(m, self.density).rem_euclid(length as i64) as usize;
            lines[at].re[m % 2] = line.re;
            lines[at].im[m % 2] = line.im;
        }
        let mut times = self.transform.inverse(lines);
        times.extend_from_within(..TIMES.min(length));
        times
    }
}

/// Returns the position of grid point `m` in the transform of its signal (even or odd points), 0 being the middle.
fn offset(m: usize, density: f64) -> i64 {
    (m as i64 - (m % 2) as i64 - TAPS as i64 - density as i64) / 2
}

impl Sample {
    /// Creates the interpolation of a sample at `at` evenly spaced times from the middle of the chirp; `per_sample` of
    /// these times make a sample period.
    fn new(at: f64, per_sample: f64, turns: [Complex64; 2]) -> Self {
        let first = libm::ceil(at - 0.5 * TIMES as f64);
        let weights = core::array::from_fn(|k| {
            let x = (first + k as f64 - at) / (0.5 * TIMES as f64);
            let slope = INTERPOLATE.slope_at(x) / (-0.5 * TIMES as f64) * per_sample;
            [INTERPOLATE.at(x), slope]
        });
        Self {
            first: first as i64 as usize,
            weights,
            turns,
        }
    }

    fn sum(&self, times: &[Pair], middles: [f64; 2]) -> Moving {
        let (mut value, mut slope) = (Pair::default(), Pair::default());
        let first = self.first & (times.len() - TIMES - 1);
        for (time, [a, b]) in times[first..].iter().zip(&self.weights) {
            value.add_scaled(time, *a);
            slope.add_scaled(time, *b);
        }
        let mut sum = Moving::default();
        for (lane, (middle, turn)) in middles.iter().zip(self.turns).enumerate() {
            let (value, slope) = (value.lane(lane), slope.lane(lane));
            let turning = Complex64::new(0.0, *middle) * value;
            sum.value += value * turn;
            sum.slope += (slope + turning) * turn;
        }
        sum
    }
}

/// The kernel e^{β(√(1-x²) - 1)}, x from -1 to 1 over `taps` points.
struct Kernel {
    taps: f64,
    beta: f64,
    /// Number of points of the midpoint rule by which the kernel's transform is computed. The kernel is smooth and ends
    /// at e^-β.
    steps: usize,
}

impl Kernel {
    /// Returns the kernel's value at `x`, -1 to 1 from end to end.
    fn at(&self, x: f64) -> f64 {
        if x.abs() >= 1.0 {
            return 0.0;
        }
        libm::exp(self.beta * ((1.0 - x * x).sqrt() - 1.0))
    }

    /// Returns the derivative of the kernel by x.
    fn slope_at(&self, x: f64) -> f64 {
        if x.abs() >= 1.0 {
            return 0.0;
        }
        -self.beta * x / (1.0 - x * x).sqrt() * self.at(x)
    }

    /// Returns the step of the midpoint rule, in points of the kernel.
    fn step(&self) -> f64 {
        self.taps / self.steps as f64
    }

    /// Returns the kernel's values at the points of the midpoint rule from the middle on, times the step, and doubled
    /// for both sides.
    fn nodes(&self) -> Vec<f64> {
        (0..self.steps / 2)
            .map(|k| {
                let x = (k as f64 + 0.5) * self.step();
                2.0 * self.step() * self.at(2.0 * x / self.taps)
            })
            .collect()
    }

    /// Returns ∫ kernel(2x / taps) cos(2π v x) dx by the midpoint rule, from the values `nodes`.
    fn transform(&self, nodes: &[f64], v: f64) -> f64 {
        let turn = cis(TAU * v * self.step());
        let mut phase = cis(TAU * v * 0.5 * self.step());
        let mut sum = 0.0;
        for node in nodes {
            sum += node * phase.re;
            phase *= turn;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::maths::Random;

    #[test]
    fn a_tone_is_as_good_as_computed_directly() {
        let times: Vec<f64> = (0..200)
            .map(|n| f64::from(n) + 0.02 * f64::from(n * 7 % 5))
            .collect();
        let tones = Tones::new(&times, |_| Complex64::ONE);
        for frequency in [0.0, 0.013, 0.1005, 0.37, 0.912, 1.4, 1.99] {
            let place = tones.place(frequency).unwrap();
            let mut grid = tones.grid();
            Tones::add(&mut grid, &place, Complex64::new(0.6, -0.8));
            let mut samples = vec![Complex64::ZERO; 200];
            let warp: Vec<f64> = (0..200).map(|n| 1e-4 * f64::from(n % 3)).collect();
            tones.sum(&grid, &warp, &mut samples);
            for ((t, w), s) in times.iter().zip(&warp).zip(&samples) {
                let exact = cis(TAU * frequency * (t + w - 99.5)) * Complex64::new(0.6, -0.8);
                assert!((s - exact).l1_norm() < 3e-5, "{frequency} {t}: {s} {exact}");
            }
        }
        assert!(tones.place(2.2).is_none() && tones.place(-0.1).is_none());
    }

    /// Returns the value of the grid's transform `u` sample periods from the chirp's middle, summed point by point, and
    /// its derivative by time.
    fn directly(grid: &[Complex64], u: f64, density: f64, filter: &[Complex64]) -> Moving {
        let nodes = SPREAD.nodes();
        let scale = 1.0 / SPREAD.transform(&nodes, u.abs() / density);
        let mut sum = Moving::default();
        for (m, (g, filter)) in grid.iter().zip(filter).enumerate() {
            let omega = TAU * (m as f64 - TAPS as f64) / density;
            let part = g * filter * cis(omega * u) * scale;
            sum.value += part;
            sum.slope += part * Complex64::new(0.0, omega);
        }
        sum
    }

    #[test]
    fn a_grid_sums_to_what_its_points_sum_to_one_by_one() {
        let mut random = Random::new(3, 1);
        for count in [16_usize, 64, 77, 200, 249, 256, 400, 512] {
            for bow in [0.0, 1e-3, 0.03] {
                let time = |n: usize| {
                    let x = n as f64 / count as f64;
                    n as f64
                        + (bow * 4.0 * x * (1.0 - x) + 0.1 * bow * libm::sin(40.0 * x))
                            * count as f64
                };
                let times: Vec<f64> = (0..count).map(time).collect();
                let response = |f: f64| Complex64::new(1.0 / (1.0 + f * f), -0.3 * f);
                let tones = Tones::new(&times, response);
                let points = tones.shares.len();
                // Mean power 1, independent of the number of points.
                let power = 1.0 / points as f64;
                let grid: Vec<Complex64> = (0..points).map(|_| random.complex(power)).collect();
                let frequency = |m: usize| (m as f64 - TAPS as f64) / tones.density;
                let filter: Vec<Complex64> = (0..points).map(|m| response(frequency(m))).collect();
                for (time, sum) in times.iter().zip(tones.sums(&grid)) {
                    let u = time - tones.middle;
                    let exact = directly(&grid, u, tones.density, &filter);
                    let (value, slope) = (sum.value - exact.value, sum.slope - exact.slope);
                    assert!(value.l1_norm() < 1e-11, "{count} {bow} {time}: {value}");
                    assert!(slope.l1_norm() < 1e-9, "{count} {bow} {time}: {slope}");
                }
            }
        }
    }

    #[test]
    fn the_kernels_transform_is_its_integral() {
        for kernel in [SPREAD, INTERPOLATE] {
            let nodes = kernel.nodes();
            for v in [0.0, 0.07, 0.25] {
                let part = |k: usize| {
                    let x = (k as f64 + 0.5) * kernel.step() - 0.5 * kernel.taps;
                    kernel.at(2.0 * x / kernel.taps) * libm::cos(TAU * v * x) * kernel.step()
                };
                let exact: f64 = (0..kernel.steps).map(part).sum();
                assert!((kernel.transform(&nodes, v) / exact - 1.0).abs() < 1e-12);
            }
        }
    }
}
