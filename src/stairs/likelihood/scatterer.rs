//! Particles as hypotheses about one point scatterer each (paper III-A, put on its feet).
//!
//! A mode is a bright place of the filtered map. Its particles are guesses (angle, range) of the
//! one scatterer there; each is weighed by how well the known responses in angle (two-way beam
//! through the matched filter) and in range (window's main lobe) explain the levels around. Both
//! are parabolas in logarithmic power, so a row's or a bin's departure from the parabola around the
//! guess is all that has to be looked at. Departures are clipped: where a neighbour's flank raises
//! one side of the lobe, the other side still tells. After resampling, mean and spread of a mode
//! are its scatterer's sub-cell place and covariance.

use super::beam;
use super::beam::{LEVEL_DB, PATCH_BINS, PATCH_ROWS, Patch};
use crate::stairs::particles::{Gaussian, Particle, SizedCloud, UNITS_PER_CELL};
use crate::{math, stairs::map::PolarMap};
use rand_core::Rng;

/// Curvature of the window's main lobe (Hann), dB per squared native bin.
pub const HANN_CURVATURE: f32 = 6.0;
/// Share of the departure that no model of one scatterer explains, dB: ripple of the filter's
/// triangle against the beam, rounding of the map's cells.
const MODEL_DB: f32 = 0.10;
/// Departure that the noise makes at 0 dB above it, dB.
const NOISE_DB: f32 = 1.3;
/// Departures count at most this many standard deviations.
const CLIP: f32 = 3.0;
/// Spread of the guesses at the start: rows and range bins.
const START: [f32; 2] = [1.5, 0.06];
/// Between the rounds the guesses are spread again by this much.
const AGAIN: [f32; 2] = [0.3, 0.015];
/// Most particles of one mode: more would tell no more.
pub const MODE_PARTICLES: usize = 64;
/// Rounds of weighing and resampling.
const ROUNDS: usize = 2;

/// The levels of a patch as the responses see them.
#[derive(Clone, Copy, Debug)]
pub struct Lobe {
    /// Per row: mean level less the beam's parabola around the patch's middle, dB.
    rows: [f32; PATCH_ROWS.len()],
    /// Per bin: the same for the range response.
    bins: [f32; PATCH_BINS.len()],
    /// dB per squared row and per squared bin.
    curvature: [f32; 2],
    /// Standard deviation of the departures, dB.
    sigma_db: f32,
    /// Least-squares place: rows and bins off the middle.
    pub peak: [f32; 2],
    /// Width in angle in units of a point scatterer's; large where there is no peak.
    pub width: f32,
}

/// What the responses look like on this map's grid.
#[derive(Clone, Copy, Debug)]
pub struct Responses {
    /// dB per squared row of the filtered lobe, and per squared bin.
    curvature: [f32; 2],
}

impl Responses {
    /// The responses for the geometry and the native range resolution c/2B.
    pub fn new(map: &PolarMap, resolution_m: f32) -> Self {
        let geometry = map.geometry();
        let sigma = beam::two_way_sigma(geometry.beamwidth_rad) * core::f32::consts::SQRT_2;
        let rows = geometry.step_rad / sigma;
        let bins = geometry.bin_m / resolution_m;
        // 10 lg e / 2 = 2.17
        Self {
            curvature: [2.171_472_4 * rows * rows, HANN_CURVATURE * bins * bins],
        }
    }
}

