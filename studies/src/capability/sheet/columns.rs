//! Table cells of shares with their bounds, response times and rates.

use host_sim::score::Share;

use super::super::document::Table;
use super::super::measure::SWEEPS;
use super::super::results::Times;
use super::super::tally::{Tally, lower, upper};

/// Formats a share of detected bodies with its lower 95 % bound, as `30/30, ≥ 90.5 %`.
pub fn detected(share: Share) -> String {
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

/// Formats a share of wrong answers with its upper 95 % bound, as `0/30, ≤ 9.5 %`.
pub fn wrong(share: Share) -> String {
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

/// Formats the time within which the guard names the body in a fraction `q` (0…1) of the scenes, seconds.
fn response(tally: &Tally, q: f64, times: &Times) -> String {
    let seconds = |k: usize| k as f64 * times.sweep_s;
    match tally.sweeps(q) {
        Some(k) => format!("{:.2}", seconds(k)),
        None => format!("> {:.2}", seconds(SWEEPS)),
    }
}

/// Headings of the columns that every table of detection has after its first ones.
const COLUMNS: [&str; 6] = [
    "scan detects",
    "scan `ok` and free beyond",
    "guard detects",
    "guard `ok` and free beyond",
    "guard, median, s",
    "guard, 95 %, s",
];

/// Form of a share in a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Counts with their bound.
    Bound,
    /// Counts alone, without the guard's 95 % time and without columns of zeros.
    Counts,
}

/// Returns one row's texts for the columns [`COLUMNS`].
fn columns(tally: &Tally, times: &Times, form: Form) -> [String; 6] {
    let [detected, wrong]: [fn(Share) -> String; 2] = match form {
        Form::Bound => [detected, wrong],
        Form::Counts => [counted, counted],
    };
    [
        detected(tally.scan.detected),
        wrong(tally.scan.free_beyond_body),
        detected(tally.guard.detected),
        wrong(tally.guard.free_beyond_body),
        response(tally, 0.5, times),
        response(tally, 0.95, times),
    ]
}

/// Returns the table of the bounds of all counts out of `of` scenes.
pub fn bounds(of: usize) -> Table {
    let mut table = Table::new(&["count", "detected: at least", "free beyond: at most"]);
    let row = |hits| {
        let share = Share::new(hits, of);
        let [lower, upper] = [lower(share), upper(share)].map(|p| format!("{:.1} %", 100.0 * p));
        vec![counted(share), lower, upper]
    };
    table.rows = (0..=of).map(row).collect();
    table
}

/// Returns a table with the columns `first`, followed by those of detection, misses and response times. Each of `lines`
/// is a row: the texts of its first columns, and its counts, which are printed in `form`.
pub fn table<'a>(
    first: &[&str],
    lines: impl Iterator<Item = (Vec<String>, &'a Tally)>,
    times: &Times,
    form: Form,
) -> Table {
    let lines: Vec<(Vec<String>, &Tally)> = lines.collect();
    let free = |of: fn(&Tally) -> Share| lines.iter().any(|(_, tally)| of(tally).hits > 0);
    let all = form == Form::Bound;
    let kept = [
        true,
        all || free(|tally| tally.scan.free_beyond_body),
        true,
        all || free(|tally| tally.guard.free_beyond_body),
        true,
        all,
    ];
    let names = COLUMNS.iter().zip(kept).filter(|(_, kept)| *kept);
    let names: Vec<&str> = names.map(|(name, _)| *name).collect();
    let mut table = Table::new(&[first, &names[..]].concat());
    table.rows = lines
        .iter()
        .map(|(names, tally)| {
            let cells = columns(tally, times, form).into_iter().zip(kept);
            let cells = cells.filter(|(_, kept)| *kept).map(|(cell, _)| cell);
            names.iter().cloned().chain(cells).collect()
        })
        .collect();
    table
}

/// Formats a share as a fraction, `3/120`.
pub fn counted(share: Share) -> String {
    format!("{}/{}", share.hits, share.of)
}

/// Formats the number of alarms an hour, with its upper 95 % bound, as `36, ≤ 92`. `share` is the share of answers with
/// an alarm, `seconds` the duration of one answer.
pub fn an_hour(share: Share, seconds: f64) -> String {
    let rate = |p: f64| 3600.0 * p / seconds;
    format!(
        "{:.0}, ≤ {:.0}",
        rate(share.value().unwrap_or(0.0)),
        rate(upper(share))
    )
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let table = bounds(30);
        assert_eq!(table.rows.len(), 31);
        assert_eq!(table.rows[30], ["30/30", "90.5 %", "100.0 %"]);
        assert_eq!(table.rows[0], ["0/30", "0.0 %", "9.5 %"]);
    }
}
