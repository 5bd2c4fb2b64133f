//! Scans a recording by the code of `cargo sim replay`, with the events of the estimator.

use std::path::Path;

use anyhow::{Result, bail, ensure};
use numpy::{PyArray1, PyArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value, json};
use stairscan::config::{Config, EstimatorKind};
use stairscan::observer::{Event, Observer};
use stairscan::signal::grid::{DB_PER_UNIT, PolarMap};
use stairscan::signal::range::FULL_SCALE;
use stairscan_replay::answer::Answer;
use stairscan_replay::recording::Recording;
use stairscan_replay::replay::{self, Options, Scanned};
use stairscan_replay::views::PosteriorView;
use stairscan_replay::{inspect, posterior, setup};

use crate::{records, settings};

/// Reads the recording at `path`, with or without suffix.
///
/// # Errors
/// The recording is invalid; the message names file, key and expected value.
pub fn read(path: &Path) -> Result<Recording> {
    if path.is_dir() {
        let error = std::io::Error::from(std::io::ErrorKind::IsADirectory);
        bail!(anyhow::Error::new(error).context(format!(
            "{}: expected one recording (a pair NAME.sigmf-meta, NAME.sigmf-data)",
            path.display()
        )));
    }
    Recording::read(path)
}

/// Refuses a scan that is larger than the scanner's map, or whose range is too short. For a recording this would be
/// reported as a fault of the radar module, which does not help a user with an array.
///
/// # Errors
/// The message describes the expected size.
pub fn check_size(recording: &Recording, options: &Options) -> Result<()> {
    let (config, _) = setup::config(recording, 0, &options.config)?;
    let config = Config {
        radar: config.radar.scaled(config.mount.range_scale),
        ..config
    };
    let refused = Box::<PolarMap>::default().begin(&config).err();
    match refused {
        None => Ok(()),
        Some(error) => bail!("iq: {} chirps: {error}", recording.chirps()),
    }
}

/// The polar map in the form of arrays.
struct Map {
    /// Logarithmic power, row after row.
    cells: Vec<u8>,
    /// Whether the cell passes the CA-CFAR.
    detected: Vec<bool>,
    /// Whether the row's chirp was received.
    present: Vec<bool>,
    /// Beam angle of each row, degrees.
    angles_deg: Vec<f32>,
    /// Range of each bin from the mirror's centre, metres.
    ranges_m: Vec<f32>,
    shape: [usize; 2],
}

impl Map {
    fn of(map: &PolarMap) -> Self {
        let (rows, bins) = (map.rows(), map.bins());
        let geometry = map.geometry();
        let hits = |row| (0..bins).map(move |bin| map.is_detected(row, bin));
        Self {
            cells: (0..rows).flat_map(|row| map.row(row)).copied().collect(),
            detected: (0..rows).flat_map(hits).collect(),
            present: (0..rows).map(|row| map.present(row)).collect(),
            angles_deg: (0..rows)
                .map(|row| map.angle_rad(row).to_degrees())
                .collect(),
            ranges_m: (0..bins).map(|bin| geometry.range_m(bin as f32)).collect(),
            shape: [rows, bins],
        }
    }
}

/// Observer of the estimator's events.
#[derive(Default)]
struct Onlooker {
    /// Median of the filtered map, dB relative to full scale.
    noise_dbfs: Option<f32>,
    /// Angle bias, degrees, and mount-height error, metres.
    calibration: Option<(f64, f32)>,
    echoes: Vec<u8>,
    particles: Vec<u8>,
    counts: Vec<f32>,
    view: PosteriorView,
    /// For each cell of the path: its far end, metres, the probability that the answer is correct up to there, and
    /// the required probability.
    way: Vec<f32>,
}

impl Observer for Onlooker {
    fn event(&mut self, event: Event<'_>) {
        match event {
            Event::Noise(units) => {
                self.noise_dbfs = Some((units - f32::from(FULL_SCALE)) * DB_PER_UNIT);
            }
            Event::Calibration(found) => {
                let bias_deg = f64::from(found.bias_rad).to_degrees();
                self.calibration = Some((bias_deg, found.height_m));
            }
            Event::Scatterer(scatterer) => records::echo(&mut self.echoes, scatterer),
            Event::Posterior { cloud, view } => {
                self.counts = cloud.counts().to_vec();
                self.view = posterior::view(cloud, view);
                for (staircase, probability) in cloud.particles() {
                    records::particle(&mut self.particles, staircase, probability);
                }
            }
            Event::Cell(cell) => self.way.extend([cell.end_m, cell.p_correct, cell.required]),
            _ => {}
        }
    }
}

