use super::*;
use host_sim::random::Kind;
use host_sim::recording::Recording;
use host_sim::replay;
use host_sim::simulation::random_scan;
use stairscan::verdict::{Reason, Reasons, Status};

fn clean() -> Recording {
    random_scan(Kind::Ascending, Kind::Ascending.variety(), 3).unwrap()
}

/// Returns status and reasons of the answer to the first scan.
fn verdict(recording: &Recording) -> (Status, Reasons) {
    let answer = replay::answer(recording, &replay::Options::default()).unwrap();
    (answer.scan.status, answer.scan.reasons)
}

/// Asserts that the answer is `degraded` with this reason.
fn assert_detected(recording: &Recording, reason: Reason, name: &str) {
    let (status, reasons) = verdict(recording);
    let has = reasons.has(reason);
    assert!(status == Status::Degraded && has, "{name}: {reasons}");
}

/// Reads a recording of the repository.
fn committed(name: &str) -> Recording {
    let dir = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
    Recording::read(&dir.join(name)).unwrap()
}

#[test]
fn names_are_unique_and_found() {
    for fault in ALL {
        let found = Fault::named(fault.name).unwrap();
        assert!(core::ptr::eq(found, fault), "{}", fault.name);
    }
    assert!(Fault::named("none").is_none());
}

#[test]
fn every_fault_changes_the_recording_and_one_seed_is_one_recording() {
    let clean = clean();
    for fault in ALL {
        let strength = fault.strengths[fault.strengths.len() / 2];
        let faulty = fault.on(&clean, strength, 5).unwrap();
        let again = fault.on(&clean, strength, 5).unwrap();
        assert_eq!(faulty.samples, again.samples, "{}", fault.name);
        assert_eq!(faulty.meta.angles_deg, again.meta.angles_deg);
        assert_eq!(faulty.chirps(), faulty.meta.angles_deg.len());
        let same = faulty.samples == clean.samples
            && faulty.meta.angles_deg == clean.meta.angles_deg
            && faulty.meta.mirror == clean.meta.mirror
            && faulty.meta.bandwidth_hz == clean.meta.bandwidth_hz;
        assert!(!same, "{}", fault.name);
    }
}

#[test]
fn sequences_are_refused() {
    let mut recording = clean();
    recording.meta.sequence.scans = 2;
    let error = ALL[0].on(&recording, 1.0, 1).unwrap_err().to_string();
    assert!(error.contains("2 scans: expected one"), "{error}");
}

/// An angle error is found by the first corner: the ground in front of these stairs is too smooth to show its height.
#[test]
fn angles_two_degrees_off_are_doubted_by_the_first_corner() {
    for name in ["stair_a", "stair_b", "stair_c"] {
        let clean = committed(name);
        assert!(!verdict(&clean).1.has(Reason::Mount), "{name}");
        for off_deg in [-2.0, 2.0] {
            let mut off = clean.clone();
            off.meta
                .angles_deg
                .iter_mut()
                .for_each(|angle| *angle += off_deg);
            assert_detected(&off, Reason::Mount, &format!("{name} {off_deg}"));
        }
    }
}

/// A wrong mounting is found in scenes that show little of the ground: a corner below it, one little above the noise,
/// and weak echoes of the ground at a wrong height. Each scene is `ok` without the fault.
#[test]
fn little_that_is_seen_of_the_floor_shows_a_wrong_mounting() {
    let cases = [
        (Kind::Irregular, 1_000_008, -0.06, 0.0),
        (Kind::Low, 14, 0.0, -2.0),
        (Kind::Uneven, 19, 0.04, 0.0),
        (Kind::Uneven, 19, -0.04, 0.0),
    ];
    for (kind, seed, off_m, off_deg) in cases {
        let name = format!("{} {seed}", kind.name());
        let clean = random_scan(kind, kind.variety(), seed).unwrap();
        assert_eq!(verdict(&clean).0, Status::Ok, "{name}");
        let mut off = clean.clone();
        off.meta.mirror.as_mut().unwrap().mount_height_m += off_m;
        for angle in &mut off.meta.angles_deg {
            *angle += off_deg;
        }
        assert_detected(&off, Reason::Mount, &name);
    }
}

/// A bandwidth error of 4 % puts the ground of these scenes where no valid mounting puts it. An error of 1 % is
/// harmless and is not reported.
#[test]
fn a_wrong_bandwidth_strains_the_calibration_on_the_floor() {
    for seed in [100, 102, 103, 105] {
        let clean = random_scan(Kind::Ascending, Kind::Ascending.variety(), seed).unwrap();
        for (factor, expected) in [(1.0, false), (0.99, false), (0.96, true)] {
            let mut off = clean.clone();
            off.meta.bandwidth_hz *= factor;
            let mount = verdict(&off).1.has(Reason::Mount);
            assert_eq!(mount, expected, "{seed} {factor}");
        }
    }
}

/// Wrong microsteps are found by the width of whole lobes over the angle: neighbouring rows differ no more than with
/// the nominal beam.
#[test]
fn other_microsteps_than_set_are_reported_by_the_beam() {
    let fault = Fault::named("microsteps").unwrap();
    for name in ["stair_a", "stair_b", "stair_c"] {
        let clean = committed(name);
        assert!(!verdict(&clean).1.has(Reason::AngleJump), "{name}");
        for factor in [0.5, 0.8, 2.0, 4.0] {
            let faulty = fault.on(&clean, factor, 1).unwrap();
            assert_detected(&faulty, Reason::AngleJump, &format!("{name} {factor}"));
        }
    }
}
