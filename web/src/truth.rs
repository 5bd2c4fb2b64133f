//! Reads the ground truth of a recording for the page, and writes metadata with another one.

use anyhow::{Context, Result};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use stairscan_replay::recording::Recording;

use crate::input;
use crate::request::Truths;

/// Key of the ground truth relative to the mirror at the first chirp.
const TRUTH: &str = "stairscan:truth";
/// Key of the ground truth of each scan, relative to the mirror at its end.
const TRUTH_SCANS: &str = "stairscan:truth_scans";

/// Returns for each scan `travel_m` of the mirror at its end, and its `truth`; null without one.
///
/// # Errors
/// The metadata cannot be written.
pub fn of_scans(recording: &Recording) -> Result<Value> {
    let document: Value = serde_json::from_str(&recording.metadata_text()?)?;
    let global = &document["global"];
    let scans = recording.scans();
    let truth = |k: usize| match scans {
        1 if global[TRUTH_SCANS].is_null() => &global[TRUTH],
        _ => &global[TRUTH_SCANS][k],
    };
    let list = (0..scans).map(|k| json!({"travel_m": travel_m(recording, k), "truth": truth(k)}));
    Ok(list.collect())
}

/// Returns the travel of the mirror from the first chirp to the end of scan `k`, metres: the true one, else that of
/// odometry; 0 at standstill.
fn travel_m(recording: &Recording, k: usize) -> f64 {
    let meta = &recording.meta;
    let measured = || {
        let last = recording.chirps_of(k).end.checked_sub(1)?;
        meta.motion.travel_m.get(last)
    };
    let known = meta.sequence.truth_travel_m.get(k).or_else(measured);
    known.copied().unwrap_or(0.0)
}

/// Returns the metadata of the recording with another ground truth, as `meta`. If the samples are not in a SigMF file
/// of the project, `data` is such a file, in base64, to which the metadata belong.
///
/// # Errors
/// A key of the ground truth is invalid; the message names it and the expected value.
pub fn saved(truths: &Truths, data: &[u8]) -> Result<Value> {
    let files = &truths.files;
    let (own, _) = input::recordings(files, data)?;
    let samples = own.sample_bytes();
    let same = !files.array && samples == data;
    let text = match &files.meta {
        Some(text) if same => text.clone(),
        _ => own.metadata_text()?,
    };
    let mut document: Value = serde_json::from_str(&text).context("metadata")?;
    let global = document["global"]
        .as_object_mut()
        .context("metadata without global")?;
    global.insert(TRUTH.to_owned(), truths.whole.clone());
    if own.scans() > 1 {
        global.insert(TRUTH_SCANS.to_owned(), truths.scans.clone());
    } else {
        global.remove(TRUTH_SCANS);
    }
    let text = format!("{document}\n");
    Recording::parse(&own.name, &text, &samples)?;
    Ok(json!({
        "meta": text,
        "data": (!same).then(|| STANDARD.encode(&samples)),
    }))
}
