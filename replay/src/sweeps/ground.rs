//! Distance up to which the ground's echo is detectable: chirps of guard sweeps in, a distance out.
//!
//! It is a reference for the distance up to which a sweep can detect anything at best, computed
//! without the scanner's code. The ground is cut into pieces of 10 cm. The echo of a piece is the
//! mean power at the ranges of the ground, over the rows within the beam's width of it, weighted
//! like the two-way beam, and over three sweeps. It is detectable where that power is 3 dB above
//! the noise.

use core::f64::consts::{LN_2, PI, TAU};

use anyhow::{Context, Result};
use stairscan::Iq;

use crate::recording::{Metadata, Recording};

/// Number of sweeps whose rows are averaged.
pub const SWEEPS: usize = 3;
/// Length of a piece of ground along the way, metres.
const PIECE_M: f64 = 0.1;
/// Nearest and farthest end of the pieces of ground, metres from the mirror: within the rows of a
/// mirror at 0.4 m, and within the guard's range.
const FROM_M: f64 = 0.5;
const TO_M: f64 = 1.7;
/// Distance between the points at which the power of a piece of ground is sampled, metres.
const STEP_M: f64 = 0.02;
/// Minimum ratio of the power of a piece of ground, which includes noise, to that of noise at which
/// the ground's echo is detectable: 3 dB.
const MIN_POWER_RATIO: f64 = 2.0;
/// Minimum angle between a row and the direction of the ground at a cell's range, at which the cell
/// counts as noise, radians.
const OFF_RAD: f64 = 7.0 * PI / 180.0;
/// Quantile, 0…1, of the powers of the cells off the ground, from which the mean noise power is estimated. Objects that
/// stand on the ground fill the upper quantiles.
const QUANTILE: f64 = 0.35;
/// Speed of light, m/s.
const LIGHT: f64 = 299_792_458.0;

/// Range spectrum of one row, with the row's direction and place.
#[derive(Clone, Debug)]
pub struct Row {
    /// Power by range bin, in arbitrary units; entry `k` is bin `first + k` of [`Meter`], the first
    /// that can hold ground.
    powers: Vec<f32>,
    /// Angle of the row below the true horizontal, radians.
    below: f64,
    /// Reading of the odometer at this row, metres.
    travel_m: f64,
}

/// Computes the powers of ground and noise from chirps, for one mounting and one kind of chirp.
#[derive(Clone, Debug)]
pub struct Meter {
    height_m: f64,
    offset_m: f64,
    bin_m: f64,
    width_rad: f64,
    real: bool,
    /// Number of the first range bin that is computed, that of the mirror's height.
    first: usize,
    /// Windowed cosine and sine, `waves[k][n]`, of bin `first + k` at sample `n`.
    waves: Vec<Vec<[f32; 2]>>,
}

impl Meter {
    /// Creates the meter for the mounting and the chirps of a recording.
    ///
    /// # Errors
    /// The recording does not contain the mirror's mounting.
    pub fn new(meta: &Metadata) -> Result<Self> {
        let mirror = meta.mirror.as_ref().context("no mirror")?;
        let bin_m = LIGHT / (2.0 * meta.bandwidth_hz);
        let values = meta.samples_per_chirp * if meta.real { 2 } else { 1 };
        let bin = |range_m: f64| ((range_m + mirror.offset_m) / bin_m) as usize;
        let (height_m, offset_m) = (mirror.mount_height_m, mirror.offset_m);
        let (first, last) = (bin(height_m), bin(libm::hypot(TO_M, height_m)) + 2);
        let wave = |k: usize| {
            let turn = |n: usize| {
                let window = 0.5 - 0.5 * libm::cos(TAU * (n as f64 + 0.5) / values as f64);
                let (sin, cos) = libm::sincos(TAU * ((k * n) % values) as f64 / values as f64);
                [(window * cos) as f32, (window * sin) as f32]
            };
            (0..values).map(turn).collect()
        };
        Ok(Self {
            height_m,
            offset_m,
            bin_m,
            width_rad: mirror.beamwidth_deg.to_radians(),
            real: meta.real,
            first,
            waves: (first..=last).map(wave).collect(),
        })
    }

    /// Computes the range spectrum of a chirp, and returns it as a row. `angle_deg` is the row's angle below the
    /// chair's horizontal, `pitch_deg` the chair's pitch, nose up, and `travel_m` the odometer's reading.
    pub fn row(&self, chirp: &[Iq], angle_deg: f64, pitch_deg: f64, travel_m: f64) -> Row {
        let values: Vec<[f32; 2]> = match self.real {
            true => (chirp.iter())
                .flat_map(|iq| [[f32::from(iq.i), 0.0], [f32::from(iq.q), 0.0]])
                .collect(),
            false => (chirp.iter())
                .map(|iq| [f32::from(iq.i), f32::from(iq.q)])
                .collect(),
        };
        let count = values.len().max(1) as f32;
        let sum = |part: usize| values.iter().map(|v| v[part]).sum::<f32>() / count;
        let mean = [sum(0), sum(1)];
        let power = |wave: &Vec<[f32; 2]>| {
            let (mut re, mut im) = (0.0_f32, 0.0_f32);
            for ([a, b], [cos, sin]) in values.iter().zip(wave) {
                let (a, b) = (a - mean[0], b - mean[1]);
                re += a * cos + b * sin;
                im += b * cos - a * sin;
            }
            re * re + im * im
        };
        Row {
            powers: self.waves.iter().map(power).collect(),
            below: (angle_deg - pitch_deg).to_radians(),
            travel_m,
        }
    }