impl Lobe {
    /// Looks at the levels around a maximum that stands `db` above the noise.
    pub fn new(patch: &Patch, responses: &Responses, db: f32) -> Self {
        let [angle, range] = responses.curvature;
        let mut rows = [0f32; PATCH_ROWS.len()];
        let mut bins = [0f32; PATCH_BINS.len()];
        let middle = f32::from(patch[PATCH_BINS.len() / 2][PATCH_ROWS.len() / 2]);
        for (bin, levels) in bins.iter_mut().zip(patch) {
            for (row, &level) in rows.iter_mut().zip(levels) {
                let value = (f32::from(level) - middle) * LEVEL_DB;
                *row += value / PATCH_BINS.len() as f32;
                *bin += value / PATCH_ROWS.len() as f32;
            }
        }
        // Least squares over the symmetric grid: slope Σ d v / Σ d², and curvature from the
        // quadratic that is orthogonal to the mean.
        let (mut slope, mut bend) = (0.0, 0.0);
        for (&d, v) in PATCH_ROWS.iter().zip(&rows) {
            let d = f32::from(d);
            slope += d * v / 26.0;
            bend += (d * d - 5.2) * v / 58.8;
        }
        let (peak_row, width) = if bend < -0.02 * angle {
            (
                (-0.5 * slope / bend).clamp(-4.0, 4.0),
                math::sqrt(-angle / bend),
            )
        } else {
            (0.0, 9.0)
        };
        let drop = 2.0 * bins[1] - bins[0] - bins[2];
        let peak_bin = if drop > 1e-3 {
            (0.5 * (bins[2] - bins[0]) / drop).clamp(-0.5, 0.5)
        } else {
            0.0
        };
        for (v, &d) in rows.iter_mut().zip(&PATCH_ROWS) {
            *v += angle * f32::from(d) * f32::from(d);
        }
        for (v, &d) in bins.iter_mut().zip(&PATCH_BINS) {
            *v += range * f32::from(d) * f32::from(d);
        }
        let noise = NOISE_DB * super::dimension::amplitude(-db);
        let mut lobe = Self {
            rows,
            bins,
            curvature: [angle, range],
            sigma_db: math::hypot(MODEL_DB, noise),
            peak: [peak_row, peak_bin],
            width,
        };
        centre(&mut lobe.rows);
        centre(&mut lobe.bins);
        lobe
    }

    /// Half the sum of squared, clipped departures in units of their variance if the scatterer were
    /// at `at` (rows and bins off the middle).
    fn misfit(&self, at: [f32; 2]) -> f32 {
        let scale = 1.0 / self.sigma_db;
        let departure = |v: f32, slope: f32, d: i8| {
            let z = (v - slope * f32::from(d)) * scale;
            (z * z).min(CLIP * CLIP)
        };
        let (a, b) = (
            2.0 * self.curvature[0] * at[0],
            2.0 * self.curvature[1] * at[1],
        );
        let rows = self
            .rows
            .iter()
            .zip(&PATCH_ROWS)
            .map(|(&v, &d)| departure(v, a, d));
        let bins = self
            .bins
            .iter()
            .zip(&PATCH_BINS)
            .map(|(&v, &d)| departure(v, b, d));
        0.5 * (rows.sum::<f32>() + bins.sum::<f32>())
    }
}

/// Takes the mean off.
fn centre(values: &mut [f32]) {
    let mean = values.iter().sum::<f32>() / values.len().max(1) as f32;
    values.iter_mut().for_each(|v| *v -= mean);
}

/// Where a scatterer is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    /// Mean: row and bin of the map.
    pub at: [f32; 2],
    /// Standard deviation: rows and bins.
    pub sigma: [f32; 2],
}

/// Refines every mode in `lobes` (each with the candidate's cell) and hands its place to `found`.
pub fn refine(
    cloud: &mut SizedCloud<MODE_PARTICLES>,
    modes: &[(u16, u8, Lobe)],
    particles: usize,
    rng: &mut impl Rng,
    mut found: impl FnMut(usize, Place),
) {
    let units = f32::from(UNITS_PER_CELL);
    let share = (particles / modes.len().max(1)).min(MODE_PARTICLES);
    for (m, (row, bin, lobe)) in modes.iter().enumerate() {
        let middle = [f32::from(*row), f32::from(*bin)];
        let mean = [0, 1].map(|k| ((middle[k] + lobe.peak[k]) * units) as i16);
        let gaussian = Gaussian {
            mean,
            sigma: START.map(|s| (s * units) as u16),
        };
        cloud.clear();
        cloud.add_mode(share, || gaussian.draw(rng));
        for round in 0..ROUNDS {
            if round > 0 {
                for particle in cloud.particles_mut() {
                    let jitter = Gaussian {
                        mean: particle.at,
                        sigma: AGAIN.map(|s| (s * units) as u16),
                    };
                    particle.at = jitter.draw(rng);
                }
            }
            let misfit =
                |p: &Particle| lobe.misfit([0, 1].map(|k| f32::from(p.at[k]) / units - middle[k]));
            let least = cloud
                .particles()
                .iter()
                .map(misfit)
                .fold(f32::INFINITY, f32::min);
            cloud.weigh(|p| (4095.0 * math::exp(least - misfit(p))) as u16);
            if round + 1 < ROUNDS {
                cloud.resample(rng);
            }
        }
        let moments = crate::stairs::particles::Moments::of(cloud.particles(), |p| p.weight);
        if let Some(moments) = moments {
            found(
                m,
                Place {
                    at: moments.mean.map(|v| v / units),
                    sigma: moments.variance.map(|v| math::sqrt(v) / units),
                },
            );
        }
    }
}
