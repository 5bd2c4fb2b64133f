use core::f64::consts::TAU;

use num_complex::Complex64;

use super::*;
use host_sim::random::Kind;
use host_sim::recording::Recording;
use host_sim::replay;
use host_sim::scene::maths::{LIGHT, cis};
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
    assert!(
        status == Status::Degraded && has,
        "{name}: {status:?} {reasons}"
    );
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
/// the nominal beam. Smaller steps may leave no lobe that another does not disturb: then nothing names the cause, but
/// nothing is `ok` either.
#[test]
fn other_microsteps_than_set_are_reported_by_the_beam() {
    let fault = Fault::named("microsteps").unwrap();
    for name in ["stair_a", "stair_b", "stair_c"] {
        let clean = committed(name);
        assert!(!verdict(&clean).1.has(Reason::AngleJump), "{name}");
        for factor in [0.5, 0.8, 2.0, 4.0] {
            let faulty = fault.on(&clean, factor, 1).unwrap();
            if factor < 1.0 {
                assert_eq!(verdict(&faulty).0, Status::Degraded);
                continue;
            }
            assert_detected(&faulty, Reason::AngleJump, &format!("{name} {factor}"));
        }
    }
}

/// Returns the amplitude of a chirp at the range of its mirror, under a Hann window.
fn own_echo(recording: &Recording, row: usize) -> Complex64 {
    let meta = &recording.meta;
    let samples = meta.samples_per_chirp as f64;
    let offset_m = meta.mirror.as_ref().unwrap().offset_m;
    let beat = 2.0 * offset_m * meta.bandwidth_hz / (LIGHT * samples);
    let terms = recording.chirp(row).unwrap().iter().enumerate();
    let terms = terms.map(|(n, s)| {
        let n = n as f64 + 0.5;
        let window = 1.0 - libm::cos(TAU * n / samples);
        Complex64::new(s.i.into(), s.q.into()) * cis(-TAU * beat * n) * window
    });
    terms.sum()
}

#[test]
fn a_lost_reference_is_missing_and_a_flipped_one_half_a_turn_off() {
    let clean = clean();
    for (name, factor) in [("reference-lost", 0.0), ("reference-flips", -1.0)] {
        let faulty = Fault::named(name).unwrap().on(&clean, 0.5, 1).unwrap();
        let rows = clean.meta.angles_deg.len();
        let changed = (0..rows).filter(|&row| {
            let (before, after) = (own_echo(&clean, row), own_echo(&faulty, row));
            let left = (after - before * factor).norm_sqr() / before.norm_sqr();
            let same = (after - before).norm_sqr() / before.norm_sqr();
            assert!(left.min(same) < 0.03, "{name} row {row}: {left} {same}");
            left < same
        });
        let share = changed.count() as f64 / rows as f64;
        assert!((0.4..0.6).contains(&share), "{name}: {share}");
    }
}

#[test]
fn a_weak_reference_leaves_the_scenes_echoes() {
    let clean = clean();
    let fault = Fault::named("reference-weak").unwrap();
    let faulty = fault.on(&clean, 20.0, 1).unwrap();
    let power = |recording: &Recording| {
        let rows = 0..clean.meta.angles_deg.len();
        rows.map(|row| own_echo(recording, row).norm_sqr())
            .sum::<f64>()
    };
    let fall_db = 10.0 * libm::log10(power(&clean) / power(&faulty));
    assert!((18.0..22.0).contains(&fall_db), "{fall_db}");
}
