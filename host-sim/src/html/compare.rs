//! Compares two scans on one page: the differences of their answers first, then both views.

use std::cmp::{max, min};

use anyhow::{Context, Result};
use serde_json::{Value, json};

use super::differences::{Difference, between};
use super::scanned;
use super::{LAYERS, Parts, SLIDER, pane};
use crate::answer::Answer;
use crate::recording::Recording;
use crate::replay::Options;
use crate::setting_file::table;

const BODY: &str = include_str!("compare.html");
const SCRIPT: &str = include_str!("compare.js");

/// One of the two scans or recordings that are compared.
#[derive(Clone, Debug)]
pub struct Side {
    /// Name of this side on the page.
    pub name: String,
    /// The recording, with the settings of this side instead of its own.
    pub recording: Recording,
    /// Options of the replay, such as estimator and seed.
    pub options: Options,
}

/// Result of a comparison: page and differences.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Content of the HTML page.
    pub page: String,
    /// Rows of the table of differences; empty if the answers are equal.
    pub differences: Vec<Difference>,
}

/// Compares two sides.
///
/// # Errors
/// A recording cannot be scanned; the message names the cause.
pub fn compare(sides: &[Side; 2]) -> Result<Comparison> {
    let scan = |side: &Side| {
        let (mut entry, answers) = scanned(&side.recording, &side.options)?;
        entry.data["name"] = json!(side.name);
        anyhow::Ok((entry.data, answers))
    };
    let [first, second] = sides;
    let ((a, first), (b, second)) = (scan(first)?, scan(second)?);
    let differences = of_all(&first, &second);
    let rows: Vec<Value> = differences.iter().map(Difference::json).collect();
    let settings = settings(&a["settings"], &b["settings"]);
    let data = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "revision": stairscan::REVISION,
        "compare": {"rows": rows, "settings": settings},
        "recordings": [a, b],
    });
    let panes = ["-a", "-b"].map(|suffix| pane(suffix, "", ""));
    let body = BODY
        .replace("{{slider}}", SLIDER)
        .replace("{{layers}}", LAYERS)
        .replace("{{panes}}", &panes.concat());
    let title = sides.each_ref().map(|side| side.name.as_str());
    let parts = Parts {
        title: &format!("{} – stairscan", title.join(" beside ")),
        body: &body,
        data: &serde_json::to_string(&data).context("the page's data")?,
        script: SCRIPT,
        ..Parts::default()
    };
    Ok(Comparison {
        page: parts.filled(),
        differences,
    })
}

/// Returns the differences of two lists of answers, scan by scan; first the number of scans if that
/// differs.
fn of_all(first: &[Answer], second: &[Answer]) -> Vec<Difference> {
    let counts = (first.len(), second.len());
    let several = max(counts.0, counts.1) > 1;
    let mut rows = Vec::new();
    if counts.0 != counts.1 {
        rows.push(Difference {
            what: "number of scans".to_owned(),
            first: counts.0.to_string(),
            second: counts.1.to_string(),
            ..Difference::default()
        });
    }
    for k in 0..min(counts.0, counts.1) {
        let scan = several.then_some(k + 1);
        let of_scan = between(&first[k], &second[k]).into_iter();
        rows.extend(of_scan.map(|row| Difference { scan, ..row }));
    }
    rows
}

/// Returns the settings that differ between two scans: key, first value, second value, both with
/// units.
fn settings(first: &Value, second: &Value) -> Vec<[String; 3]> {
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let spoken = |pair: &Value| {
        let text = |k: usize| pair[k].as_str().unwrap_or_default().to_owned();
        let (key, value) = (text(0), text(1));
        let value = table::row(&key).map_or(value.clone(), |row| row.with_unit(&value));
        (key, value)
    };
    let second = list(second);
    let pairs = list(first).into_iter().zip(second);
    let differing = pairs.filter(|(a, b)| a != b);
    differing
        .map(|(a, b)| {
            let ((key, a), (_, b)) = (spoken(&a), spoken(&b));
            [key, a, b]
        })
        .collect()
}
