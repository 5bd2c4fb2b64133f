//! The compiled part of the Python package `stairscan`: from recordings and arrays of samples to answers and arrays.
//!
//! | module | from → to |
//! |---|---|
//! | `settings` | Python's `Config` ↔ a recording's metadata and the scanner's configuration |
//! | `samples` | arrays → a recording in memory |
//! | `scans` | a recording → answers with map, echoes and posterior, by the code of `cargo sim replay` |
//! | `records` | echoes and particles → the bytes of numpy's structured arrays |
//! | `refusals` | errors → Python's exceptions |
//!
//! Only plain objects cross the boundary (numbers, text, JSON, arrays); `package/stairscan/` converts them to
//! dataclasses. Arrays are handed over without a copy: numpy owns the memory that was filled here.

mod records;
mod refusals;
mod samples;
mod scans;
mod settings;

use std::path::PathBuf;

use numpy::{PyArray1, PyArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stairscan::signal::grid::DB_PER_UNIT;
use stairscan::signal::range::FULL_SCALE;
use stairscan_replay::recording::Recording;
use stairscan_replay::replay::Options;

use refusals::{guarded, refused};
use samples::Numbers;

/// Returns the answers of a recording's scans, all of them or scan `scan` (from 0).
#[pyfunction]
fn replay<'py>(
    py: Python<'py>,
    path: PathBuf,
    scan: Option<usize>,
    options: &Bound<'py, PyDict>,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let options = settings::options(options)?;
    let found = guarded(py, || {
        let recording = scans::read(&path)?;
        scans::of(&recording, &options, scan)
    })?;
    found.into_iter().map(|scan| scan.into_python(py)).collect()
}

/// Returns the answer to one scan's samples: an array (chirps, samples, 2) of I and Q.
#[pyfunction]
fn scan<'py>(
    py: Python<'py>,
    numbers: Numbers<'py>,
    angles_deg: Vec<f64>,
    config: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyDict>> {
    let given = settings::Given::of(config)?;
    let (count, each, samples) = numbers.samples()?;
    let document = given.document(count, each, &angles_deg);
    let options = Options {
        config: given.config,
        ..Options::default()
    };
    let found = guarded(py, || {
        let recording = Recording::of(samples::NAME, &document, samples)?;
        scans::check_size(&recording, &options)?;
        scans::of(&recording, &options, Some(0))
    });
    let found = found.map_err(|error| samples::in_words_of_python(py, error))?;
    let first = found.into_iter().next();
    let first = first.ok_or_else(|| refused("iq: the scanner gave no answer"))?;
    first.into_python(py)
}

/// Returns what a recording holds: samples (chirps, samples, 2), angles, configuration, metadata.
#[pyfunction]
fn read<'py>(py: Python<'py>, path: PathBuf) -> PyResult<Bound<'py, PyDict>> {
    let recording = guarded(py, || scans::read(&path))?;
    let dict = PyDict::new(py);
    dict.set_item("name", &recording.name)?;
    let shape = [recording.chirps(), recording.meta.samples_per_chirp, 2];
    let values = recording.samples.iter().flat_map(|s| [s.i, s.q]).collect();
    let values = PyArray1::from_vec(py, values);
    dict.set_item("iq", values.reshape(shape)?)?;
    dict.set_item("angles_deg", settings::angles_deg(&recording))?;
    dict.set_item("scans", recording.scans())?;
    dict.set_item("config", settings::of_recording(py, &recording)?)?;
    let metadata = recording.metadata_text();
    dict.set_item("metadata", metadata.map_err(|e| refused(&e.to_string()))?)?;
    Ok(dict)
}

/// Returns the scanner's settings at their defaults.
#[pyfunction]
fn defaults(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    settings::to_python(py, &stairscan::config::Config::default(), None)
}

/// The compiled half of the package.
#[pymodule]
fn _stairscan(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(replay, module)?)?;
    module.add_function(wrap_pyfunction!(scan, module)?)?;
    module.add_function(wrap_pyfunction!(read, module)?)?;
    module.add_function(wrap_pyfunction!(defaults, module)?)?;
    // Map units of a cell at full scale, and decibels per map unit.
    module.add("FULL_SCALE", FULL_SCALE)?;
    module.add("DB_PER_UNIT", DB_PER_UNIT)?;
    module.add("MAX_STEPS", stairscan::model::MAX_STEPS)?;
    module.add("REVISION", stairscan::REVISION)
}
