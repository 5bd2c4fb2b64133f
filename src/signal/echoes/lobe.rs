//! The lobe of one point scatterer: where its peak lies between the cells, how wide it is, and how
//! well that is known.
//!
//! The responses in angle (two-way beam through the matched filter) and in range (the window's main
//! lobe) are parabolas in logarithmic power. What is left of the levels around a maximum once such
//! a parabola is taken off lies on a line whose slope says how far off the middle the scatterer is.
//!
//! A scatterer that nears while the beam sweeps over it walks through the ranges: its lobe is sheared,
//! narrower in angle at any one range, and the two offsets are no longer independent.

use super::angle_filter::{self, LEVEL_DB, PATCH_BINS, PATCH_ROWS, Patch};
use crate::estimate::Estimate;
use crate::math;
use crate::params::Params;
use crate::signal::grid::PolarMap;

/// Curvature of a Gaussian of unit variance in logarithmic power: 10 lg e / 2, dB.
pub const GAUSSIAN_DB: f32 = 2.171_472_4;
/// Farthest that a peak may lie from the middle of its patch, rows: what the patch reaches and one.
const MOST_ROWS: f32 = 4.0;
/// With less than this share of a point scatterer's curvature the levels have no peak.
const LEAST_CURVED: f32 = 0.02;
/// Width where there is no peak, in units of a point scatterer's.
const NO_LOBE: f32 = 9.0;

/// Mean of the squared offsets of [`PATCH_ROWS`].
const MEAN_SQUARE: f32 = 5.2;
/// Sum over [`PATCH_ROWS`] of (offset² - mean)²: what a quadratic that is orthogonal to the mean is
/// divided by.
const QUADRATIC: f32 = 58.8;

/// An offset and the variance of it for levels of unit variance.
type Offset = (f32, f32);

/// What the responses look like on this map's grid.
#[derive(Clone, Copy, Debug)]
pub struct Responses {
    /// Of the filtered lobe, dB per squared row.
    per_row_db: f32,
    /// Of the window's main lobe, dB per squared stored bin.
    per_bin_db: f32,
    /// Of both, dB per row and stored bin; 0 where nothing moves.
    cross_db: f32,
}

/// How a scatterer moves from row to row.
#[derive(Clone, Copy, Debug)]
pub struct Walk {
    /// Stored range bins by which it comes nearer (negative).
    pub bins: f32,
    /// By how much the beam moves over it, in steps of the sweep: 1 if it stands.
    pub steps: f32,
}

impl Responses {
    /// The responses for the geometry and the native range resolution c/2B.
    pub fn new(map: &PolarMap, resolution_m: f32, params: &Params) -> Self {
        let geometry = map.geometry();
        let rows = geometry.step_rad / angle_filter::lobe_sigma_rad(geometry);
        let bins = geometry.bin_m / resolution_m;
        Self {
            per_row_db: GAUSSIAN_DB * rows * rows,
            per_bin_db: params.range_curvature_db * bins * bins,
            cross_db: 0.0,
        }
    }

    /// Parts what a sheared lobe has mixed: each slope holds some of the other's offset.
    fn part(&self, row: Offset, bin: Offset) -> (Offset, Offset) {
        let of_bin = self.cross_db / self.per_row_db;
        let of_row = self.cross_db / self.per_bin_db;
        // Of a positive definite form: above 0.
        let left = 1.0 - of_bin * of_row;
        let solve = |own: Offset, other: Offset, of_other: f32| {
            let value = (own.0 - of_other * other.0) / left;
            let variance = (own.1 + of_other * of_other * other.1) / (left * left);
            (value, variance)
        };
        (solve(row, bin, of_bin), solve(bin, row, of_row))
    }

    /// The responses to a scatterer that walks: the pattern of the beam and the main lobe in range,
    /// sheared, through the filter along the angle, all of them Gaussian.
    pub fn of_walk(&self, walk: Walk) -> Self {
        // Inverse variances, in the unit of the curvatures. The filter's is that of the standing beam.
        let filter = 2.0 * self.per_row_db;
        let beam = filter * walk.steps * walk.steps;
        let sum = beam + filter + walk.bins * walk.bins * self.per_bin_db;
        Self {
            per_row_db: filter - filter * filter / sum,
            per_bin_db: self.per_bin_db
                - walk.bins * walk.bins * self.per_bin_db * self.per_bin_db / sum,
            cross_db: -walk.bins * self.per_bin_db * filter / sum,
        }
    }
}

/// A scatterer's place relative to the cell of its maximum.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lobe {
    /// Rows off the cell.
    pub row: Estimate,
    /// Stored range bins off the cell.
    pub bin: Estimate,
    /// Width in angle in units of a point scatterer's; large where there is no peak.
    pub width: f32,
}

impl Lobe {
    /// Looks at the levels around a maximum that stands `snr_db` above the noise.
    pub fn new(patch: &Patch, responses: &Responses, snr_db: f32, params: &Params) -> Self {
        let mut rows = [0f32; PATCH_ROWS.len()];
        let mut bins = [0f32; PATCH_BINS.len()];
        let [_, [_, _, middle, _, _], _] = *patch;
        for (bin, levels) in bins.iter_mut().zip(patch) {
            for (row, &level) in rows.iter_mut().zip(levels) {
                let value = (f32::from(level) - f32::from(middle)) * LEVEL_DB;
                *row += value / PATCH_BINS.len() as f32;
                *bin += value / PATCH_ROWS.len() as f32;
            }
        }
        let bend = PATCH_ROWS.iter().zip(&rows).map(|(&d, v)| {
            let d = f32::from(d);
            (d * d - MEAN_SQUARE) * v / QUADRATIC
        });
        let bend: f32 = bend.sum();
        let width = if bend < -LEAST_CURVED * responses.per_row_db {
            math::sqrt(-responses.per_row_db / bend)
        } else {
            NO_LOBE
        };
        let noise_db = params.level_noise_db * math::amplitude(-snr_db);
        let sigma_db = math::hypot(params.lobe_model_db, noise_db);
        let mut row = offset(&mut rows, &PATCH_ROWS, responses.per_row_db);
        let mut bin = offset(&mut bins, &PATCH_BINS, responses.per_bin_db);
        if responses.cross_db != 0.0 {
            (row, bin) = responses.part(row, bin);
        }
        Self {
            row: Estimate {
                value: row.0.clamp(-MOST_ROWS, MOST_ROWS),
                variance: row.1 * sigma_db * sigma_db,
            },
            bin: Estimate {
                value: bin.0.clamp(-1.0, 1.0),
                variance: bin.1 * sigma_db * sigma_db,
            },
            width,
        }
    }
}

/// Where the peak of a parabola of this curvature lies, and the variance of that for levels of unit
/// variance: the slope of `values` (dB) over their offsets `at` once the parabola is taken off.
fn offset(values: &mut [f32], at: &[i8], per_cell_db: f32) -> Offset {
    let (mut squares, mut slope) = (0.0, 0.0);
    for (v, &d) in values.iter_mut().zip(at) {
        let d = f32::from(d);
        *v += per_cell_db * d * d;
        squares += d * d;
    }
    let mean = values.iter().sum::<f32>() / values.len().max(1) as f32;
    for (v, &d) in values.iter().zip(at) {
        slope += f32::from(d) * (v - mean);
    }
    let scale = 0.5 / per_cell_db.max(f32::MIN_POSITIVE);
    (scale * slope / squares, scale * scale / squares)
}
