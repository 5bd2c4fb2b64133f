//! Converts the files of a page to a recording.

use anyhow::{Context, Result, anyhow, ensure};
use serde_json::Value;
use stairscan::config::{Config, EstimatorKind, Plane};
use stairscan_replay::convert::keys::Given;
use stairscan_replay::convert::npy::Layout;
use stairscan_replay::convert::{Chirps, angles};
use stairscan_replay::recording::{self, MirrorSetup, Recording};
use stairscan_replay::replay::{Options, SEED};

use crate::request::{Files, Settings};

/// Default angle of an array's first chirp, degrees: the paper's.
const FIRST_ANGLE_DEG: f64 = -20.0;
/// Default angle between an array's chirps, degrees: the paper's.
const ANGLE_STEP_DEG: f64 = 0.25;
/// Default bandwidth of an array, Hz: the paper's.
const BANDWIDTH_HZ: f64 = 10e9;

/// Returns a plane's name in recordings.
pub fn word(plane: Plane) -> &'static str {
    match plane {
        Plane::Depth => "depth",
        Plane::Height => "height",
    }
}

/// Returns the recording in the files, unchanged and with the page's settings applied.
///
/// # Errors
/// A file, key or setting is invalid; the message names it and the expected value.
pub fn recordings(files: &Files, data: &[u8]) -> Result<(Recording, Recording)> {
    let own = match files.array {
        true => of_array(files, data)?,
        false => of_pair(files, data)?,
    };
    let mut set = own.clone();
    mount(&mut set, &files.settings)?;
    Ok((own, set))
}

/// Returns the options of the scan.
///
/// # Errors
/// A setting is invalid; the message names it, the value and the expected value.
pub fn options(settings: &Settings) -> Result<Options> {
    let mut config = Config::default();
    if let Some(word) = &settings.estimator {
        config.estimator = EstimatorKind::from_name(word).with_context(|| {
            let all: Vec<&str> = EstimatorKind::ALL.iter().map(|k| k.as_str()).collect();
            format!(
                "estimator: found {word:?}, expected one of {}",
                all.join(", ")
            )
        })?;
    }
    config.seed = settings.seed.unwrap_or(SEED);
    Ok(Options {
        config,
        single: settings.single,
        ..Options::default()
    })
}

/// Reads a SigMF pair: a recording of the project, or another one with all keys that a scan needs.
fn of_pair(files: &Files, data: &[u8]) -> Result<Recording> {
    let name = &files.name;
    let text = files.meta.as_ref();
    let text = text.with_context(|| format!("{name}.sigmf-meta: missing beside its samples"))?;
    let document: Option<Value> = recording::document(text).ok();
    let datatype = document
        .as_ref()
        .and_then(|d| d["global"]["core:datatype"].as_str());
    match (datatype, &document) {
        (None | Some("ci16_le" | "ri16_le"), _) | (_, None) => Recording::parse(name, text, data),
        (Some(_), Some(document)) => {
            let file = || format!("{name}.sigmf-meta");
            let chirps = Chirps::of_sigmf(document.clone(), data, None, None).with_context(file)?;
            let recording = chirps.recording(name, &Given::default(), None, None);
            recording.with_context(file)
        }
    }
}

