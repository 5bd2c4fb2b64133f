//! Lobe of one point scatterer: position of its peak between the cells, its width, and their variance.
//!
//! The responses in angle (two-way beam through the matched filter) and in range (the window's main lobe) are
//! parabolas in logarithmic power. If such a parabola is subtracted from the levels around a maximum, a line
//! remains. Its slope gives the scatterer's offset from the middle.
//!
//! A scatterer that approaches while the beam sweeps over it changes its range from row to row: its lobe is
//! sheared, narrower in angle at any one range, and the two offsets are no longer independent.

use super::angle_filter::{self, LEVEL_DB, PATCH_BINS, PATCH_ROWS, Patch};
use crate::estimate::Estimate;
use crate::math;
use crate::params::Params;
use crate::signal::grid::PolarMap;

/// Decrease of a Gaussian's logarithmic power at one standard deviation from its peak, dB: 10 lg e / 2.
pub const GAUSSIAN_DB: f32 = 2.171_472_4;
/// Maximum offset of a peak from the middle of its patch, rows: the extent of the patch plus one.
const MAX_PEAK_OFFSET_ROWS: f32 = 4.0;
/// Minimum curvature over the rows of a lobe that has a peak, as a share of a point scatterer's.
const MIN_CURVATURE: f32 = 0.02;
/// Width given to a lobe without a peak, in units of a point scatterer's.
const NO_LOBE: f32 = 9.0;

/// Mean of the squared row offsets [`PATCH_ROWS`].
const MEAN_SQUARE: f32 = 5.2;
/// Sum over [`PATCH_ROWS`] of (offset² - mean)²: norm of the quadratic that is orthogonal to the mean.
const QUADRATIC: f32 = 58.8;

/// Offset of a lobe's peak from the middle of the strongest cell, in rows or in range bins, and its variance for levels
/// with a variance of 1 dB².
type Offset = (f32, f32);

/// Curvatures of a point scatterer's response on the grid of the map.
#[derive(Clone, Copy, Debug)]
pub struct Responses {
    /// Curvature of the filtered lobe in angle: dB by which the level falls at one row from the peak (dB per squared
    /// row).
    per_row_db: f32,
    /// Curvature of the window's main lobe in range: dB by which the level falls at one stored bin from the peak (dB
    /// per squared bin).
    per_bin_db: f32,
    /// Mixed curvature of a lobe that is sheared by motion, dB per row and stored bin; 0 without motion.
    cross_db: f32,
}

/// Motion of a scatterer from row to row.
#[derive(Clone, Copy, Debug)]
pub struct ScattererMotion {
    /// Change of the scatterer's range from row to row, stored bins; negative when it approaches.
    pub bins: f32,
    /// Angle by which the beam moves over the scatterer from row to row, in steps of the scan: 1 without
    /// motion.
    pub steps: f32,
}

impl Responses {
    /// Returns the responses for the map's geometry and the native range resolution c/2B, metres.
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

    /// Returns how far the peak of a sheared lobe lies from its strongest cell, in rows and in range bins. The
    /// arguments are raw offsets, `row` estimated along the rows alone and `bin` along the bins alone: the shear adds
    /// to each a multiple of the other, which is removed here.
    fn decouple(&self, row: Offset, bin: Offset) -> (Offset, Offset) {
        let of_bin = self.cross_db / self.per_row_db;
        let of_row = self.cross_db / self.per_bin_db;
        // Positive, because the quadratic form is positive definite.
        let left = 1.0 - of_bin * of_row;
        let solve = |own: Offset, other: Offset, of_other: f32| {
            let value = (own.0 - of_other * other.0) / left;
            let variance = (own.1 + of_other * of_other * other.1) / (left * left);
            (value, variance)
        };
        (solve(row, bin, of_bin), solve(bin, row, of_row))
    }

    /// Returns the responses to a scatterer that moves by `walk` from row to row: beam pattern and range main
    /// lobe, sheared, after the filter along the angle, all of them Gaussian.
    pub fn of_motion(&self, walk: ScattererMotion) -> Self {
        // Inverse variances in the unit of the curvatures. The filter is matched to the beam without motion.
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

/// Position of a scatterer relative to the cell of its maximum, and width of its lobe.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lobe {
    /// Offset of the scatterer from the middle of the cell with the maximum, rows, with its variance.
    pub row: Estimate,
    /// Offset of the scatterer from the middle of the cell with the maximum, stored range bins, with its variance.
    pub bin: Estimate,
    /// Width of the lobe over the angle, in units of a point scatterer's; 9 for a lobe without a peak.
    pub width: f32,
}

impl Lobe {
    /// Fits the lobe to the filtered levels `patch` around a maximum whose SNR is `snr_db`; `responses` are the
    /// curvatures of a point scatterer's lobe.
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
        let width = if bend < -MIN_CURVATURE * responses.per_row_db {
            math::sqrt(-responses.per_row_db / bend)
        } else {
            NO_LOBE
        };
        let noise_db = params.level_noise_db * math::amplitude(-snr_db);
        let sigma_db = math::hypot(params.lobe_model_db, noise_db);
        let mut row = offset(&mut rows, &PATCH_ROWS, responses.per_row_db);
        let mut bin = offset(&mut bins, &PATCH_BINS, responses.per_bin_db);
        if responses.cross_db != 0.0 {
            (row, bin) = responses.decouple(row, bin);
        }
        Self {
            row: Estimate {
                value: row.0.clamp(-MAX_PEAK_OFFSET_ROWS, MAX_PEAK_OFFSET_ROWS),
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

/// Returns the offset of the peak of a parabola with curvature `per_cell_db`, and its variance for levels of
/// unit variance: from the slope of the levels `values` (dB, overwritten) over the cells `at` after the
/// parabola has been subtracted.
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
