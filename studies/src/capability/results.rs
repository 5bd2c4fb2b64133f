//! Results: the counts of all cells, with lookup for the sheet and its drawings, and as JSON.

use serde_json::{Value, json};

use host_sim::seeds::Draw;

use super::body::Body;
use super::condition::{Condition, WET};
use super::plan::{Cell, Series, ground_name};
use super::tally::Tally;

/// Durations of scan and guard sweep by the timing model, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Times {
    /// Time from a full scan's first row to the end of its report, seconds.
    pub scan_s: f64,
    /// Time from the start of one guard sweep to that of the next, seconds.
    pub sweep_s: f64,
}

/// Head of the capability sheet: its command, its draw of seeds, and the scanner's durations.
#[derive(Clone, Debug)]
pub struct Heading {
    /// The command that makes the sheet.
    pub command: String,
    /// The draw from which the scenes' seeds are.
    pub draw: Draw,
    /// Durations of the scanner's scan and guard sweep.
    pub times: Times,
}

/// All results of the capability sheet.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Head of the sheet.
    pub head: Heading,
    /// Cells with their counts on the head's draw.
    pub cells: Vec<(Cell, Tally)>,
    /// Cells with their counts on a second draw of seeds, by which the first draw's bounds are tested; `None` without
    /// it.
    pub second: Option<Vec<(Cell, Tally)>>,
}

impl Measured {
    /// Returns the cells of a body within a series, with their counts.
    pub fn series(&self, series: Series, body: Body) -> Vec<&(Cell, Tally)> {
        let own = |(cell, _): &&(Cell, Tally)| cell.series == series && cell.body == body;
        self.cells.iter().filter(own).collect()
    }

    /// Returns the counts of a body under the reference condition, all dry grounds together; `None` if it was not
    /// measured.
    pub fn reference(&self, body: Body) -> Option<Tally> {
        let grounds = self.series(Series::Ground, body);
        let dry = grounds
            .iter()
            .filter(|(cell, _)| cell.condition.ground != Some(WET));
        let all: Vec<&Tally> = dry.map(|(_, tally)| tally).collect();
        (!all.is_empty()).then(|| Tally::sum(all))
    }

    /// Returns the counts of a rise or drop at 1 m behind a window with a two-way loss of `loss_db` dB (0 for a clean
    /// one); `None` if it was not measured.
    pub fn size(&self, body: Body, loss_db: f64) -> Option<&Tally> {
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

    /// Returns the values of the quantity that changes in a series, as text, each with the counts of its cell. Except
    /// for grounds they are in ascending order and include the reference condition.
    pub fn line(&self, series: Series, body: Body) -> Vec<(String, Tally)> {
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

/// Returns the sort key of a cell within its series: its distance, yaw, pitch or window loss; 0 in other series.
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

/// Returns all cells with their conditions and counts as JSON.
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