/// Reads a numpy array, whose keys come from a metadata file or from the page.
fn of_array(files: &Files, data: &[u8]) -> Result<Recording> {
    let file = || format!("{}.npy", files.name);
    let settings = &files.settings;
    let full_scale = settings.full_scale;
    if let Some(value) = full_scale {
        ensure!(
            value.is_finite() && value > 0.0,
            "full scale: found {value}, expected a number above 0"
        );
    }
    let base: Option<Value> = match &files.meta {
        Some(text) => {
            let context = || format!("{}.sigmf-meta", files.name);
            Some(recording::document(text).with_context(context)?)
        }
        None => None,
    };
    let samples = base
        .as_ref()
        .and_then(|b| b["global"]["stairscan:samples_per_chirp"].as_u64());
    let layout = Layout::ByShape(samples.and_then(|n| usize::try_from(n).ok()));
    let chirps = Chirps::of_array(data, full_scale, &layout).with_context(file)?;
    let defaults = Config::default().mount;
    let missing = |value: Option<f64>, default: f64| match base {
        Some(_) => value,
        None => Some(value.unwrap_or(default)),
    };
    let given = Given {
        bandwidth_hz: missing(settings.bandwidth_hz, BANDWIDTH_HZ),
        mirror_offset_m: missing(None, f64::from(defaults.mirror_offset) * 1e-5),
        mount_height_m: missing(None, f64::from(defaults.mount_height) * 1e-5),
        beamwidth_deg: missing(None, f64::from(defaults.beamwidth) * 1e-3),
        scan_plane: base
            .is_none()
            .then(|| word(defaults.plane.first()).to_owned()),
        ..Given::default()
    };
    let table = array_angles(files, chirps.count(), base.is_some())?;
    let recording = chirps.recording(&files.name, &given, base.as_ref(), table.as_deref());
    recording.with_context(file)
}

/// Returns one angle for each chirp, from a table or from the page; `None` if the metadata contain
/// them.
fn array_angles(files: &Files, chirps: usize, is_described: bool) -> Result<Option<Vec<f64>>> {
    if let Some(text) = &files.angles {
        let table = angles::parse(text).context("table of angles")?;
        ensure!(
            table.len() == chirps,
            "table of angles: {} angles, expected {chirps}: one a chirp of {}.npy",
            table.len(),
            files.name
        );
        return Ok(Some(table));
    }
    let settings = &files.settings;
    if is_described && settings.first_angle_deg.is_none() && settings.angle_step_deg.is_none() {
        return Ok(None);
    }
    let first = settings.first_angle_deg.unwrap_or(FIRST_ANGLE_DEG);
    let step = settings.angle_step_deg.unwrap_or(ANGLE_STEP_DEG);
    ensure!(
        first.is_finite() && step.is_finite() && step != 0.0,
        "angle step: found {step}, expected degrees other than 0"
    );
    Ok(Some((0..chirps).map(|k| first + k as f64 * step).collect()))
}

/// Replaces the recording's mounting by the page's settings.
fn mount(recording: &mut Recording, settings: &Settings) -> Result<()> {
    let plane = match settings.plane.as_deref() {
        None => None,
        Some(given) => {
            let known = [Plane::Depth, Plane::Height]
                .into_iter()
                .find(|p| word(*p) == given);
            Some(
                known
                    .with_context(|| format!("plane: found {given:?}, expected depth or height"))?,
            )
        }
    };
    let meta = &mut recording.meta;
    if let Some(mirror) = &meta.mirror {
        let positive = |name: &str, value: Option<f64>, own: f64| match value {
            Some(value) if !(value.is_finite() && value > 0.0) => {
                Err(anyhow!("{name}: found {value}, expected a number above 0"))
            }
            value => Ok(value.unwrap_or(own)),
        };
        let offset = settings.mirror_offset_m.unwrap_or(mirror.offset_m);
        ensure!(
            offset.is_finite() && offset >= 0.0,
            "mirror offset: found {offset} m, expected 0 or more"
        );
        meta.mirror = Some(MirrorSetup {
            offset_m: offset,
            beamwidth_deg: positive("beam width", settings.beamwidth_deg, mirror.beamwidth_deg)?,
            mount_height_m: positive(
                "mount height",
                settings.mount_height_m,
                mirror.mount_height_m,
            )?,
            plane: plane.unwrap_or(mirror.plane),
        });
    }
    if let Some(turn) = settings.angle_offset_deg {
        ensure!(
            turn.is_finite() && turn.abs() <= 90.0,
            "angle offset: found {turn} degrees, expected -90 to 90"
        );
        meta.angles_deg.iter_mut().for_each(|angle| *angle += turn);
    }
    Ok(())
}
