//! Sections on drives towards a body, on false alarms, and on the second draw.

use super::super::body::Body;
use super::super::document::{Part, Table};
use super::super::measure::SWEEPS;
use super::super::plan::{Series, ground_name};
use super::super::results::Measured;
use super::super::tally::Tally;
use super::columns::{an_hour, counted, detected, wrong};
use super::words;

/// Returns the section on chairs that drive towards a body; empty if none was measured.
pub fn driven(measured: &Measured) -> Vec<Part> {
    let mut table = Table::new(&[
        "body",
        "speed",
        "guard detects",
        "guard `ok` and free beyond",
        "named by, median",
        "named by, 95 %",
    ]);
    let cm = |at: Option<u32>| at.map_or("later".into(), |cm| format!("{cm} cm"));
    for (cell, tally) in &measured.cells {
        if cell.series == Series::Speed {
            table.rows.push(vec![
                cell.body.name(),
                cell.value(),
                detected(tally.guard.detected),
                wrong(tally.guard.free_beyond_body),
                cm(tally.named_cm(0.5)),
                cm(tally.named_cm(0.95)),
            ]);
        }
    }
    if table.rows.is_empty() {
        return Vec::new();
    }
    vec![
        Part::Heading(2, "Approach".into()),
        Part::Text(words::APPROACH.into()),
        Part::Table(table),
    ]
}

/// Returns the section on false alarms on level ground; empty if none was measured.
pub fn level(measured: &Measured) -> Vec<Part> {
    let mut lines: Vec<(String, Tally)> = Vec::new();
    if let Some(all) = measured.reference(Body::Level) {
        lines.push((ground_name(None).into(), all));
    }
    for series in [Series::Ground, Series::Window] {
        let cells = measured.series(series, Body::Level);
        lines.extend(
            cells
                .iter()
                .map(|(cell, tally)| (cell.value(), tally.clone())),
        );
    }
    if lines.is_empty() {
        return Vec::new();
    }
    let mut table = Table::new(&[
        "level ground",
        "scans with an alarm",
        "alarms an hour, scan",
        "seconds of sweeps with an alarm",
        "alarms an hour, guard",
        "scans `ok`",
        "last sweeps `ok`",
        "scan free short of 1.05 m",
        "guard free short of 1.05 m",
    ]);
    let times = &measured.head.times;
    let second_s = SWEEPS as f64 * times.sweep_s;
    for (name, tally) in &lines {
        let (scan, guard) = (&tally.scan, &tally.guard);
        table.rows.push(vec![
            name.clone(),
            counted(scan.alarm),
            an_hour(scan.alarm, times.scan_s),
            counted(guard.alarm),
            an_hour(guard.alarm, second_s),
            counted(scan.ok),
            counted(guard.ok),
            counted(scan.short),
            counted(guard.short),
        ]);
    }
    vec![
        Part::Heading(2, "False alarms on level ground".into()),
        Part::Text(words::level(times)),
        Part::Table(table),
    ]
}
/// Returns the section that tests the first draw's bounds with the second draw; empty without one.
pub fn second(measured: &Measured) -> Vec<Part> {
    let Some(second) = &measured.second else {
        return Vec::new();
    };
    let (mut broken, mut bounds) = (Vec::new(), 0);
    for (cell, tally) in &measured.cells {
        let Some((_, again)) = second.iter().find(|(other, _)| other.number == cell.number) else {
            continue;
        };
        let (found, of) = tally.contradicted(again);
        bounds += of;
        let name = format!(
            "{}, {} {}",
            cell.body.name(),
            cell.series.name(),
            words::condition(cell)
        );
        broken.extend(found.into_iter().map(|what| format!("{name}: {what}")));
    }
    let mut parts = vec![
        Part::Heading(2, "Second draw".into()),
        Part::Text(words::second(bounds, broken.len())),
    ];
    if !broken.is_empty() {
        parts.push(Part::List(broken));
    }
    parts
}
