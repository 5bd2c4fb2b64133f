//! The data sheet: measured cells in, a document and JSON out.

use serde_json::{Value, json};

use crate::score::Share;
use crate::seeds::Draw;

use super::body::Body;
use super::condition::{Condition, WET};
use super::document::{Part, Table};
use super::figures;
use super::measure::SWEEPS;
use super::plan::{Cell, LOSSES_DB, Series, ground_name, sizes};
use super::tally::{Tally, lower, upper};

mod words;

pub use words::head;

/// Share that a size must be detected in, and that behind a window that costs something.
const SHARES: [f64; 2] = [0.99, 0.90];

/// Times of the timing model, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Times {
    /// From a full scan's first row to the end of its report.
    pub scan_s: f64,
    /// From one guard sweep to the next.
    pub sweep_s: f64,
}

/// What the head of a sheet says.
#[derive(Clone, Debug)]
pub struct Heading {
    /// The command that makes it.
    pub command: String,
    /// The draw.
    pub draw: Draw,
    /// Times of the scanner.
    pub times: Times,
}

/// All that was measured.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Head of the sheet.
    pub head: Heading,
    /// Cells with their counts.
    pub cells: Vec<(Cell, Tally)>,
    /// The same of a second draw.
    pub second: Option<Vec<(Cell, Tally)>>,
}

impl Measured {
    /// Cells of a body within a series.
    pub(super) fn series(&self, series: Series, body: Body) -> Vec<&(Cell, Tally)> {
        let own = |(cell, _): &&(Cell, Tally)| cell.series == series && cell.body == body;
        self.cells.iter().filter(own).collect()
    }

    /// Counts of a body under the reference condition: all dry grounds together.
    pub(super) fn reference(&self, body: Body) -> Option<Tally> {
        let grounds = self.series(Series::Ground, body);
        let dry = grounds
            .iter()
            .filter(|(cell, _)| cell.condition.ground != Some(WET));
        let all: Vec<&Tally> = dry.map(|(_, tally)| tally).collect();
        (!all.is_empty()).then(|| Tally::sum(all))
    }

    /// Counts of a size behind a window.
    pub(super) fn size(&self, body: Body, loss_db: f64) -> Option<&Tally> {
        let series = match loss_db {
            0.0 => Series::Size,
            _ => Series::SizeAndWindow,
        };
        let cells = self.series(series, body);
        let found = cells
            .iter()
            .find(|(cell, _)| cell.condition.loss_db == loss_db);
        found.map(|(_, tally)| tally)
    }

