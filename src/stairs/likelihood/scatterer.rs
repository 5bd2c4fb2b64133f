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
use super::echo::MAX_ECHOES;
use crate::stairs::cluster::FuzzyArt;
use crate::stairs::map::MAX_ROWS;
use crate::stairs::particles::{Gaussian, Moments, Particle, SizedCloud, UNITS_PER_CELL};
use crate::{math, stairs::map::PolarMap};
use rand_core::Rng;

/// Curvature of the window's main lobe (Hann), dB per squared native bin.
pub const HANN_CURVATURE: f32 = 6.0;
/// Share of the departure that no model of one scatterer explains, dB: ripple of the filter's
/// triangle against the beam, rounding of the map's cells.
const MODEL_DB: f32 = 0.10;
/// Departure that the noise makes at 0 dB above it, dB.
const NOISE_DB: f32 = 1.3;
/// Departures count at most this many standard deviations …
const CLIP: f32 = 3.0;
/// … which are so many of the units that they are counted in.
const CLIPPED: i32 = 1024;
/// Fraction bits of [`Lobe::slopes`].
const SLOPE_BITS: u32 = 8;
/// Spread of the guesses at the start: rows and range bins.
const START: [f32; 2] = [0.8, 0.04];
/// Between the rounds the guesses are spread again by this much.
const AGAIN: [f32; 2] = [0.2, 0.01];
/// Most particles of one mode: more would tell no more.
pub const MODE_PARTICLES: usize = 20;
/// Weight of the best guess: many of them still add up in 32 bits.
const LARGEST_WEIGHT: u64 = 4095;
/// Parts of an octave that [`FALLING`] tells apart.
const PARTS: usize = 64;

/// Largest weight times 2^(-k/64).
static FALLING: [u16; PARTS] = falling();

const fn falling() -> [u16; PARTS] {
    // 2^(-1/64) in Q32.
    const PART: u64 = 4_248_701_965;
    let mut table = [0; PARTS];
    let mut weight = LARGEST_WEIGHT << 16;
    let mut k = 0;
    while k < PARTS {
        table[k] = ((weight + (1 << 15)) >> 16) as u16;
        weight = (weight * PART) >> 32;
        k += 1;
    }
    table
}

/// Weight of a guess whose misfit exceeds the best one's by `excess`.
fn weight(excess: u32) -> u16 {
    // From half squares in units of the departures to parts of an octave, Q16.
    const PARTS_PER_EXCESS: u32 = (0.5 * (CLIP * CLIP) / (CLIPPED * CLIPPED) as f32
        * core::f32::consts::LOG2_E
        * PARTS as f32
        * 65536.0
        + 0.5) as u32;
    // Eight squares of 20 bits each, times 26.
    let parts = ((excess * PARTS_PER_EXCESS) >> 16) as usize;
    let largest = FALLING.get(parts % PARTS).copied().unwrap_or(0);
    largest.checked_shr((parts / PARTS) as u32).unwrap_or(0)
}

/// Most particles in all.
const MOST: usize = 480;
/// Rounds of weighing and resampling.
const ROUNDS: usize = 2;

/// The levels of a patch as the responses see them, in units of 1/[`CLIPPED`] of the departure at
/// which one is clipped.
#[derive(Clone, Copy, Debug)]
pub struct Lobe {
    /// Per row: mean level less the beam's parabola around the patch's middle.
    rows: [i32; PATCH_ROWS.len()],
    /// Per bin: the same for the range response.
    bins: [i32; PATCH_BINS.len()],
    /// By how much one row, one bin to the next differ for each unit of a particle's place by which
    /// the scatterer is off, with [`SLOPE_BITS`] of fraction.
    slopes: [i32; 2],
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
        let [_, [_, _, middle, _, _], _] = *patch;
        let middle = f32::from(middle);
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
        let [near, at, far] = bins;
        let drop = 2.0 * at - near - far;
        let peak_bin = if drop > 1e-3 {
            (0.5 * (far - near) / drop).clamp(-0.5, 0.5)
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
        let scale = CLIPPED as f32 / (CLIP * math::hypot(MODEL_DB, noise));
        let per_unit = 2.0 * (1 << SLOPE_BITS) as f32 / f32::from(UNITS_PER_CELL);
        centre(&mut rows);
        centre(&mut bins);
        Self {
            rows: rows.map(|v| nearest(v * scale)),
            bins: bins.map(|v| nearest(v * scale)),
            slopes: [angle, range].map(|c| (c * scale * per_unit) as i32),
            peak: [peak_row, peak_bin],
            width,
        }
    }

