//! Tests of a user's own samples: what is missing for a scan is reported, with the next step.

use std::fs;

use crate::common::{Scratch, sim};

/// Mounting and bandwidth of the repository's recordings.
const KEYS: [&str; 10] = [
    "--bandwidth-hz",
    "10e9",
    "--mirror-offset-m",
    "0.22",
    "--beamwidth-deg",
    "5",
    "--mount-height-m",
    "0.4",
    "--scan-plane",
    "depth",
];
/// Number of chirps of these recordings.
const CHIRPS: usize = 281;

/// Writes an array of a recording's chirps; returns its path.
fn array(scratch: &Scratch) -> String {
    let recording = concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/stair_a");
    let array = scratch.path().join("chirps.npy").display().to_string();
    assert!(sim(&["convert", recording, "-o", &array]).status.success());
    array
}

/// Returns the output of `convert` on the array with a table of these angles.
fn converted(scratch: &Scratch, array: &str, name: &str, angle: impl Fn(usize) -> f64) -> String {
    let path = |suffix: &str| scratch.path().join(format!("{name}{suffix}"));
    let table: String = (0..CHIRPS).map(|k| format!("{:.3}\n", angle(k))).collect();
    fs::write(path(".csv"), table).unwrap();
    let (table, to) = (
        path(".csv").display().to_string(),
        path("").display().to_string(),
    );
    let out = sim(&[
        &["convert", array, "--angles", &table, "-o", &to][..],
        &KEYS,
    ]
    .concat());
    assert!(out.status.success(), "{out:?}");
    String::from_utf8(out.stdout).unwrap()
}

#[test]
fn an_array_is_no_recording_and_the_message_names_the_command_that_makes_one() {
    let scratch = Scratch::new("own-array");
    let array = array(&scratch);
    for command in ["replay", "report", "inspect"] {
        let out = sim(&[command, &array]);
        let message = String::from_utf8(out.stderr).unwrap();
        assert_eq!(out.status.code(), Some(1), "{command}: {message}");
        assert!(
            message.contains("cargo sim convert"),
            "{command}: {message}"
        );
    }
}

#[test]
fn what_cannot_be_scanned_is_reported_when_it_is_converted() {
    let scratch = Scratch::new("own-angles");
    let array = array(&scratch);
    let even = converted(&scratch, &array, "even", |k| -20.0 + 0.25 * k as f64);
    assert!(even.contains("next: cargo sim replay"), "{even}");
    // As from an encoder: every angle deviates by another fraction of a step.
    let uneven = |k: usize| -20.0 + 0.25 * (k as f64 + 0.4 * (k as f64).sin());
    let uneven = converted(&scratch, &array, "uneven", uneven);
    let printed = "cannot be scanned: uneven.sigmf-meta: captures[";
    assert!(uneven.contains(printed), "{uneven}");
    let profile = scratch.path().join("bare").display().to_string();
    let out = sim(&["convert", &array, "--bandwidth-hz", "10e9", "-o", &profile]);
    let bare = String::from_utf8(out.stdout).unwrap();
    assert!(
        bare.contains("mirror_offset_m") && bare.contains("cargo sim profile"),
        "{bare}"
    );
}
