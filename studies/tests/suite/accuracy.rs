//! Tests of the accuracy tables: they use seeds that are not used for tuning, and the figures that
//! CI measures at every change equal the committed ones, so that every change of accuracy shows in a
//! diff.

use host_sim::random::Kind;
use host_sim::seeds::{Draw, REPORTING, TUNING};
use studies::commands::accuracy::{self, Selection};
use studies::instrument::Instrument;

use crate::common::study;

/// The committed snapshot.
const SNAPSHOT: &str = include_str!("accuracy-snapshot.md");
/// The published tables.
const PUBLISHED: &str = include_str!("../../../docs/generated/accuracy.md");

#[test]
fn accuracy_is_as_committed() {
    let scenes_own = &Instrument::default();
    let rows = accuracy::measure(&Selection::of(Draw::Snapshot), scenes_own).unwrap();
    let measured = accuracy::report(&Selection::of(Draw::Snapshot), scenes_own, &rows);
    assert!(
        measured == SNAPSHOT,
        "accuracy has changed; if that is meant: sh docs/make snapshot, and at the end sh docs/make \
         accuracy\n\ncommitted:\n{SNAPSHOT}\n\
         measured:\n{measured}"
    );
}

/// The published tables take too long to measure again here. The test checks that they are those of
/// the reporting seeds, and of all of them.
#[test]
fn the_published_tables_are_those_of_the_reporting_seeds() {
    let heading = accuracy::heading(&Selection::of(Draw::Reporting), &Instrument::default());
    assert!(
        PUBLISHED.starts_with(&heading),
        "docs/generated/accuracy.md was not made by `cargo study accuracy --draw reporting`, whose output \
         begins with:\n{heading}"
    );
    let first = PUBLISHED.lines().skip_while(|line| !line.starts_with('|'));
    let table: Vec<&str> = first.take_while(|line| line.starts_with('|')).collect();
    assert_eq!(table.len(), 2 + Kind::ALL.len());
    // "ok and wrong" of a row: "WRONG/OK: …", or a dash where nothing is ok.
    let counts = table[2..].iter().filter_map(|row| {
        let share = row.split('|').nth(9)?.split(':').next()?;
        let (wrong, ok) = share.trim().split_once('/')?;
        Some((wrong.parse::<u32>().ok()?, ok.parse::<u32>().ok()?))
    });
    let (wrong, ok) = counts.fold((0, 0), |sum, row| (sum.0 + row.0, sum.1 + row.1));
    let promise = format!("of {ok} `ok` answers to reporting seeds {wrong} were wrong");
    for (file, text) in [
        ("README.md", include_str!("../../../README.md")),
        (
            "docs/user/report.md",
            include_str!("../../../docs/user/report.md"),
        ),
    ] {
        let words: Vec<&str> = text.split_whitespace().collect();
        assert!(
            words.join(" ").contains(&promise),
            "{file} does not say: {promise}"
        );
    }
}

#[test]
fn no_seed_serves_two_draws() {
    for (k, a) in Draw::ALL.into_iter().enumerate() {
        for b in &Draw::ALL[k + 1..] {
            let (one, other) = (a.seeds(), b.seeds());
            assert!(
                one.end <= other.start || other.end <= one.start,
                "the draws {a} ({one:?}) and {b} ({other:?}) overlap"
            );
        }
        for kind in Kind::ALL {
            let seeds = a.seeds();
            assert!(
                a.scenes(kind) <= seeds.end - seeds.start,
                "the draw {a} has fewer seeds than {kind} scenes"
            );
        }
    }
    // The seeds that tables and fits used before the seeds were allocated to draws.
    assert!(TUNING.contains(&0) && TUNING.contains(&200_000));
    assert_eq!(Draw::Reporting.seeds(), REPORTING);
}

#[test]
fn scenes_for_reporting_are_not_shown() {
    let out = study(&["accuracy", "--draw", "reporting", "--list"]);
    let message = String::from_utf8(out.stderr).unwrap();
    assert_eq!(out.status.code(), Some(1), "{message}");
    assert!(
        out.stdout.is_empty() && message.contains("--draw tuning"),
        "{message}"
    );
    let out = study(&["accuracy", "--draw", "tuning", "--scenes", "1", "--list"]);
    let one = Selection {
        scenes: Some(1),
        ..Selection::of(Draw::Tuning)
    };
    let text = String::from_utf8(out.stdout).unwrap();
    assert_eq!(out.status.code(), Some(0));
    assert!(
        text.starts_with(&accuracy::heading(&one, &Instrument::default())),
        "{text}"
    );
}

#[test]
fn a_table_may_hold_some_kinds_only() {
    let out = study(&[
        "accuracy", "--draw", "tuning", "--scenes", "1", "--kind", "kerb", "--kind", "none",
    ]);
    let text = String::from_utf8(out.stdout).unwrap();
    assert!(
        text.contains("--scenes 1 --kind kerb --kind none"),
        "{text}"
    );
    assert!(text.contains("| kerb |") && !text.contains("| ascending |"));
}

/// Every kind with its reliability, and the total.
#[test]
fn figures_come_as_json_too() {
    let args = ["accuracy", "--draw", "tuning", "--scenes", "1"];
    let out = study(&[&args[..], &["--format", "json"]].concat());
    assert_eq!(out.status.code(), Some(0));
    let json: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    let likelihood = &json["estimators"][0];
    assert_eq!(likelihood["estimator"], "likelihood");
    let kinds = likelihood["kinds"].as_array().unwrap();
    let names: Vec<String> = Kind::ALL.iter().map(ToString::to_string).collect();
    let printed = kinds.iter().map(|kind| kind["set"].as_str().unwrap());
    assert!(printed.eq(names.iter().map(String::as_str)));
    for (whole, part) in [("ok", "count"), ("ok_and_wrong", "of"), ("covered", "of")] {
        let of = |set: &serde_json::Value| set[whole][part].as_u64().unwrap();
        assert_eq!(of(&likelihood["all"]), kinds.iter().map(of).sum::<u64>());
    }
    for probability in ["confidence", "maybes"] {
        let count = |bin: &serde_json::Value| bin["actual"]["of"].as_u64().unwrap();
        for set in kinds.iter().chain([&likelihood["all"]]) {
            let bins = set[probability]["bins"].as_array().unwrap();
            let sum: u64 = bins.iter().map(count).sum();
            assert_eq!(sum, count(&set[probability]["all"]), "{set}");
        }
        assert!(count(&likelihood["all"][probability]["all"]) > 0);
    }
}
