//! Converts a recording to the data of the page.

use anyhow::{Context, Result};
use serde_json::{Value, json};
use stairscan::config::{Config, EstimatorKind};
use stairscan_replay::convert::{scans, tables};
use stairscan_replay::html;
use stairscan_replay::recording::Recording;
use stairscan_replay::replay::SEED;

use crate::request::Files;
use crate::{input, truth};

/// Returns version, estimators and defaults of the scanner in the page.
pub fn about() -> Value {
    let all: Vec<&str> = EstimatorKind::ALL.iter().map(|k| k.as_str()).collect();
    let defaults = Config::default();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "revision": stairscan::REVISION,
        "estimators": all,
        "estimator": defaults.estimator.as_str(),
        "seed": SEED,
    })
}

/// Returns the recording's entry in the page's data, with its own mounting.
///
/// # Errors
/// The recording cannot be scanned; the message names the cause.
pub fn shown(files: &Files, data: &[u8]) -> Result<Value> {
    let (own, set) = input::recordings(files, data)?;
    let options = input::options(&files.settings)?;
    // If the scan fails with these settings, the recording's own values are still shown.
    let mut entry = match html::entry(&set, &options) {
        Ok(entry) => entry,
        Err(error) => html::failed(&own.name, &format!("{error:#}")),
    };
    entry.data["own"] = mount(&own);
    entry.data["truth"] = truth::of_scans(&own)?;
    Ok(entry.data)
}

/// Returns the recording's steps as CSV.
///
/// # Errors
/// The recording cannot be scanned; the message names the cause.
pub fn table(files: &Files, data: &[u8]) -> Result<Value> {
    let (_, set) = input::recordings(files, data)?;
    let scans = scans::of(&set, &input::options(&files.settings)?, false)?;
    let table = tables::write(&scans, tables::Table::Steps)?;
    let table = String::from_utf8(table).context("table of steps")?;
    Ok(json!({"csv": table}))
}

/// Returns size and mounting of the recording; null without a mirror.
fn mount(recording: &Recording) -> Value {
    let Some(mirror) = &recording.meta.mirror else {
        return Value::Null;
    };
    json!({
        "chirps": recording.chirps(),
        "samples": recording.meta.samples_per_chirp,
        "plane": input::word(mirror.plane),
        "mount_height_m": mirror.mount_height_m,
        "mirror_offset_m": mirror.offset_m,
        "beamwidth_deg": mirror.beamwidth_deg,
    })
}
