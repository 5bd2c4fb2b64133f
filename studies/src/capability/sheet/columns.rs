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
        Some(k) => format!("{:.2} s", seconds(k)),
        None => format!("> {:.2} s", seconds(SWEEPS)),
    }
}

/// Headings of the columns that every table of detection has after its first ones.
const COLUMNS: [&str; 6] = [
    "scan detects",
    "scan `ok` and free beyond",
    "guard detects",
    "guard `ok` and free beyond",
    "guard, median",
    "guard, 95 %",
];

/// Returns one row's texts for the columns [`COLUMNS`].
fn columns(tally: &Tally, times: &Times) -> [String; 6] {
    [
        detected(tally.scan.detected),
        wrong(tally.scan.free_beyond_body),
        detected(tally.guard.detected),
        wrong(tally.guard.free_beyond_body),
        response(tally, 0.5, times),
        response(tally, 0.95, times),
    ]
}

/// Returns a table with the columns `first`, followed by those of detection, misses and response times. Each of `lines`
/// is a row: the texts of its first columns, and its counts.
pub fn table<'a>(
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
    }
}
