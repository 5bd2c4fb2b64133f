//! The truth of a recording: told to the page, and put in the place of what its metadata say.

use anyhow::{Context, Result};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use host_sim::recording::Recording;
use serde_json::{Value, json};

use crate::input;
use crate::request::Truths;

/// Truth that counts from the mirror at the first chirp.
const TRUTH: &str = "stairscan:truth";
/// Truth of each scan, from the mirror at its end.
const TRUTH_SCANS: &str = "stairscan:truth_scans";

/// What the recording says of each scan: `travel_m` of the mirror at its end, and its `truth`, null where it says none.
///
/// # Errors
/// Metadata that cannot be written.
pub fn told(recording: &Recording) -> Result<Value> {
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

/// Travel of the mirror from the first chirp to the end of scan `k`, metres: the true one, or as odometry has it; 0 of a
/// chair that stands.
fn travel_m(recording: &Recording, k: usize) -> f64 {
    let meta = &recording.meta;
    let measured = || {
        let last = recording.chirps_of(k).end.checked_sub(1)?;
        meta.motion.travel_m.get(last)
    };
    let known = meta.sequence.truth_travel_m.get(k).or_else(measured);
    known.copied().unwrap_or(0.0)
}

/// Metadata of the recording with another truth, as `meta`. Where the samples are no SigMF file of the project's, `data`
/// is one, in base64, and the metadata belong to it.
///
/// # Errors
/// Names the key of the truth and what was expected of it.
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
