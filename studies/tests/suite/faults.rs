//! Tests of faults of the instrument: no fault that changes an answer leaves it `ok` without a reason.

use std::path::Path;

use crate::common::study;
use host_sim::recording::Recording;
use host_sim::replay::{self, Options};
use host_sim::score;
use serde_json::Value;
use stairscan::verdict::Status;
use studies::faults::Fault;

/// Faults that may affect only rows without echoes, or that no reason names.
const HARMLESS_AT_TIMES: &[(&str, f64)] = &[
    ("microsteps", 2.0),
    ("mirror-sticks", 20.0),
    ("mirror-slips", 4.0),
    ("rows-swapped", 40.0),
    ("person-crosses", 1.0),
];

fn stairs() -> Recording {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings/stair_a");
    Recording::read(&root).unwrap()
}

/// Faults that affect the answer at this strength with every seed.
const NAMED: &[(&str, f64)] = &[
    ("bit-high", 12.0),
    ("bit-low", 9.0),
    ("sign-lost", 1.0),
    ("iq-swapped", 1.0),
    ("conjugated", 1.0),
    ("channel-dead", 1.0),
    ("channels-equal", 1.0),
    ("iq-gain", 6.0),
    ("iq-phase", 20.0),
    ("gain-falls", 20.0),
    ("mirror-stuck", 120.0),
    ("angle-offset", 3.0),
    ("mount-height", 0.06),
    ("mirror-offset", 0.03),
    ("rows-shuffled", 80.0),
    ("rows-reversed", 80.0),
    ("rows-repeated", 10.0),
    ("rows-empty", 10.0),
    ("stale-chirps", 0.1),
    ("bursts", 0.1),
    ("tone", 20.0),
    ("clipped", 0.5),
    ("chair-creeps", 0.02),
];

#[test]
fn a_clean_scan_is_ok() {
    let answer = replay::answer(&stairs(), &Options::default()).unwrap();
    assert_eq!(answer.scan.status, Status::Ok, "{}", answer.scan.reasons);
}

/// Applies three draws of a fault. Returns how many are `ok`, `ok` and wrong, and named.
fn draws(name: &str, strength: f64) -> (u32, u32, u32) {
    let (clean, fault) = (stairs(), Fault::named(name).unwrap());
    let (mut ok, mut wrong, mut named) = (0, 0, 0);
    for seed in 0..3 {
        let damaged = fault.on(&clean, strength, seed).unwrap();
        let answer = replay::answer(&damaged, &Options::default()).unwrap();
        let reasons = answer.scan.reasons;
        let is_ok = answer.scan.status == Status::Ok;
        let truth = damaged.truth(0).unwrap();
        ok += u32::from(is_ok);
        wrong += u32::from(is_ok && score::scene(&answer, truth).wrong);
        named += u32::from(fault.reasons.iter().any(|&r| reasons.has(r)));
        let is_valid = answer.horizon_m.unwrap_or(0.0) >= 1.0;
        assert_eq!(is_ok, is_valid, "{name} {strength}, seed {seed}: {reasons}");
    }
    (ok, wrong, named)
}

#[test]
fn harmful_faults_are_named() {
    let missed: Vec<String> = (NAMED.iter())
        .map(|&(name, strength)| (name, strength, draws(name, strength)))
        .filter(|&(_, _, (ok, _, named))| ok > 0 || named < 2)
        .map(|(name, strength, found)| format!("{name} {strength}: {found:?}"))
        .collect();
    assert!(missed.is_empty(), "ok, ok and wrong, named: {missed:?}");
}

#[test]
fn what_may_be_harmless_is_never_ok_and_wrong() {
    for &(name, strength) in HARMLESS_AT_TIMES {
        let (_, wrong, _) = draws(name, strength);
        assert_eq!(wrong, 0, "{name} {strength}");
    }
}

#[test]
fn a_calibrated_scanner_names_a_wrong_bandwidth() {
    let clean = stairs();
    let mut options = Options::default();
    replay::answers(
        &clean,
        &Options {
            scans: Some(1),
            ..options
        },
        |scanned| {
            let echo_m = scanned.pipeline.health().mirror_echo_m(scanned.config);
            options.config.mount.mirror_echo = (1e5 * echo_m) as i32;
        },
    )
    .unwrap();
    assert_eq!(
        replay::answer(&clean, &options).unwrap().scan.status,
        Status::Ok
    );
    let fault = Fault::named("bandwidth").unwrap();
    for seed in 0..4 {
        let answer = replay::answer(&fault.on(&clean, 0.03, seed).unwrap(), &options).unwrap();
        assert_eq!(answer.scan.status, Status::Degraded);
        assert!(
            answer
                .scan
                .reasons
                .has(stairscan::verdict::Reason::RangeScale)
        );
    }
}

#[test]
fn the_command_counts_runs_and_refuses_unknown_kinds() {
    let dir = concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings");
    let json = study(&[
        "faults",
        "--on",
        dir,
        "--kind",
        "iq-swapped",
        "--kind",
        "gain-falls",
        "--format",
        "json",
    ]);
    assert!(json.status.success());
    let lines: Vec<Value> = (String::from_utf8(json.stdout).unwrap().lines())
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(lines.len(), 5);
    for line in &lines {
        assert!(line["runs"].as_u64().unwrap() >= 1);
        assert_eq!(line["ok_and_wrong"], 0, "{line}");
    }
    let unknown = study(&["faults", "--on", dir, "--kind", "gremlins"]);
    assert_eq!(unknown.status.code(), Some(1));
    let error = String::from_utf8(unknown.stderr).unwrap();
    assert!(
        error.contains("--kind: \"gremlins\": expected one of bit-high"),
        "{error}"
    );
}

#[test]
fn a_fault_of_i_and_q_refuses_real_samples() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/stair_a");
    let mut recording = Recording::read(Path::new(path)).unwrap();
    recording.meta.real = true;
    let fault = Fault::named("iq-swapped").unwrap();
    let printed = fault.on(&recording, 1.0, 1).unwrap_err().to_string();
    assert!(printed.contains("real samples"), "{printed}");
}