    /// Returns the mean noise power of a cell, estimated from a quantile of all cells that are at
    /// least [`OFF_RAD`] off the ground; infinite without such cells.
    fn noise(&self, rows: &[Row]) -> f64 {
        let mut cells = Vec::new();
        for row in rows {
            for (k, power) in row.powers.iter().enumerate() {
                let range_m = (self.first + k) as f64 * self.bin_m - self.offset_m;
                let ground = libm::asin((self.height_m / range_m).min(1.0));
                if (row.below - ground).abs() >= OFF_RAD {
                    cells.push(*power);
                }
            }
        }
        if cells.is_empty() {
            return f64::INFINITY;
        }
        let at = (QUANTILE * cells.len() as f64) as usize;
        let (_, quantile, _) = cells.select_nth_unstable_by(at, f32::total_cmp);
        // The power of noise is distributed exponentially.
        f64::from(*quantile) / -libm::log(1.0 - QUANTILE)
    }

    /// Returns the mean power of the piece of ground that begins `from_m` metres from the mirror at
    /// the odometer's reading `travel_m`; `None` where no row looks there.
    fn piece(&self, rows: &[Row], from_m: f64, travel_m: f64) -> Option<f64> {
        let (mut sum, mut weights) = (0.0, 0.0);
        for row in rows {
            for k in 0..(PIECE_M / STEP_M + 0.5) as usize {
                let x_m = from_m + (k as f64 + 0.5) * STEP_M + travel_m - row.travel_m;
                let off = 2.0 * (row.below - libm::atan2(self.height_m, x_m)) / self.width_rad;
                if off.abs() > 1.0 {
                    continue;
                }
                let range_m = libm::hypot(x_m, self.height_m) + self.offset_m;
                let bin = (range_m / self.bin_m + 0.5) as usize;
                let Some(power) = bin.checked_sub(self.first).and_then(|b| row.powers.get(b))
                else {
                    continue;
                };
                // Half the one-way power at the edge of the beam, squared for the two-way beam.
                let weight = libm::exp(-2.0 * LN_2 * off * off);
                sum += weight * f64::from(*power);
                weights += weight;
            }
        }
        (weights > 0.0).then(|| sum / weights)
    }

    /// Returns the distance up to which the ground's echo is detectable in the rows of the last
    /// sweeps, metres from the mirror at the odometer's reading `travel_m`.
    pub fn ground_echo_range_m(&self, rows: &[Row], travel_m: f64) -> f64 {
        let noise = self.noise(rows);
        let pieces = ((TO_M - FROM_M) / PIECE_M + 0.5) as usize;
        let place = |k: usize| FROM_M + k as f64 * PIECE_M;
        let dark = |k: &usize| {
            let power = self.piece(rows, place(*k), travel_m);
            power.is_none_or(|power| power < MIN_POWER_RATIO * noise)
        };
        place((0..pieces).find(dark).unwrap_or(pieces))
    }
}

/// Whether the ground's echo, detectable up to `ground_echo_range_m`, is detectable up to a hazard
/// at `at_m` (both metres). Only whole pieces of ground before the hazard count.
pub fn reaches(ground_echo_range_m: f64, at_m: f64) -> bool {
    ground_echo_range_m + PIECE_M > at_m
}

/// Returns the distance up to which the ground's echo is detectable, metres from the mirror at the
/// end of each sweep of a recording, one per sweep.
///
/// # Errors
/// The recording does not contain the mirror's mounting.
pub fn of(recording: &Recording) -> Result<Vec<f64>> {
    let meter = Meter::new(&recording.meta).with_context(|| recording.name.clone())?;
    let meta = &recording.meta;
    let at = |list: &[f64], k: usize| list.get(k).copied().unwrap_or(0.0);
    let row = |k: usize| {
        let chirp = recording.chirp(k).unwrap_or_default();
        let (travel, pitch) = (&meta.motion.travel_m, &meta.motion.pitch_deg);
        meter.row(chirp, at(&meta.angles_deg, k), at(pitch, k), at(travel, k))
    };
    let rows: Vec<Row> = (0..recording.chirps()).map(row).collect();
    let sweeps = 0..recording.scans();
    Ok(sweeps
        .map(|sweep| {
            let chirps = recording.chirps_of(sweep);
            let from = recording.chirps_of(sweep.saturating_sub(SWEEPS - 1)).start;
            let travel_m = at(&meta.motion.travel_m, chirps.end - 1);
            meter.ground_echo_range_m(&rows[from..chirps.end], travel_m)
        })
        .collect())
}
