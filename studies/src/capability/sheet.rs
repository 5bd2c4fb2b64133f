//! The data sheet: measured cells in, a document out.

use super::body::Body;
use super::document::Part;
use super::figures;
use super::plan::Series;
use super::results::Measured;
use super::tally::Tally;

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
    let table = columns::table(&["body at 1 m"], rows, &measured.head.times);
    vec![
        Part::Heading(2, "At a glance".into()),
        Part::Text(words::REFERENCE.into()),
        Part::Table(table),
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
            Part::Table(columns::table(
                &["changed condition", "to"],
                rows,
                &measured.head.times,
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
