//! What the scanner makes of a recording, scan by scan, for the outputs.

use anyhow::Result;
use serde_json::Value;
use stairscan::config::EstimatorKind;
use stairscan::signal::grid::{DB_PER_UNIT, PolarMap};
use stairscan::signal::range::FULL_SCALE;

use crate::answer::Answer;
use crate::inspect::Inspection;
use crate::recording::Recording;
use crate::replay::{self, Options, Scanned};

/// Nanoseconds of a second.
pub const SECOND_NS: u64 = 1_000_000_000;

/// A cell of the polar map.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Row, in the order of the angles.
    pub row: usize,
    /// Angle of the beam, degrees, as the scan's plane counts it.
    pub angle_deg: f32,
    /// Range from the mirror's centre, metres.
    pub range_m: f32,
    /// Distance and height of the cell, metres.
    pub place: (f32, f32),
    /// Power, decibels relative to a tone at the converter's full scale.
    pub power_db: f32,
    /// Whether CA-CFAR let it through.
    pub detected: bool,
}

/// One scan.
#[derive(Clone, Debug)]
pub struct Scan {
    /// What the scanner says.
    pub answer: Answer,
    /// The same as `replay --format json` prints it.
    pub told: Value,
    /// The echoes, as `inspect --format json` prints them; `None` where the estimator knows none.
    pub echoes: Option<Vec<Value>>,
    /// The map; empty unless it is asked for.
    pub cells: Vec<Cell>,
    /// When the scan ended, nanoseconds.
    pub stamp_ns: u64,
}

/// The scans of a recording as `replay` answers them, with their maps where `with_map` says so.
///
/// # Errors
/// Names what in the recording no scan can be made of.
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
    /// The scan that `replay` has just answered, without the map.
    pub fn of(recording: &Recording, scanned: &Scanned<'_>) -> Self {
        let (answer, config) = (scanned.answer, scanned.config);
        let map = scanned.pipeline.map();
        let echoes = (config.estimator == EstimatorKind::Likelihood)
            .then(|| Inspection::of(map, config, answer.scan.scan, &scanned.drive));
        Self {
            told: answer.json(),
            echoes: echoes.map(|i| i.echoes()),
            cells: Vec::new(),
            stamp_ns: stamp_ns(recording, answer.scan_of_recording()),
            answer: answer.clone(),
        }
    }

    /// A scan by its sentences alone, the last of which came at `stamp_ns`, nanoseconds since 1970.
    pub fn heard(answer: &Answer, stamp_ns: u64) -> Self {
        Self {
            told: answer.json(),
            echoes: None,
            cells: Vec::new(),
            stamp_ns,
            answer: answer.clone(),
        }
    }
}

/// When scan `k` (from 0) of a recording ended: the time of its last chirp, or, for a recording without
/// times, k + 1 seconds. Either counts from 1970, for recordings hold no date: no clock is asked.
fn stamp_ns(recording: &Recording, k: usize) -> u64 {
    let last = recording.chirps_of(k).end.saturating_sub(1);
    chirp_ns(recording, last).unwrap_or((k as u64 + 1) * SECOND_NS)
}

/// When chirp `k` (from 0) of a recording with times was made, nanoseconds.
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
                detected: map.hit(row, bin),
            }
        })
    });
    cells.collect()
}
