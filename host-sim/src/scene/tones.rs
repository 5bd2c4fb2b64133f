//! From echoes to beat tones: thousands of ranges summed into one chirp without a loop over both.
//!
//! Each echo is spread over a few points of a grid of beat frequencies, the grid is summed into the
//! samples, and the kernel's own transform is divided out (non-uniform Fourier transform; Barnett,
//! Magland, af Klinteberg, SIAM J. Sci. Comput. 41, 2019). Sample times need not be even, so that the
//! sweep's deviation from a straight line is exact and not a correction.

use core::f64::consts::TAU;

use num_complex::Complex64;

use super::maths::cis;

/// Points of the grid that an echo is spread over. Six leave an error below -90 dB.
const TAPS: usize = 6;

/// Exponent of the kernel e^{β(√(1-x²) - 1)}.
const BETA: f64 = 2.30 * TAPS as f64;

/// Highest beat frequency, cycles per sample: everything beyond has been filtered out or is too far.
pub const HIGHEST: f64 = 2.0;

/// A beat tone's place on the grid.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    first: usize,
    weights: [f64; TAPS],
    /// Phase that moves the origin of time from the first sample to the middle of the chirp.
    pub centre: Complex64,
}

/// The grid and its way to the samples.
#[derive(Clone)]
pub struct Tones {
    /// Grid points per cycle per sample.
    density: f64,
    /// Number of grid points.
    points: usize,
    /// `table[n * points + m]`: tone m at sample n, kernel divided out, filter applied.
    table: Vec<Complex64>,
    /// Frequency of every grid point, cycles per sample.
    frequencies: Vec<f64>,
    middle: f64,
}

impl Tones {
    /// Tones at the sample times `times` (in samples, 0 for the first, nearly even), each multiplied by
    /// the receiver's `response` to its frequency.
    pub fn new(times: &[f64], response: impl Fn(f64) -> Complex64) -> Self {
        let middle = 0.5 * (times.len() as f64 - 1.0);
        // Twice as dense as the chirp's length asks for, and a little for uneven times.
        let density = 2.0 * (times.len() as f64 + 8.0);
        let margin = TAPS as f64;
        let points = (HIGHEST * density) as usize + 2 * TAPS;
        let frequencies: Vec<f64> = (0..points).map(|m| (m as f64 - margin) / density).collect();
        let responses: Vec<Complex64> = frequencies.iter().map(|&f| response(f)).collect();
        let mut table = Vec::with_capacity(points * times.len());
        for time in times {
            let u = time - middle;
            let scale = 1.0 / kernel_transform(u / density);
            let tones = frequencies.iter().zip(&responses);
            table.extend(tones.map(|(f, r)| cis(TAU * f * u) * r * scale));
        }
        Self {
            density,
            points,
            table,
            frequencies,
            middle,
        }
    }

    /// Place of the tone of `frequency` cycles per sample, or `None` beyond the grid.
    pub fn place(&self, frequency: f64) -> Option<Place> {
        let at = frequency * self.density + TAPS as f64;
        let first = libm::ceil(at - 0.5 * TAPS as f64);
        if !(0.0..=(self.points - TAPS) as f64).contains(&first) {
            return None;
        }
        let mut weights = [0.0; TAPS];
        for (k, w) in weights.iter_mut().enumerate() {
            *w = kernel((first + k as f64 - at) / (0.5 * TAPS as f64));
        }
        Some(Place {
            first: first as usize,
            weights,
            centre: cis(TAU * frequency * self.middle),
        })
    }

    /// An empty grid.
    pub fn grid(&self) -> Vec<Complex64> {
        vec![Complex64::ZERO; self.points]
    }

    /// Adds a tone of `amplitude` (its phase is that in the middle of the chirp).
    pub fn add(grid: &mut [Complex64], place: &Place, amplitude: Complex64) {
        if let Some(points) = grid.get_mut(place.first..place.first + TAPS) {
            for (g, w) in points.iter_mut().zip(place.weights) {
                *g += amplitude * w;
            }
        }
    }

    /// Sums the grid into the samples. `warp` moves every sample's time by a small fraction of a sample
    /// (first order in it).
    pub fn sum(&self, grid: &[Complex64], warp: &[f64], samples: &mut [Complex64]) {
        let used = |g: &Complex64| *g != Complex64::ZERO;
        let low = grid.iter().position(used).unwrap_or(0);
        let high = grid.iter().rposition(used).map_or(low, |m| m + 1);
        let grid = &grid[low..high];
        let slopes: Vec<Complex64> = grid
            .iter()
            .zip(&self.frequencies[low..high])
            .map(|(g, f)| g * Complex64::new(0.0, TAU * f))
            .collect();
        let rows = self.table.chunks_exact(self.points);
        for ((row, w), sample) in rows.zip(warp).zip(samples) {
            let (mut sum, mut slope) = (Complex64::ZERO, Complex64::ZERO);
            for ((g, s), t) in grid.iter().zip(&slopes).zip(&row[low..high]) {
                sum += g * t;
                slope += s * t;
            }
            *sample += sum + slope * w;
        }
    }
}

fn kernel(x: f64) -> f64 {
    if x.abs() >= 1.0 {
        return 0.0;
    }
    libm::exp(BETA * ((1.0 - x * x).sqrt() - 1.0))
}

/// ∫ kernel(2x / TAPS) cos(2π v x) dx by the midpoint rule: the kernel is smooth and ends at e^-β.
fn kernel_transform(v: f64) -> f64 {
    const STEPS: usize = 400;
    let width = TAPS as f64 / STEPS as f64;
    (0..STEPS)
        .map(|k| {
            let x = (k as f64 + 0.5) * width - 0.5 * TAPS as f64;
            kernel(2.0 * x / TAPS as f64) * libm::cos(TAU * v * x) * width
        })
        .fold(0.0, |sum, part| sum + part)
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