    /// Values of a series with their counts, the reference condition among them.
    pub(super) fn line(&self, series: Series, body: Body) -> Vec<(String, Tally)> {
        let cells = self.series(series, body);
        let mut line: Vec<(f64, String, Tally)> = cells
            .iter()
            .map(|(cell, tally)| (place(cell), cell.value(), tally.clone()))
            .collect();
        if series != Series::Ground
            && !line.is_empty()
            && let Some(tally) = self.reference(body)
        {
            let cell = Cell {
                number: 0,
                series,
                body,
                condition: Condition::REFERENCE,
                scenes: 0,
            };
            line.push((place(&cell), cell.value(), tally));
            line.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        line.into_iter()
            .map(|(_, value, tally)| (value, tally))
            .collect()
    }
}

/// Where a cell stands in the order of its series.
fn place(cell: &Cell) -> f64 {
    let c = &cell.condition;
    match cell.series {
        Series::Distance => c.distance_m,
        Series::Yaw => c.yaw_deg,
        Series::Pitch => c.pitch_deg,
        Series::Window => c.loss_db,
        _ => 0.0,
    }
}

/// A share of bodies detected, with its lower bound.
fn detected(share: Share) -> String {
    match share.of {
        0 => "–".into(),
        _ => format!(
            "{}/{}, ≥ {:.1} %",
            share.hits,
            share.of,
            100.0 * lower(share)
        ),
    }
}

/// A share of answers that are wrong, with its upper bound.
fn wrong(share: Share) -> String {
    match share.of {
        0 => "–".into(),
        _ => format!(
            "{}/{}, ≤ {:.1} %",
            share.hits,
            share.of,
            100.0 * upper(share)
        ),
    }
}

/// A quantile of the guard's response.
fn response(tally: &Tally, q: f64, times: &Times) -> String {
    let seconds = |k: usize| k as f64 * times.sweep_s;
    match tally.sweeps(q) {
        Some(k) => format!("{:.2} s", seconds(k)),
        None => format!("> {:.2} s", seconds(SWEEPS)),
    }
}

/// The columns of shares of scan and guard.
const COLUMNS: [&str; 6] = [
    "scan detects",
    "scan `ok` and free beyond",
    "guard detects",
    "guard `ok` and free beyond",
    "guard, median",
    "guard, 95 %",
];

fn columns(tally: &Tally, times: &Times) -> [String; 6] {
    [
        detected(tally.scan.detected),
        wrong(tally.scan.beyond),
        detected(tally.guard.detected),
        wrong(tally.guard.beyond),
        response(tally, 0.5, times),
        response(tally, 0.95, times),
    ]
}

/// A table of lines with these columns.
fn table<'a>(
    first: &[&str],
    lines: impl Iterator<Item = (Vec<String>, &'a Tally)>,
    times: &Times,
) -> Table {
    let mut table = Table::new(&[first, &COLUMNS].concat());
    table.rows = lines
        .map(|(names, tally)| [names, columns(tally, times).to_vec()].concat())
        .collect();
    table
}

/// Returns the whole sheet.
pub fn parts(measured: &Measured) -> Vec<Part> {
    [
        head(&measured.head),
        glance(measured),
        smallest(measured),
        every_size(measured),
        bodies(measured),
        driven(measured),
        level(measured),
        second(measured),
    ]
    .concat()
}

/// Each body under the reference condition.
fn glance(measured: &Measured) -> Vec<Part> {
    let lines: Vec<(Body, Tally)> = Body::STANDARD
        .into_iter()
        .filter_map(|body| Some((body, measured.reference(body)?)))
        .collect();
    if lines.is_empty() {
        return Vec::new();
    }
    let rows = lines.iter().map(|(body, tally)| (vec![body.name()], tally));
    let table = table(&["body at 1 m"], rows, &measured.head.times);
    vec![
        Part::Heading(2, "At a glance".into()),
        Part::Text(words::GLANCE.into()),
        Part::Table(table),
    ]
}

/// The smallest rise and drop that are detected in a share of the scenes.
fn smallest(measured: &Measured) -> Vec<Part> {
    let mut table = Table::new(&[
        "body at 1 m",
        "window",
        "scan, 99 %",
        "scan, 90 %",
        "guard, 99 %",
        "guard, 90 %",
    ]);
    for kind in ["rise", "drop"] {
        for loss_db in [0.0].into_iter().chain(LOSSES_DB) {
            let of_kind = sizes().filter(|body| body.kind() == kind);
            let all: Option<Vec<(Body, &Tally)>> = of_kind
                .map(|body| Some((body, measured.size(body, loss_db)?)))
                .collect();
            let Some(all) = all else { continue };
            let cell = |share, scan: bool| {
                // A clean bill of so few scenes shows no more than 90 %.
                let enough = all.iter().all(|(_, t)| {
                    lower(Share::new(t.guard.detected.of, t.guard.detected.of)) >= share
                });
                let of = |t: &Tally| {
                    if scan {
                        t.scan.detected
                    } else {
                        t.guard.detected
                    }
                };
                match enough {
                    true => least(&all, share, of),
                    false => "–".into(),
                }
            };
            let [strict, loose] = SHARES;
            table.rows.push(vec![
                kind.into(),
                format!("{loss_db} dB"),
                cell(strict, true),
                cell(loose, true),
                cell(strict, false),
                cell(loose, false),
            ]);
        }
    }
    if table.rows.is_empty() {
        return Vec::new();
    }
    vec![
        Part::Heading(2, "Smallest rise and drop".into()),
        Part::Text(words::SMALLEST.into()),
        Part::Table(table),
    ]
}

/// The smallest of bodies in order that is, with all larger ones, detected in at least `share`, by its lower bound.
fn least(all: &[(Body, &Tally)], share: f64, of: impl Fn(&Tally) -> Share) -> String {
    let enough = all
        .iter()
        .rev()
        .take_while(|(_, tally)| lower(of(tally)) >= share);
    let size = |body: Body| body.name().split(' ').skip(2).collect::<Vec<_>>().join(" ");
    match (enough.last(), all.last()) {
        (Some((body, _)), _) => size(*body),
        (None, Some((largest, _))) => format!("none up to {}", size(*largest)),
        (None, None) => "–".into(),
    }
}

/// Every size behind every window.
fn every_size(measured: &Measured) -> Vec<Part> {
    let lines: Vec<(Vec<String>, &Tally)> = [0.0]
        .into_iter()
        .chain(LOSSES_DB)
        .flat_map(|loss_db| sizes().map(move |body| (body, loss_db)))
        .filter_map(|(body, loss_db)| {
            let names = vec![body.name(), format!("{loss_db} dB")];
            Some((names, measured.size(body, loss_db)?))
        })
        .collect();
    if lines.is_empty() {
        return Vec::new();
    }
    let table = table(
        &["body at 1 m", "window"],
        lines.into_iter(),
        &measured.head.times,
    );
    vec![
        Part::Heading(2, "Sizes, and what shrinks them".into()),
        Part::Text(words::SIZES.into()),
        Part::Table(table),
    ]
}

/// A section for each body: its drawing and its table.
fn bodies(measured: &Measured) -> Vec<Part> {
    let of = |body: Body| -> Vec<Part> {
        let series = [
            Series::Distance,
            Series::Yaw,
            Series::Pitch,
            Series::Window,
            Series::Ground,
        ];
        let lines: Vec<(Vec<String>, Tally)> = series
            .into_iter()
            .flat_map(|series| {
                let line = measured.line(series, body).into_iter();
                line.map(move |(value, tally)| (vec![series.name().to_owned(), value], tally))
            })
            .collect();
        if lines.is_empty() {
            return Vec::new();
        }
        let rows = lines.iter().map(|(names, tally)| (names.clone(), tally));
        vec![
            Part::Heading(2, capital(&body.name())),
            Part::Figure {
                file: format!("{}.svg", body.kind()),
                alt: format!(
                    "{}: share detected, and `ok` with free ground beyond it, by scan and guard",
                    body.name()
                ),
                svg: figures::of(measured, body),
            },
            Part::Table(table(&["what changes", "to"], rows, &measured.head.times)),
        ]
    };
    Body::STANDARD.into_iter().flat_map(of).collect()
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

/// Chairs that drive towards a body.
fn driven(measured: &Measured) -> Vec<Part> {
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
                wrong(tally.guard.beyond),
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

/// False alarms on level ground.
fn level(measured: &Measured) -> Vec<Part> {
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

fn counted(share: Share) -> String {
    format!("{}/{}", share.hits, share.of)
}

/// Alarms an hour of answers that take `seconds` each, with the upper bound.
fn an_hour(share: Share, seconds: f64) -> String {
    let rate = |p: f64| 3600.0 * p / seconds;
    format!(
        "{:.0}, ≤ {:.0}",
        rate(share.value().unwrap_or(0.0)),
        rate(upper(share))
    )
}

/// Bounds of the first draw on the second one.
fn second(measured: &Measured) -> Vec<Part> {
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

/// Returns every cell as JSON.
pub fn json(measured: &Measured) -> Value {
    let cell = |(cell, tally): &(Cell, Tally)| {
        let c = &cell.condition;
        json!({
            "body": cell.body.name(),
            "series": cell.series.name(),
            "distance_m": c.distance_m,
            "yaw_deg": c.yaw_deg,
            "pitch_deg": c.pitch_deg,
            "loss_db": c.loss_db,
            "ground": ground_name(c.ground),
            "speed_m_s": c.speed,
            "scenes": cell.scenes,
            "counts": tally.json(),
        })
    };
    let cells = |all: &Vec<(Cell, Tally)>| all.iter().map(cell).collect::<Vec<_>>();
    json!({
        "command": measured.head.command,
        "scan_s": measured.head.times.scan_s,
        "sweep_s": measured.head.times.sweep_s,
        "cells": cells(&measured.cells),
        "second": measured.second.as_ref().map(cells),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capability::measure::Seen;
    use crate::capability::outcome::{GuardOutcome, ScanOutcome};

    fn tally(hits: usize, of: usize) -> Tally {
        let seen = |k: usize| Seen {
            scan: Some(ScanOutcome {
                detected: k < hits,
                ..ScanOutcome::default()
            }),
            guard: GuardOutcome::default(),
        };
        Tally::of(&(0..of).map(seen).collect::<Vec<_>>())
    }

    #[test]
    fn the_smallest_size_has_all_larger_ones_with_it() {
        let [full, less] = [tally(300, 300), tally(298, 300)];
        let bodies = [Body::Rise(4), Body::Rise(6), Body::Rise(8)];
        let of = |tallies: [&Tally; 3]| {
            let all: Vec<_> = bodies.into_iter().zip(tallies).collect();
            least(&all, 0.99, |tally| tally.scan.detected)
        };
        assert_eq!(of([&full, &full, &full]), "4 cm");
        assert_eq!(of([&full, &less, &full]), "8 cm");
        assert_eq!(of([&full, &full, &less]), "none up to 8 cm");
    }

    #[test]
    fn alarms_are_a_rate_with_a_bound() {
        assert_eq!(an_hour(Share::new(0, 300), 1.0), "0, ≤ 36");
        assert_eq!(an_hour(Share::new(3, 300), 1.0), "36, ≤ 92");
    }

    #[test]
    fn shares_come_with_their_bounds() {
        assert_eq!(detected(Share::new(30, 30)), "30/30, ≥ 90.5 %");
        assert_eq!(wrong(Share::new(0, 30)), "0/30, ≤ 9.5 %");
        assert_eq!(wrong(Share::default()), "–");
    }
}
