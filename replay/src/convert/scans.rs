//! The scanner's results of a recording, scan by scan, for the files that `convert` writes.

use anyhow::Result;
use serde_json::Value;
use stairscan::config::EstimatorKind;
use stairscan::signal::grid::{DB_PER_UNIT, PolarMap};
use stairscan::signal::range::FULL_SCALE;

use crate::answer::Answer;
use crate::inspect::Inspection;
use crate::recording::Recording;
use crate::replay::{self, Options, Scanned};

/// Nanoseconds per second.
pub const SECOND_NS: u64 = 1_000_000_000;

/// A cell of the polar map.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Index of the row, in the order of the angles.
    pub row: usize,
    /// Angle of the beam, degrees: below the horizontal, or in the height plane from straight down to the front.
    pub angle_deg: f32,
    /// Range from the mirror's centre, metres.
    pub range_m: f32,
    /// Distance from the mirror and height above the ground of the cell, metres.
    pub place: (f32, f32),
    /// Power, decibels relative to a tone at the converter's full scale.
    pub power_db: f32,
    /// Whether the cell is a detection of the CA-CFAR.
    pub detected: bool,
}

/// Results of one scan of a recording.
#[derive(Clone, Debug)]
pub struct Scan {
    /// The scanner's answer.
    pub answer: Answer,
    /// The scanner's answer as one JSON object, as `replay --format json` prints it.
    pub json: Value,
    /// The echoes, as printed by `inspect --format json`; `None` if the estimator has no echoes.
    pub echoes: Option<Vec<Value>>,
    /// Cells of the polar map, row by row; empty unless requested.
    pub cells: Vec<Cell>,
    /// Time of the scan's end, nanoseconds since 1970; recordings contain no date, and begin at 0.
    pub stamp_ns: u64,
}

/// Returns the scans of a recording as answered by `replay`, with their maps if `with_map`.
///
/// # Errors
/// Names the property of the recording that prevents a scan.
pub fn of(recording: &Recording, options: &Options, with_map: bool) -> Result<Vec<Scan>> {
    let mut scans = Vec::new();
    replay::answers(recording, options, |scanned| {
        let mut scan = Scan::of(recording, scanned);
        if with_map {
            scan.cells = cells(scanned.pipeline.map());
        }
        scans.push(scan);
    })?;
    Ok(scans)
}

impl Scan {
    /// Returns the results of the scan that `replay` has just answered, without the map.
    pub fn of(recording: &Recording, scanned: &Scanned<'_>) -> Self {
        let (answer, config) = (scanned.answer, scanned.config);
        let echoes =
            (config.estimator == EstimatorKind::Likelihood).then(|| Inspection::of(scanned));
        Self {
            json: answer.json(),
            echoes: echoes.map(|i| i.echoes()),
            cells: Vec::new(),
            stamp_ns: stamp_ns(recording, answer.scan_of_recording()),
            answer: answer.clone(),
        }
    }

    /// Creates a scan from its sentences alone. The last of them arrived at `stamp_ns`, nanoseconds
    /// since 1970.
    pub fn from_sentences(answer: &Answer, stamp_ns: u64) -> Self {
        Self {
            json: answer.json(),
            echoes: None,
            cells: Vec::new(),
            stamp_ns,
            answer: answer.clone(),
        }
    }
}

/// Returns the time at which scan `k` (from 0) of a recording ended, nanoseconds: the time of its
/// last chirp, or k + 1 seconds for a recording without times. Both are counted from 1970, because
/// recordings contain no date; the computer's clock is not used.
fn stamp_ns(recording: &Recording, k: usize) -> u64 {
    let last = recording.chirps_of(k).end.saturating_sub(1);
    chirp_ns(recording, last).unwrap_or((k as u64 + 1) * SECOND_NS)
}

/// Returns the time of chirp `k` (from 0) of a recording, nanoseconds; `None` if the recording contains no times.
pub fn chirp_ns(recording: &Recording, k: usize) -> Option<u64> {
    let seconds = recording.meta.motion.time_s.get(k)?;
    Some((seconds * SECOND_NS as f64).round() as u64)
}

fn cells(map: &PolarMap) -> Vec<Cell> {
    let geometry = map.geometry();
    let rows = (0..map.rows()).filter(|&row| map.present(row));
    let cells = rows.flat_map(|row| {
        let angle_rad = map.angle_rad(row);
        map.row(row).iter().enumerate().map(move |(bin, &cell)| {
            let range_m = geometry.range_m(bin as f32);
            Cell {
                row,
                angle_deg: angle_rad.to_degrees(),
                range_m,
                place: geometry.point(range_m, angle_rad),
                power_db: (f32::from(cell) - f32::from(FULL_SCALE)) * DB_PER_UNIT,
                detected: map.is_detected(row, bin),
            }
        })
    });
    cells.collect()
}