    /// The sum of squared, clipped departures if the scatterer were at `at` (units of a particle's
    /// place off the middle).
    fn misfit(&self, at: [i32; 2]) -> u32 {
        let [row, bin] = at;
        let [angle, range] = self.slopes;
        let square = |departure: i32| {
            let clipped = departure.clamp(-CLIPPED, CLIPPED - 1);
            (clipped * clipped) as u32
        };
        let sum = |values: &[i32], offsets: &[i8], slope: i32| -> u32 {
            let pairs = values.iter().zip(offsets);
            pairs
                .map(|(&v, &d)| square(v.wrapping_sub(slope.wrapping_mul(d.into()))))
                .sum()
        };
        let (a, b) = (
            angle.wrapping_mul(row) >> SLOPE_BITS,
            range.wrapping_mul(bin) >> SLOPE_BITS,
        );
        sum(&self.rows, &PATCH_ROWS, a) + sum(&self.bins, &PATCH_BINS, b)
    }
}

/// The nearest whole number.
fn nearest(x: f32) -> i32 {
    (x + if x < 0.0 { -0.5 } else { 0.5 }) as i32
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

/// Where a mode starts.
#[derive(Clone, Copy, Debug)]
pub struct Mode {
    /// Row and bin of the map.
    pub cell: [u16; 2],
    /// What the map shows around.
    pub lobe: Lobe,
}

/// Refines one mode after the other and hands over its place.
#[inline(never)]
pub fn refine(
    cloud: &mut SizedCloud<MODE_PARTICLES>,
    modes: &[Mode],
    particles: usize,
    rng: &mut impl Rng,
    mut found: impl FnMut(Place),
) {
    let share = (particles.min(MOST) / modes.len().max(1)).clamp(1, MODE_PARTICLES);
    for mode in modes {
        found(mode.place(cloud, share, rng));
    }
}

/// Cells as a cloud's units.
fn units(cells: [f32; 2]) -> [i16; 2] {
    cells.map(|c| nearest(c * f32::from(UNITS_PER_CELL)) as i16)
}

/// A cloud's units as cells.
fn cells(units: [f32; 2]) -> [f32; 2] {
    units.map(|u| u / f32::from(UNITS_PER_CELL))
}

impl Mode {
    /// Draws the mode's particles, weighs and resamples them; their mean and spread.
    fn place(
        &self,
        cloud: &mut SizedCloud<MODE_PARTICLES>,
        share: usize,
        rng: &mut impl Rng,
    ) -> Place {
        let [row, bin] = self.cell.map(f32::from);
        let [row_off, bin_off] = self.lobe.peak;
        let peak = [row + row_off, bin + bin_off];
        let spread = |sigma: [f32; 2]| units(sigma).map(i16::unsigned_abs);
        let start = Gaussian {
            mean: units(peak),
            sigma: spread(START),
        };
        cloud.clear();
        cloud.add_mode(share, || start.draw(rng));
        let misfit = |at: [i16; 2]| {
            let [row, bin] = self.cell.map(|c| i32::from(c) * i32::from(UNITS_PER_CELL));
            let [at_row, at_bin] = at.map(i32::from);
            self.lobe.misfit([at_row - row, at_bin - bin])
        };
        // The least-squares place is close to the best one: weights relative to it use their range.
        let least = misfit(start.mean);
        let weight = |p: &Particle| weight(misfit(p.at).saturating_sub(least));
        for round in 0..ROUNDS {
            if round > 0 {
                cloud.resample(rng);
                for particle in cloud.particles_mut() {
                    let mean = particle.at;
                    let sigma = spread(AGAIN);
                    particle.at = Gaussian { mean, sigma }.draw(rng);
                }
            }
            cloud.weigh(weight);
        }
        match Moments::of(cloud.particles(), |p| p.weight) {
            Some(moments) => Place {
                at: cells(moments.mean),
                sigma: cells(moments.variance.map(math::sqrt)),
            },
            None => Place {
                at: peak,
                sigma: START,
            },
        }
    }
}

/// Fuzzy ART over the modes' places: modes whose particles went to the same scatterer fall into one
/// category.
pub struct Clusters {
    art: FuzzyArt<2, MAX_ECHOES>,
}

impl Clusters {
    /// Vigilance, thousandths: a category's box is at most 2 cells (row or bin) around.
    const VIGILANCE: u16 = 996;

    /// Without any category.
    pub fn new() -> Self {
        Self {
            art: FuzzyArt::new(Self::VIGILANCE),
        }
    }

    /// Takes a mode's place in; whether it founds a category.
    pub fn is_new(&mut self, place: &Place) -> bool {
        let [row, bin] = place.at;
        // 288 rows on a byte.
        let input = [row * (255.0 / MAX_ROWS as f32), bin].map(|v| v as u8);
        let before = self.art.categories().len();
        self.art.present(&input);
        self.art.categories().len() > before
    }
}
