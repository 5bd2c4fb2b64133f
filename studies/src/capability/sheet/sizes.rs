//! Sections on the smallest detected rise and drop, and on every size behind every window.

use host_sim::score::Share;

use super::super::body::Body;
use super::super::document::{Part, Table};
use super::super::plan::{LOSSES_DB, sizes};
use super::super::results::Measured;
use super::super::tally::{Counts, Tally, lower};
use super::columns::{Form, counted, table};
use super::words;

/// Probabilities of detection for which the smallest size is listed: the requirement, and one for which the number of
/// scenes behind windows with loss is sufficient.
const SHARES: [f64; 2] = [0.99, 0.90];

/// Returns the section on the smallest rise and drop that are detected with a probability of 99 %, and of 90 %.
pub fn smallest(measured: &Measured) -> Vec<Part> {
    let mut table = Table::new(&[
        "body at 1 m",
        "window",
        "scan, 99 %",
        "scan, 90 %",
        "guard, 99 %",
        "guard, 90 %",
        "scan not beyond, 99 %",
        "guard not beyond, 99 %",
    ]);
    for kind in ["rise", "drop"] {
        for loss_db in [0.0].into_iter().chain(LOSSES_DB) {
            let of_kind = sizes().filter(|body| body.kind() == kind);
            let all: Option<Vec<(Body, &Tally)>> = of_kind
                .map(|body| Some((body, measured.size(body, loss_db)?)))
                .collect();
            let Some(all) = all else { continue };
            let cell = |share: f64, of: fn(&Tally) -> Share| match shows(&all, share) {
                true => least(&all, share, of),
                false => "–".into(),
            };
            let [strict, loose] = SHARES;
            let cells = [
                cell(strict, |t| t.scan.detected),
                cell(loose, |t| t.scan.detected),
                cell(strict, |t| t.guard.detected),
                cell(loose, |t| t.guard.detected),
                cell(strict, |t| not_beyond(&t.scan)),
                cell(strict, |t| not_beyond(&t.guard)),
            ];
            if cells.iter().any(|cell| cell != "–") {
                let names = [kind.into(), format!("{loss_db} dB")];
                table.rows.push([&names[..], &cells[..]].concat());
            }
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

/// Returns the number of scenes, of all, without an answer that is `ok` with free ground beyond the body.
fn not_beyond(counts: &Counts) -> Share {
    Share::new(
        counts.free_beyond_body.of - counts.free_beyond_body.hits,
        counts.free_beyond_body.of,
    )
}

/// Whether each body has enough scenes to show a probability of at least `share`: whether the lower 95 % bound would
/// reach it if all scenes were successes.
fn shows(all: &[(Body, &Tally)], share: f64) -> bool {
    let full = |tally: &Tally| Share::new(tally.guard.detected.of, tally.guard.detected.of);
    all.iter().all(|(_, tally)| lower(full(tally)) >= share)
}

/// Returns, as text, the size of the smallest body for which, as for all larger ones, the lower 95 % bound of the share
/// that `of` selects (such as scans that detect the body) is at least `share`. `all` are the bodies by ascending size.
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

/// Returns the section with the counts of every rise and drop behind a clean window; empty if none was measured.
pub fn every_size(measured: &Measured) -> Vec<Part> {
    let lines: Vec<(Vec<String>, &Tally)> = sizes()
        .filter_map(|body| Some((vec![body.name()], measured.size(body, 0.0)?)))
        .collect();
    if lines.is_empty() {
        return Vec::new();
    }
    let times = &measured.head.times;
    let table = table(&["body at 1 m"], lines.into_iter(), times, Form::Bound);
    vec![
        Part::Heading(2, "Detection by size".into()),
        Part::Text(words::SIZES.into()),
        Part::Table(table),
    ]
}

/// Returns the section with the counts of every rise and drop behind windows with loss; empty if none was measured.
pub fn with_loss(measured: &Measured) -> Vec<Part> {
    let cell = |tally: &Tally| {
        let of = |counts: &Counts| {
            let [detected, free] = [counts.detected, counts.free_beyond_body].map(counted);
            format!("{detected}, {free}")
        };
        format!("{}; {}", of(&tally.scan), of(&tally.guard))
    };
    let row = |body: Body| -> Option<Vec<String>> {
        let behind = |loss_db| Some(cell(measured.size(body, loss_db)?));
        let cells: Option<Vec<String>> = LOSSES_DB.into_iter().map(behind).collect();
        Some([vec![body.name()], cells?].concat())
    };
    let rows: Vec<Vec<String>> = sizes().filter_map(row).collect();
    if rows.is_empty() {
        return Vec::new();
    }
    let losses = LOSSES_DB.map(|loss_db| format!("{loss_db} dB"));
    let head = [&["body at 1 m".to_owned()][..], &losses[..]].concat();
    vec![
        Part::Heading(2, "Detection behind a window with loss".into()),
        Part::Text(words::LOSSES.into()),
        Part::Table(Table { head, rows }),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capability::measure::SceneOutcome;
    use crate::capability::outcome::{GuardOutcome, ScanOutcome};

    fn tally(hits: usize, of: usize) -> Tally {
        let seen = |k: usize| SceneOutcome {
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
}
