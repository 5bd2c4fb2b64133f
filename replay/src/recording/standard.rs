//! SigMF's own keys (`core:`): which are used, which are refused, and which have no influence.
//!
//! In: a metadata document of any program. The table [`KEYS`] lists all keys of the standard; docs/user/formats.md shows
//! it. A value that would make the samples something else than one chirp after another is refused.

use anyhow::{Result, anyhow, ensure};
use serde_json::Value;
use sha2::{Digest as _, Sha512};

use super::keys::Keys;

/// Part of a metadata document.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The object `global`.
    Global,
    /// An object of the list `captures`.
    Capture,
    /// An object of the list `annotations`.
    Annotation,
}

/// Influence of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Influence {
    /// The value is used; what a recording holds is written again.
    Used,
    /// The value is compared with the samples or the other captures, and not written again.
    Checked,
    /// Only one value is accepted.
    Refused,
    /// None: the key is kept.
    Kept,
    /// None: the key is not kept.
    Dropped,
}

/// Suffix of the sample file.
const SAMPLES: &str = ".sigmf-data";
const HASH: &str = "core:sha512";
pub(super) const OFFSET: &str = "core:offset";
pub(crate) const START: &str = "core:sample_start";
pub(crate) const FREQUENCY: &str = "core:frequency";
const DATETIME: &str = "core:datetime";
const EXTENSIONS: &str = "core:extensions";
/// The project's own extension.
const OWN: &str = "stairscan";

/// All keys of SigMF 1.2 with their influence.
pub const KEYS: &[(Part, &str, Influence)] = &[
    (Part::Global, "core:datatype", Influence::Used),
    (Part::Global, "core:sample_rate", Influence::Used),
    (Part::Global, "core:description", Influence::Used),
    (Part::Global, OFFSET, Influence::Used),
    (Part::Capture, START, Influence::Used),
    (Part::Capture, FREQUENCY, Influence::Used),
    (Part::Global, HASH, Influence::Checked),
    (Part::Capture, DATETIME, Influence::Checked),
    (Part::Annotation, START, Influence::Checked),
    (Part::Global, "core:num_channels", Influence::Refused),
    (Part::Global, "core:trailing_bytes", Influence::Refused),
    (Part::Global, "core:metadata_only", Influence::Refused),
    (Part::Global, "core:dataset", Influence::Refused),
    (Part::Global, EXTENSIONS, Influence::Refused),
    (Part::Capture, "core:header_bytes", Influence::Refused),
    (Part::Global, "core:author", Influence::Kept),
    (Part::Global, "core:collection", Influence::Kept),
    (Part::Global, "core:data_doi", Influence::Kept),
    (Part::Global, "core:geolocation", Influence::Kept),
    (Part::Global, "core:hw", Influence::Kept),
    (Part::Global, "core:license", Influence::Kept),
    (Part::Global, "core:meta_doi", Influence::Kept),
    (Part::Global, "core:recorder", Influence::Kept),
    (Part::Global, "core:version", Influence::Dropped),
    (Part::Capture, "core:geolocation", Influence::Dropped),
    (Part::Capture, "core:global_index", Influence::Dropped),
    (Part::Annotation, "core:sample_count", Influence::Dropped),
    (Part::Annotation, "core:freq_lower_edge", Influence::Dropped),
    (Part::Annotation, "core:freq_upper_edge", Influence::Dropped),
    (Part::Annotation, "core:label", Influence::Dropped),
    (Part::Annotation, "core:comment", Influence::Dropped),
    (Part::Annotation, "core:generator", Influence::Dropped),
    (Part::Annotation, "core:uuid", Influence::Dropped),
];

/// Whether a key of `global` describes the original file alone and is not written again.
pub(crate) fn is_of_file(key: &str) -> bool {
    let of_file = |(part, name, influence): &(Part, &str, Influence)| {
        *part == Part::Global
            && *name == key
            && (*influence == Influence::Checked
                || *influence == Influence::Refused
                || *name == OFFSET)
    };
    KEYS.iter().any(of_file) && key != EXTENSIONS
}

