//! Tests that the tap tells guard sweeps from full scans.

use host_sim::recording::Recording;
use host_sim::setup::{self, Kind};
use host_sim::tap::beside::{self, Beside, MountingArgs};
use host_sim::tap::gather::{Gather, Part};
use host_sim::tap::kinds;
use host_sim::tap::mounting::Mounting;
use host_sim::tap::scans::Tap;
use stairscan::config::Config;

use super::bench::{Scanned, Traffic, read, scan};
use crate::common::{Scratch, sim};

/// Returns the recording of guard sweeps with all angles shifted by `degrees`.
fn shifted(degrees: f64) -> Recording {
    let mut recording = read("guard_kerb");
    let angles = &mut recording.meta.angles_deg;
    angles.iter_mut().for_each(|angle| *angle += degrees);
    recording
}

fn guarded(recording: &Recording) -> Scanned {
    scan(recording, &Config::default(), 4, &[])
}

fn gathered(traffic: &Traffic, mounting: &Mounting) -> (Vec<Part>, Vec<String>) {
    let mut tap = Tap::default();
    for (at, wire, bytes) in traffic {
        tap.push(*at, *wire, bytes);
    }
    tap.end();
    let mut gather = Gather::new("tap", mounting.clone());
    while let Some(scan) = tap.scan() {
        gather.take(&scan);
    }
    let notes = gather.notes.clone();
    (gather.parts(), notes)
}

/// Returns the numbers and kinds of the scans of each recording that a tap makes with what `beside` has received.
fn kinds_of(traffic: &Traffic, beside: &Beside) -> Vec<(usize, Option<Kind>)> {
    let (mounting, _) = beside::mounting(&MountingArgs::default(), beside);
    let (parts, _) = gathered(traffic, &mounting);
    let kind = |part: &Part| (part.times.len(), part.scans_kind(&mounting, beside));
    parts.iter().map(kind).collect()
}

/// Returns those lines of the report port that begin with one of `words`, without the angles of full scans if they are
/// those of the sweeps: a scanner that plays a recording of sweeps has the same for both.
fn only(scanned: &Scanned, words: &[&str]) -> Beside {
    let mut beside = Beside::default();
    let guard = (scanned.beside.lines.iter()).any(|(_, line)| line.starts_with("$PSTR,GUARD,"));
    let full = [",first-angle,", ",angle-step,", ",angle-count,"];
    for (at, line) in &scanned.beside.lines {
        let left_out = guard && full.iter().any(|key| line.contains(key));
        if !left_out && words.iter().any(|word| line.starts_with(word)) {
            beside.line(*at, line);
        }
    }
    beside
}

#[test]
fn the_default_angles_show_the_kind_without_a_report() {
    let guard = guarded(&read("guard_kerb"));
    let none = Beside::default();
    assert_eq!(kinds_of(&guard.traffic, &none), [(4, Some(Kind::Guard))]);
    let full = scan(&read("stair_a"), &Config::default(), 2, &[]);
    assert_eq!(kinds_of(&full.traffic, &none), [(2, Some(Kind::Scans))]);
}

#[test]
fn other_angles_show_it_by_sentences_or_settings_only() {
    let guard = guarded(&shifted(-3.0));
    let kinds = |beside: &Beside| kinds_of(&guard.traffic, beside);
    assert_eq!(kinds(&Beside::default()), [(4, None)]);
    for words in [&["$PSTR,GUARD"][..], &["$PSTR,CONF"], &["$PSTR"]] {
        let told = kinds(&only(&guard, words));
        assert_eq!(told, [(4, Some(Kind::Guard))], "{words:?}");
    }
}

/// With `watch` full scans come between the sweeps, and their schedule contains the angles of the sweeps.
#[test]
fn sweeps_between_full_scans_are_kept() {
    let (full, guard) = (
        scan(&read("stair_a"), &Config::default(), 1, &[]),
        guarded(&read("guard_kerb")),
    );
    let mut traffic = full.traffic.clone();
    let begun = traffic.last().unwrap().0 + 100;
    let later = guard.traffic.iter().cloned();
    traffic.extend(later.map(|(at, wire, bytes)| (begun + at, wire, bytes)));
    for beside in [Beside::default(), only(&full, &["$PSTR,CONF"])] {
        let expected = [(1, Some(Kind::Scans)), (4, Some(Kind::Guard))];
        assert_eq!(kinds_of(&traffic, &beside), expected);
    }
}

#[test]
fn a_sweep_that_ended_early_is_left_out() {
    let guard = guarded(&read("guard_kerb"));
    let (mounting, _) = beside::mounting(&MountingArgs::default(), &guard.beside);
    let rows = guard.traffic.len() / 4;
    let (parts, notes) = gathered(&guard.traffic[..rows + rows / 2].to_vec(), &mounting);
    assert_eq!(parts.len(), 1, "{notes:?}");
    assert!(notes[0].contains("only, of 8° to 38°"), "{notes:?}");
}

#[test]
fn a_kind_that_is_not_known_is_said_with_its_remedies() {
    assert_eq!(kinds::doubt(&[]), None);
    let note = kinds::doubt(&["hall", "hall-2"]).unwrap();
    for part in [
        "hall, hall-2: stored as full scans",
        "(-20:50:0.25 and 8:38:1)",
        "--report PORT",
        "--guard FIRST:LAST:STEP",
        "stairscan:mode",
    ] {
        assert!(note.contains(part), "{part}: {note}");
    }
}

#[test]
fn guard_sweeps_of_the_demo_stay_guard_sweeps() {
    let dir = Scratch::new("record-guard");
    let output = dir.path().join("hall");
    let output = output.to_str().unwrap();
    let original = concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/guard_kerb");
    let done = sim(&["record", "--demo", original, "-o", output, "--scans", "2"]);
    let [printed, notes] = [done.stdout, done.stderr].map(|text| String::from_utf8(text).unwrap());
    assert!(done.status.success(), "{notes}");
    let expected = "hall: 2 guard sweeps of 31 rows, 8.00° to 38.00°";
    assert!(printed.contains(expected), "{printed}");
    assert!(notes.contains("guard sweep: 31 rows"), "{notes}");
    let recording = Recording::read(output.as_ref()).unwrap();
    assert_eq!(setup::kind(&recording).unwrap(), Kind::Guard);
}
