//! CSV files (RFC 4180) of steps, answers, guard sweeps, echoes or map cells, with a heading.

use anyhow::{Result, bail};
use clap::ValueEnum;
use serde_json::Value;

use super::scans::{SECOND_NS, Scan};
use crate::guarded::Guarded;

/// What a table holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Table {
    /// One row per step; a scan without steps has one row with empty columns of the step
    #[default]
    Steps,
    /// One row per answer, with its time and the number of its steps
    Answers,
    /// One row per guard sweep of a log, with its time
    Sweeps,
    /// One row per echo
    Echoes,
    /// One row per cell of the polar map
    Map,
}

/// Columns that the rows of every table begin with, with the keys of `replay --format json`; echoes and cells have
/// only the first two.
pub const SCAN: [&str; 6] = [
    "recording",
    "scan",
    "status",
    "direction",
    "horizon_m",
    "confidence",
];
/// Columns of an answer that follow those of its scan.
const ANSWER: [&str; 4] = ["lost_rows", "reasons", "steps", "maybes"];
/// Columns of a step, with the keys of `replay --format json`.
const STEP: [&str; 7] = [
    "distance_m",
    "height_m",
    "tread_m",
    "riser_m",
    "distance_sigma_m",
    "height_sigma_m",
    "quality",
];
/// Columns of a scan that follow those of a step: free distance and drop.
const GROUND: [&str; 5] = [
    "free_m",
    "drop_distance_m",
    "drop_distance_sigma_m",
    "drop_depth_m",
    "drop_probability",
];
/// Columns of an echo, with the keys of `inspect --format json`.
const ECHO: [&str; 10] = [
    "x_m",
    "y_m",
    "range_m",
    "range_sigma_m",
    "angle_deg",
    "angle_sigma_deg",
    "snr_db",
    "width",
    "role",
    "against",
];
/// Columns of a guard sweep.
const SWEEP: [&str; 8] = [
    "time_s",
    "recording",
    "sweep",
    "status",
    "free_m",
    "ending",
    "confidence",
    "reasons",
];
/// Columns of a map cell.
const CELL: [&str; 7] = [
    "row",
    "angle_deg",
    "range_m",
    "distance_m",
    "height_m",
    "power_dbfs",
    "detected",
];

/// Formats a value as a table cell: a number as in JSON, text without quotes, nothing for null.
fn cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

fn pick(value: &Value, keys: &[&str]) -> Vec<String> {
    keys.iter().map(|key| cell(&value[*key])).collect()
}

/// Returns the CSV file with a table of these scans.
///
/// # Errors
/// The table is of guard sweeps, which [`sweeps`] writes.
pub fn write<'a>(scans: impl IntoIterator<Item = &'a Scan>, table: Table) -> Result<Vec<u8>> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    match table {
        Table::Steps => csv.write_record(
            SCAN.iter()
                .chain(&["reasons", "step"])
                .chain(&STEP)
                .chain(&GROUND)
                .chain(&["time_s"]),
        )?,
        Table::Answers => {
            csv.write_record(["time_s"].iter().chain(&SCAN).chain(&ANSWER).chain(&GROUND))?;
        }
        Table::Sweeps => bail!("--table sweeps: expected guard sweeps, found scans"),
        Table::Echoes => csv.write_record(SCAN[..2].iter().chain(&ECHO))?,
        Table::Map => csv.write_record(SCAN[..2].iter().chain(&CELL))?,
    }
    for scan in scans {
        let rows = match table {
            Table::Steps => steps(scan),
            Table::Answers => vec![answer(scan)],
            Table::Echoes => {
                let echoes = scan.echoes.as_deref().unwrap_or_default();
                echoes.iter().map(|echo| pick(echo, &ECHO)).collect()
            }
            Table::Map => cells(scan),
            Table::Sweeps => Vec::new(),
        };
        let head = match table {
            Table::Steps => pick(&scan.json, &SCAN),
            Table::Answers => Vec::new(),
            _ => pick(&scan.json, &SCAN[..2]),
        };
        for row in rows {
            csv.write_record(head.iter().chain(&row))?;
        }
    }
    Ok(csv.into_inner()?)
}

/// Returns the CSV file of guard sweeps, each with its time, ns.
///
/// # Errors
/// None: writing to memory does not fail.
pub fn sweeps(sweeps: &[(u64, Guarded)]) -> Result<Vec<u8>> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    csv.write_record(SWEEP)?;
    for (stamp_ns, sweep) in sweeps {
        let json = sweep.json();
        csv.write_record([
            seconds(*stamp_ns),
            cell(&json["recording"]),
            cell(&json["guard"]),
            cell(&json["status"]),
            cell(&json["free_m"]),
            cell(&json["what"]),
            cell(&json["confidence"]),
            words(&json["reasons"]),
        ])?;
    }
    Ok(csv.into_inner()?)
}

/// Returns the row of a scan's answer.
fn answer(scan: &Scan) -> Vec<String> {
    let count = |key: &str| scan.json[key].as_array().map_or(0, Vec::len).to_string();
    let time_s = time_s(scan);
    let counts = vec![
        cell(&scan.json["lost_rows"]),
        reasons(scan),
        count("steps"),
        count("maybe"),
    ];
    let head = vec![time_s].into_iter().chain(pick(&scan.json, &SCAN));
    head.chain(counts).chain(ground(scan)).collect()
}

/// Returns the time of a scan's answer, s.
fn time_s(scan: &Scan) -> String {
    seconds(scan.stamp_ns)
}

/// Formats a time as seconds.
fn seconds(stamp_ns: u64) -> String {
    format!("{:.3}", stamp_ns as f64 / SECOND_NS as f64)
}

/// Returns the reasons of a scan's answer, separated by spaces.
fn reasons(scan: &Scan) -> String {
    words(&scan.json["reasons"])
}

/// Formats a list of words, separated by spaces.
fn words(list: &Value) -> String {
    let list = list.as_array().map_or(&[][..], Vec::as_slice);
    list.iter().map(cell).collect::<Vec<_>>().join(" ")
}

/// Returns the cells of [`GROUND`].
fn ground(scan: &Scan) -> [String; 5] {
    GROUND.map(|key| match key.strip_prefix("drop_") {
        Some(key) => cell(&scan.json["drop"][key]),
        None => cell(&scan.json[key]),
    })
}

fn steps(scan: &Scan) -> Vec<Vec<String>> {
    let reasons = reasons(scan);
    let ground: Vec<String> = ground(scan).into_iter().chain([time_s(scan)]).collect();
    let steps = scan.json["steps"].as_array().cloned().unwrap_or_default();
    let row = |(k, step): (usize, &Value)| {
        let number = [reasons.clone(), (k + 1).to_string()];
        let step = number.into_iter().chain(pick(step, &STEP));
        step.chain(ground.clone()).collect()
    };
    if steps.is_empty() {
        let nothing = vec![String::new(); 1 + STEP.len()];
        return vec![[vec![reasons], nothing, ground].concat()];
    }
    steps.iter().enumerate().map(row).collect()
}

fn cells(scan: &Scan) -> Vec<Vec<String>> {
    let row = |c: &super::scans::Cell| {
        vec![
            c.row.to_string(),
            c.angle_deg.to_string(),
            c.range_m.to_string(),
            c.place.0.to_string(),
            c.place.1.to_string(),
            c.power_db.to_string(),
            c.detected.to_string(),
        ]
    };
    scan.cells.iter().map(row).collect()
}