/// Checks the standard's keys of a document.
///
/// # Errors
/// Names the key, the value found and the expected value.
pub(crate) fn check(document: &Value) -> Result<()> {
    let global = Keys::of(document.get("global"), "global")?;
    only(&global, "core:num_channels", "1", |v| v.as_u64() == Some(1))?;
    let nothing = "0: a file of nothing but samples";
    only(&global, "core:trailing_bytes", nothing, |v| {
        v.as_f64() == Some(0.0)
    })?;
    only(
        &global,
        "core:metadata_only",
        "false, and a file of samples",
        |v| v == &Value::Bool(false),
    )?;
    let file = format!("the samples in NAME{SAMPLES}");
    only(&global, "core:dataset", &file, |v| {
        v.as_str().is_some_and(|v| v.ends_with(SAMPLES))
    })?;
    only(&global, HASH, "128 hexadecimal digits", |v| {
        v.as_str()
            .is_some_and(|v| v.len() == 128 && v.bytes().all(|b| b.is_ascii_hexdigit()))
    })?;
    only(&global, OFFSET, "a whole number of samples", Value::is_u64)?;
    only(
        &global,
        EXTENSIONS,
        "stairscan or optional ones: others may change what the samples mean",
        |v| other_extensions(v).all(|e| e["optional"] == true),
    )?;
    for (k, capture) in list(document, "captures")?.iter().enumerate() {
        let capture = Keys::of(Some(capture), &format!("captures[{k}]"))?;
        only(&capture, "core:header_bytes", nothing, |v| {
            v.as_f64() == Some(0.0)
        })?;
    }
    in_order(document)
}

fn only(keys: &Keys<'_>, key: &str, expected: &str, ok: impl Fn(&Value) -> bool) -> Result<()> {
    match keys.get(key) {
        Some(value) if !ok(value) => Err(keys.wrong(key, expected)),
        _ => Ok(()),
    }
}

/// Returns the extensions in a document's list other than the project's own.
pub(super) fn other_extensions(list: &Value) -> impl Iterator<Item = &Value> {
    let list = list.as_array().map_or(&[][..], Vec::as_slice);
    list.iter().filter(|e| e["name"] != OWN)
}

/// Returns a document's list of objects; empty without it.
pub(super) fn list<'a>(document: &'a Value, name: &str) -> Result<&'a [Value]> {
    match document.get(name) {
        None => Ok(&[]),
        Some(value) => value
            .as_array()
            .map(Vec::as_slice)
            .ok_or_else(|| anyhow!("{name}: expected a JSON array")),
    }
}

/// Checks that samples and times of the captures go on from one to the next, and those of the annotations not back.
fn in_order(document: &Value) -> Result<()> {
    let (mut start, mut time) = (None, None);
    for (k, capture) in list(document, "captures")?.iter().enumerate() {
        let keys = Keys::of(Some(capture), &format!("captures[{k}]"))?;
        let found = capture[START].as_u64();
        let after = start.is_none_or(|start| found.is_none_or(|found| found > start));
        ensure_after(&keys, START, after, "capture")?;
        start = found.or(start);
        let found = capture[DATETIME].as_str().and_then(comparable);
        let after = time.is_none_or(|time| found.is_none_or(|found| found > time));
        ensure_after(&keys, DATETIME, after, "capture")?;
        time = found.or(time);
    }
    let mut start = None;
    for (k, annotation) in list(document, "annotations")?.iter().enumerate() {
        let keys = Keys::of(Some(annotation), &format!("annotations[{k}]"))?;
        let found = annotation[START].as_u64();
        let after = start.is_none_or(|start| found.is_none_or(|found| found >= start));
        ensure_after(&keys, START, after, "annotation")?;
        start = found.or(start);
    }
    Ok(())
}

fn ensure_after(keys: &Keys<'_>, key: &str, after: bool, what: &str) -> Result<()> {
    match after {
        true => Ok(()),
        false => Err(keys.wrong(key, &format!("one after that of the {what} before"))),
    }
}

/// Returns a time in UTC, `2024-05-01T12:00:00.5Z`, without the end, so that texts sort by time; `None` in another form.
fn comparable(time: &str) -> Option<&str> {
    let time = time.strip_suffix('Z')?;
    let form = b"0000-00-00T00:00:00";
    let is_time = time.len() >= form.len()
        && time.bytes().zip(form).all(|(found, form)| match form {
            b'0' => found.is_ascii_digit(),
            _ => found == *form,
        });
    let time = is_time.then_some(time)?;
    Some(match time.contains('.') {
        true => time.trim_end_matches('0').trim_end_matches('.'),
        false => time,
    })
}

/// Returns the number of samples before the first capture, which belong to none.
///
/// # Errors
/// The first capture begins before the file's first sample.
pub(crate) fn before_first(document: &Value) -> Result<usize> {
    let offset = document["global"][OFFSET].as_u64().unwrap_or(0);
    let Some(start) = document["captures"][0][START].as_u64() else {
        return Ok(0);
    };
    start
        .checked_sub(offset)
        .and_then(|n| usize::try_from(n).ok())
        .ok_or_else(|| {
            anyhow!("captures[0] {START}: found {start}, expected {offset} ({OFFSET}) or more")
        })
}