/// Result of one scan.
pub struct Scan {
    answer: Answer,
    config: Config,
    sample_rate_hz: Option<f64>,
    map: Map,
    onlooker: Onlooker,
}

impl Scan {
    fn of(scanned: &Scanned<'_>, sample_rate_hz: Option<f64>) -> Self {
        let map = scanned.pipeline.map();
        let mut onlooker = Onlooker::default();
        if scanned.config.estimator == EstimatorKind::Likelihood {
            inspect::repeat(scanned, &mut onlooker);
        }
        Self {
            answer: scanned.answer.clone(),
            config: *scanned.config,
            sample_rate_hz,
            map: Map::of(map),
            onlooker,
        }
    }

    /// Converts to plain objects and arrays; the arrays take over the memory.
    pub fn into_python(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let (map, onlooker) = (self.map, self.onlooker);
        let dict = PyDict::new(py);
        dict.set_item("answer", self.answer.json().to_string())?;
        dict.set_item("sentences", &self.answer.sentences)?;
        dict.set_item("text", self.answer.text())?;
        dict.set_item("summary", self.answer.summary())?;
        let config = settings::to_python(py, &self.config, self.sample_rate_hz)?;
        dict.set_item("config", config)?;
        let cells = PyArray1::from_vec(py, map.cells);
        dict.set_item("map", cells.reshape(map.shape)?)?;
        let detected = PyArray1::from_vec(py, map.detected);
        dict.set_item("detected", detected.reshape(map.shape)?)?;
        dict.set_item("present", PyArray1::from_vec(py, map.present))?;
        dict.set_item("angles_deg", PyArray1::from_vec(py, map.angles_deg))?;
        dict.set_item("ranges_m", PyArray1::from_vec(py, map.ranges_m))?;
        dict.set_item("noise_dbfs", onlooker.noise_dbfs)?;
        dict.set_item("calibration", onlooker.calibration)?;
        dict.set_item("echoes", PyArray1::from_vec(py, onlooker.echoes))?;
        let cells = onlooker.way.len() / 3;
        let way = PyArray1::from_vec(py, onlooker.way);
        dict.set_item("way", way.reshape([cells, 3])?)?;
        if !onlooker.counts.is_empty() {
            dict.set_item("counts", PyArray1::from_vec(py, onlooker.counts))?;
            dict.set_item("particles", PyArray1::from_vec(py, onlooker.particles))?;
            dict.set_item("hypotheses", hypotheses(&onlooker.view).to_string())?;
        }
        Ok(dict)
    }
}

/// Returns name, probability and edges of each hypothesis, likeliest first.
fn hypotheses(view: &PosteriorView) -> Value {
    let each = view.hypotheses.iter();
    each.map(|h| json!([h.name, h.probability, h.edges]))
        .collect()
}

/// Returns the answers of scan `wanted` (from 0) of a recording or, without it, of all its scans.
///
/// # Errors
/// The recording cannot be scanned; the message names the cause.
pub fn of(recording: &Recording, options: &Options, wanted: Option<usize>) -> Result<Vec<Scan>> {
    let scans = options.scans_of(recording)?;
    if let Some(wanted) = wanted {
        ensure!(
            wanted < scans,
            "{}: scan {wanted}, counted from 0: there {}",
            recording.name,
            match scans {
                1 => "is 1 scan".to_owned(),
                n => format!("are {n} scans"),
            }
        );
    }
    // Later scans do not affect the wanted one.
    let last = wanted.map_or(scans, |wanted| wanted + 1);
    let options = Options {
        scans: Some(u32::try_from(last)?),
        ..*options
    };
    let (mut found, mut number) = (Vec::new(), 0);
    replay::answers(recording, &options, |scanned| {
        if wanted.is_none_or(|wanted| wanted == number) {
            found.push(Scan::of(scanned, recording.meta.sample_rate_hz));
        }
        number += 1;
    })?;
    Ok(found)
}
