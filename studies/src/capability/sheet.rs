//! The data sheet: measured cells in, a document out.

use super::body::Body;
use super::document::Part;
use super::figures;
use super::plan::{Cell, Series};
use super::results::Measured;
use super::tally::Tally;
use columns::Form;

mod columns;
mod others;
mod sizes;
mod words;

pub use words::head;

/// Returns the headings, texts, tables and drawings of the whole sheet, in order.
pub fn parts(measured: &Measured) -> Vec<Part> {
    [
        head(&measured.head),
        reference_table(measured),
        sizes::smallest(measured),
        sizes::every_size(measured),
        sizes::with_loss(measured),
        bounds(measured),
        bodies(measured),
        others::driven(measured),
        others::level(measured),
        others::second(measured),
        words::limits(),
    ]
    .concat()
}

/// Returns the section with one row for each body under the reference condition; empty if none was measured.
fn reference_table(measured: &Measured) -> Vec<Part> {
    let lines: Vec<(Body, Tally)> = Body::STANDARD
        .into_iter()
        .filter_map(|body| Some((body, measured.reference(body)?)))
        .collect();
    if lines.is_empty() {
        return Vec::new();
    }
    let rows = lines.iter().map(|(body, tally)| (vec![body.name()], tally));
    let table = columns::table(&["body at 1 m"], rows, &measured.head.times, Form::Bound);
    vec![
        Part::Heading(2, "At a glance".into()),
        Part::Text(words::REFERENCE.into()),
        Part::Table(table),
    ]
}

/// Returns the section that gives the bounds of the counts in the tables that follow; empty if no condition was changed.
fn bounds(measured: &Measured) -> Vec<Part> {
    let changed = |(cell, _): &&(Cell, Tally)| cell.series == Series::Distance;
    let Some((cell, _)) = measured.cells.iter().find(changed) else {
        return Vec::new();
    };
    vec![
        Part::Heading(2, "One condition changed".into()),
        Part::Text(words::CHANGED.into()),
        Part::Table(columns::bounds(cell.scenes)),
    ]
}

/// Returns a section for each measured body: heading, drawing and table.
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
                let cells = measured.series(series, body).into_iter();
                cells.map(move |(cell, tally)| {
                    let name = format!("{} {}", series.name(), cell.value());
                    (vec![name], tally.clone())
                })
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
                    "{}: detected, and `ok` with free ground beyond",
                    body.name()
                ),
                svg: figures::of(measured, body),
            },
            Part::Table(columns::table(
                &["changed"],
                rows,
                &measured.head.times,
                Form::Counts,
            )),
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