/// Checks that each capture holds whole chirps of `samples` samples.
///
/// # Errors
/// Names the capture.
pub(crate) fn whole_chirps(document: &Value, samples: usize) -> Result<()> {
    let captures = list(document, "captures")?;
    let starts = captures.iter().map(|c| c[START].as_u64());
    let first = captures
        .first()
        .and_then(|c| c[START].as_u64())
        .unwrap_or(0);
    for (k, start) in starts.enumerate() {
        let apart = start.unwrap_or(first).saturating_sub(first);
        ensure!(
            apart.is_multiple_of(samples.max(1) as u64),
            "captures[{k}] {START}: {apart} samples after the first capture, expected whole chirps of {samples} samples"
        );
    }
    Ok(())
}

/// Compares the samples with the document's checksum, if it has one.
///
/// # Errors
/// They differ.
pub(crate) fn check_hash(document: &Value, data: &[u8]) -> Result<()> {
    let Some(stated) = document["global"][HASH].as_str() else {
        return Ok(());
    };
    let found: String = Sha512::digest(data)
        .iter()
        .map(|b| format!("{b:02x}"))
        .collect();
    ensure!(
        found.eq_ignore_ascii_case(stated),
        "global {HASH}: the samples' checksum is {}…, expected {}…: samples and metadata are not of one recording, or \
         one of them was changed",
        &found[..8],
        stated.get(..8).unwrap_or(stated)
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn refused(document: &Value) -> String {
        check(document).unwrap_err().to_string()
    }

    #[test]
    fn keys_that_change_the_samples_are_refused() {
        for (key, value) in [
            ("core:num_channels", json!(2)),
            ("core:trailing_bytes", json!(4)),
            ("core:metadata_only", json!(true)),
            ("core:dataset", json!("radar.bin")),
            ("core:sha512", json!("…")),
            ("core:offset", json!(-1)),
            (
                "core:extensions",
                json!([{"name": "antenna", "optional": false}]),
            ),
        ] {
            let error = refused(&json!({"global": {key: value}}));
            assert!(
                error.starts_with(&format!("global {key}: found")),
                "{error}"
            );
        }
        let header = json!({"global": {}, "captures": [{}, {"core:header_bytes": 8}]});
        assert!(refused(&header).starts_with("captures[1] core:header_bytes: found 8"));
        let good = json!({"global": {
            "core:num_channels": 1, "core:trailing_bytes": 0, "core:metadata_only": false,
            "core:dataset": "x.sigmf-data", "core:author": "A", "core:offset": 9,
            "core:extensions": [{"name": "antenna", "optional": true}, {"name": "stairscan", "optional": false}],
        }});
        check(&good).unwrap();
    }

    #[test]
    fn samples_and_times_go_on() {
        let captures = |key: &str, values: [Value; 3]| {
            let list: Vec<_> = values.into_iter().map(|v| json!({key: v})).collect();
            json!({"global": {}, "captures": list})
        };
        let times = |values: [&str; 3]| captures(DATETIME, values.map(Value::from));
        let at = |second: &str| format!("2024-05-01T12:00:{second}Z");
        let [a, b, c] = ["09", "09.5", "10.25"].map(at);
        check(&times([&a, &b, &c])).unwrap();
        for wrong in [[&a, &c, &b], [&a, &b, &b], [&a, &b, &at("09.500")]] {
            let error = refused(&times(wrong.map(|t| t.as_str())));
            assert!(
                error.starts_with("captures[2] core:datetime: found"),
                "{error}"
            );
        }
        check(&captures(START, [json!(0), json!(200), json!(400)])).unwrap();
        let error = refused(&captures(START, [json!(0), json!(200), json!(200)]));
        assert!(
            error.starts_with("captures[2] core:sample_start: found 200"),
            "{error}"
        );
        let annotations = |starts: [u64; 2]| json!({"global": {}, "annotations": starts.map(|s| json!({START: s}))});
        check(&annotations([7, 7])).unwrap();
        let error = refused(&annotations([7, 6]));
        assert!(
            error.starts_with("annotations[1] core:sample_start: found 6"),
            "{error}"
        );
    }

    #[test]
    fn the_document_shows_the_table() {
        let text = include_str!("../../../docs/user/formats.md");
        for (part, key, influence) in KEYS {
            let part = match part {
                Part::Global => "`global`",
                Part::Capture => "`captures`",
                Part::Annotation => "`annotations`",
            };
            let start = format!("| {influence:?} | {part} |").to_lowercase();
            let short = key.trim_start_matches("core:");
            let row = text.lines().find(|line| line.starts_with(&start));
            let row = row.unwrap_or_else(|| panic!("no row {start}"));
            assert!(row.contains(&format!("`{short}`")), "{key} is not in {row}");
        }
    }
}
