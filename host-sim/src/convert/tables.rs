//! CSV (RFC 4180): steps, echoes, or the cells of the map, a heading first.

use anyhow::Result;
use clap::ValueEnum;
use serde_json::Value;

use super::scans::Scan;

/// What a table holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Table {
    /// A row a step; a scan without steps has one row with nothing in the step's columns
    #[default]
    Steps,
    /// A row an echo
    Echoes,
    /// A row a cell of the polar map
    Map,
}

/// The keys of the columns that a scan's rows have in common, as `replay --format json` names them.
pub(super) const SCAN: [&str; 6] = [
    "recording",
    "scan",
    "status",
    "direction",
    "horizon_m",
    "confidence",
];
/// Those of a step.
const STEP: [&str; 7] = [
    "distance_m",
    "height_m",
    "tread_m",
    "riser_m",
    "distance_sigma_m",
    "height_sigma_m",
    "quality",
];
/// Those of a scan that stand behind a step's: what is free, and where the ground ends.
const GROUND: [&str; 5] = [
    "free_m",
    "drop_distance_m",
    "drop_distance_sigma_m",
    "drop_depth_m",
    "drop_probability",
];
/// Those of an echo, as `inspect --format json` names them.
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
/// Those of a cell.
const CELL: [&str; 7] = [
    "row",
    "angle_deg",
    "range_m",
    "distance_m",
    "height_m",
    "power_dbfs",
    "detected",
];

/// A value as a cell: a number as JSON writes it, text without quotes, nothing for nothing.
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

/// The table of these scans.
///
/// # Errors
/// None that writing to memory can bring about.
pub fn write<'a>(scans: impl IntoIterator<Item = &'a Scan>, table: Table) -> Result<Vec<u8>> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    match table {
        Table::Steps => csv.write_record(
            SCAN.iter()
                .chain(&["reasons", "step"])
                .chain(&STEP)
                .chain(&GROUND),
        )?,
        Table::Echoes => csv.write_record(SCAN[..2].iter().chain(&ECHO))?,
        Table::Map => csv.write_record(SCAN[..2].iter().chain(&CELL))?,
    }
    for scan in scans {
        let rows = match table {
            Table::Steps => steps(scan),
            Table::Echoes => {
                let echoes = scan.echoes.as_deref().unwrap_or_default();
                echoes.iter().map(|echo| pick(echo, &ECHO)).collect()
            }
            Table::Map => cells(scan),
        };
        let head = match table {
            Table::Steps => pick(&scan.told, &SCAN),
            _ => pick(&scan.told, &SCAN[..2]),
        };
        for row in rows {
            csv.write_record(head.iter().chain(&row))?;
        }
    }
    Ok(csv.into_inner()?)
}

fn steps(scan: &Scan) -> Vec<Vec<String>> {
    let list = |key: &str| scan.told[key].as_array().cloned().unwrap_or_default();
    let reasons: Vec<String> = list("reasons").iter().map(cell).collect();
    let reasons = reasons.join(" ");
    let steps = list("steps");
    let ground = GROUND.map(|key| match key.strip_prefix("drop_") {
        Some(key) => cell(&scan.told["drop"][key]),
        None => cell(&scan.told[key]),
    });
    let row = |(k, step): (usize, &Value)| {
        let number = [reasons.clone(), (k + 1).to_string()];
        let step = number.into_iter().chain(pick(step, &STEP));
        step.chain(ground.clone()).collect()
    };
    if steps.is_empty() {
        let nothing = vec![String::new(); 1 + STEP.len()];
        return vec![[vec![reasons], nothing, ground.to_vec()].concat()];
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
