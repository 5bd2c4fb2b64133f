//! Tests of recordings of several scans: one answer for each scan, each scored against its own ground
//! truth, and clear messages for errors.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{Scratch, refused, sim};
use host_sim::recording::{Recording, Truth};
use serde_json::{Value, json};

/// Reads a recording of the repository.
fn committed(name: &str) -> Recording {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
    Recording::read(&root.join(name)).unwrap()
}

/// Joins the scans of `parts`, alternately forward and backward.
fn sequence(parts: &[&Recording], falling_first: bool) -> Recording {
    let mut whole = parts[0].clone();
    (whole.samples, whole.meta.angles_deg) = (Vec::new(), Vec::new());
    for (k, part) in parts.iter().enumerate() {
        let rows = 0..part.chirps();
        let order: Vec<usize> = match (k % 2 == 1) != falling_first {
            true => rows.rev().collect(),
            false => rows.collect(),
        };
        for row in order {
            whole.samples.extend(part.chirp(row).unwrap());
            whole.meta.angles_deg.push(part.meta.angles_deg[row]);
        }
    }
    let truth = parts.iter().map(|part| part.meta.truth.clone().unwrap());
    whole.meta.sequence.scans = parts.len();
    whole.meta.sequence.truth = truth.collect();
    whole
}

/// Writes two staircases and an empty scene, as three scans, into `scratch`.
fn written(scratch: &Scratch, falling_first: bool) -> PathBuf {
    let parts = ["stair_a", "empty", "stair_b"].map(committed);
    let path = scratch.path().join("three");
    let [a, b, c] = &parts;
    sequence(&[a, b, c], falling_first).write(&path).unwrap();
    path
}

/// Returns the JSON lines of `replay`.
fn replay(path: &Path, args: &[&str]) -> Vec<Value> {
    let path = path.to_str().unwrap();
    let out = sim(&[&["replay", path, "--format", "json"], args].concat());
    let message = String::from_utf8(out.stderr).unwrap();
    assert_eq!(out.status.code(), Some(0), "{message}");
    let text = String::from_utf8(out.stdout).unwrap();
    text.lines()
        .map(|l| serde_json::from_str(l).unwrap())
        .collect()
}

fn steps(line: &Value) -> usize {
    line["steps"].as_array().unwrap().len()
}

#[test]
fn one_answer_a_scan_in_order() {
    for (name, falling_first) in [("rising", false), ("falling", true)] {
        let scratch = Scratch::new(&format!("sequence-{name}"));
        let path = written(&scratch, falling_first);
        for args in [&[][..], &["--single"]] {
            let lines = replay(&path, args);
            let found: Vec<_> = lines
                .iter()
                .map(|l| (l["scan"].as_u64(), steps(l)))
                .collect();
            let scans: Vec<_> = found.iter().map(|(scan, _)| *scan).collect();
            assert_eq!(scans, [Some(1), Some(2), Some(3)], "{name} {args:?}");
            assert_eq!((found[0].1, found[2].1), (3, 3), "{name} {args:?}");
            // A scene that takes another's place within two seconds may be doubted, but no step of it is sure.
            let sure = lines[1]["status"] == "ok";
            assert!(found[1].1 == 0 || !sure, "{name} {args:?}: {}", lines[1]);
            assert!(lines.iter().all(|l| l["recording"] == "three"));
            assert!(lines.iter().all(|l| l["lost_rows"] == 0));
        }
    }
}

/// A scan with `--single` gives the answer of a recording of it alone, if the chair is known to stand as
/// in that recording.
#[test]
fn single_is_each_scan_alone() {
    let scratch = Scratch::new("sequence-alone");
    let path = written(&scratch, false);
    let single = replay(&path, &["--single", "--motion", "standing"]);
    for (name, line) in ["stair_a", "empty", "stair_b"].iter().zip(&single) {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
        let alone = &replay(&root.join(name), &[])[0];
        for key in ["status", "direction", "steps", "reasons"] {
            assert_eq!(line[key], alone[key], "{name} {key}");
        }
    }
}

/// A higher nose lifts the beam. With the pitch in the recording the answers are those of the level
/// chair. Each scan has its own pitch.
#[test]
fn the_pitch_is_taken_off_the_angles() {
    let level = committed("stair_a");
    let expected = replay(&write_into("sequence-level", &level).1, &[]);
    let leaning = |pitch: f64| {
        let mut part = level.clone();
        for angle in &mut part.meta.angles_deg {
            *angle += pitch;
        }
        part
    };
    let (up, down) = (leaning(1.5), leaning(-2.25));
    let mut whole = sequence(&[&up, &down], false);
    let noise = [0.02, -0.03, 0.01];
    let pitch = |k: usize| [1.5, -2.25][k / 281] + noise[k % 3] - [0.0, 0.02][k % 281 / 280];
    whole.meta.motion.pitch_deg = (0..whole.chirps()).map(pitch).collect();
    let (_scratch, path) = write_into("sequence-pitch", &whole);
    for args in [&[][..], &["--single"]] {
        let lines = replay(&path, args);
        assert_eq!(lines.len(), 2);
        for line in &lines {
            assert_eq!(line["direction"], "up", "{line}");
            let pairs = expected[0]["steps"].as_array().unwrap().iter();
            let found = line["steps"].as_array().unwrap();
            assert_eq!(found.len(), 3, "{line}");
            for (is, was) in found.iter().zip(pairs) {
                for key in ["distance_m", "height_m"] {
                    let apart = is[key].as_f64().unwrap() - was[key].as_f64().unwrap();
                    assert!(apart.abs() < 0.002, "{key}: {is} {was}");
                }
            }
        }
    }
    // One pitch for the whole recording.
    let mut one = up;
    one.meta.motion.pitch_deg = vec![1.5; one.chirps()];
    let (_scratch, path) = write_into("sequence-global-pitch", &one);
    let meta: Value =
        serde_json::from_str(&fs::read_to_string(path.with_extension("sigmf-meta")).unwrap())
            .unwrap();
    assert_eq!(meta["global"]["stairscan:pitch_deg"], 1.5);
    assert!(meta["captures"][0].get("stairscan:pitch_deg").is_none());
    assert_eq!(replay(&path, &[])[0]["steps"], expected[0]["steps"]);
}

/// From straight down to the front the angles have the opposite sign: a higher nose adds.
#[test]
fn the_pitch_adds_to_angles_from_straight_down() {
    let level = committed("descending");
    let expected = replay(&write_into("sequence-level-down", &level).1, &[]);
    let mut leaning = level;
    for angle in &mut leaning.meta.angles_deg {
        *angle -= 2.0;
    }
    leaning.meta.motion.pitch_deg = vec![2.0; leaning.chirps()];
    let (_scratch, path) = write_into("sequence-pitch-down", &leaning);
    assert_eq!(replay(&path, &[])[0]["steps"], expected[0]["steps"]);
}

/// Writes a recording into a new directory, which is removed when the returned `Scratch` is dropped.
fn write_into(test: &str, recording: &Recording) -> (Scratch, PathBuf) {
    let scratch = Scratch::new(test);
    let path = scratch.path().join("one");
    recording.write(&path).unwrap();
    (scratch, path)
}

#[test]
fn all_keys_survive_reading_and_writing() {
    let parts = ["stair_a", "stair_b"].map(committed);
    let [a, b] = &parts;
    let mut whole = sequence(&[a, b], false);
    let chirps = whole.chirps();
    let line = |slope: f64| (0..chirps).map(|k| slope * k as f64).collect::<Vec<_>>();
    whole.meta.motion.travel_m = line(1.0 / 1024.0);
    whole.meta.motion.time_s = line(1.0 / 256.0);
    whole.meta.motion.pitch_deg = line(-1.0 / 512.0);
    whole.meta.sequence.truth_travel_m = vec![0.1, 0.2];
    whole.meta.extra.insert("other:key".into(), json!([1, 2]));
    let (_scratch, path) = write_into("sequence-keys", &whole);
    let read = Recording::read(&path).unwrap();
    assert_eq!(read.meta.motion, whole.meta.motion);
    assert_eq!(read.meta.sequence, whole.meta.sequence);
    assert_eq!(read.meta.extra, whole.meta.extra);
    let second = read.scan(1);
    assert_eq!((second.name.as_str(), second.scans()), ("one-scan2", 1));
    assert_eq!(second.samples, whole.samples[whole.samples.len() / 2..]);
    assert_eq!(second.meta.truth, b.meta.truth);
    assert_eq!(
        second.meta.motion.travel_m[0],
        whole.meta.motion.travel_m[281]
    );
}

/// Each scan's answer is scored against its own ground truth.
#[test]
fn score_holds_each_scan_against_its_own_truth() {
    let scratch = Scratch::new("sequence-score");
    let path = written(&scratch, false);
    let score = || {
        let out = sim(&[
            "score",
            scratch.path().to_str().unwrap(),
            "--format",
            "json",
        ]);
        let message = String::from_utf8(out.stderr).unwrap();
        assert_eq!(out.status.code(), Some(0), "{message}");
        serde_json::from_slice::<Value>(&out.stdout).unwrap()
    };
    let good = score();
    assert_eq!(good["sets"][0]["scenes"], 3);
    assert_eq!(good["sets"][0]["exact"], 3, "{good}");
    // Ground truths in another order do not belong to the scans.
    let mut mixed = Recording::read(&path).unwrap();
    mixed.meta.sequence.truth.rotate_left(1);
    mixed.write(&path).unwrap();
    let bad = score();
    assert!(bad["sets"][0]["exact"].as_u64().unwrap() < 3, "{bad}");
    assert_eq!(bad["not_exact_or_wrong"][0]["recording"], "three scan 1");
    // A scan without its own ground truth is not scored: the one of the first chirp does not belong to
    // it.
    mixed.meta.sequence.truth.clear();
    mixed.meta.truth = Some(Truth::default());
    mixed.meta.truth.as_mut().unwrap().direction = "none".into();
    mixed.write(&path).unwrap();
    let out = sim(&["score", scratch.path().to_str().unwrap()]);
    let message = String::from_utf8(out.stderr).unwrap();
    assert!(
        out.status.code() == Some(1) && message.contains("truth_scans"),
        "{message}"
    );
}

#[test]
fn inspect_profile_and_pictures_take_sequences() {
    let scratch = Scratch::new("sequence-views");
    let path = written(&scratch, false);
    let (path, dir) = (path.to_str().unwrap(), scratch.path().to_str().unwrap());
    let run = |args: &[&str]| {
        let out = sim(args);
        let message = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(0), "{args:?}: {message}");
        String::from_utf8(out.stdout).unwrap()
    };
    let inspected = run(&["inspect", path, "--format", "json"]);
    let scans: Vec<Value> = inspected
        .lines()
        .map(|l| serde_json::from_str::<Value>(l).unwrap()["scan"].clone())
        .collect();
    assert_eq!(scans, [1, 2, 3]);
    let profile = run(&["profile", path, "--chirp", "300"]);
    assert!(
        profile.starts_with("three, chirp 300 at 45.25°"),
        "{profile}"
    );
    run(&["replay", path, "--plots", dir]);
    for scan in 1..=3 {
        let file = format!("three-scan{scan}-fig13-staircase.png");
        assert!(scratch.path().join(&file).exists(), "{file}");
    }
}

/// Writes a recording of 2 scans of 3 chirps with the metadata changed by `change`.
fn damaged(scratch: &Scratch, change: impl FnOnce(&mut Value)) -> PathBuf {
    let captures: Vec<Value> = [-0.5, 0.0, 0.5, 0.5, 0.0, -0.5]
        .iter()
        .enumerate()
        .map(|(k, angle)| {
            json!({
                "core:sample_start": 16 * k,
                "stairscan:mirror_angle_deg": angle,
                "stairscan:travel_m": 0.01 * k as f64,
                "stairscan:time_s": 0.1 * k as f64,
                "stairscan:pitch_deg": 0.2,
            })
        })
        .collect();
    let none = json!({"direction": "none", "steps": []});
    let further = json!({
        "stairscan:scans": 2,
        "stairscan:truth_travel_m": [0.02, 0.05],
        "stairscan:truth_scans": [none, none],
        "stairscan:disturbance": {"kind": "jolt", "harmful": true, "row": 3},
    });
    scratch.damaged(&captures, further, change)
}

/// A change of the metadata, and the expected parts of the message.
type Case = (fn(&mut Value), &'static [&'static str]);

const GLOBAL: &[Case] = &[
    (
        |m| m["global"]["stairscan:scans"] = json!(0),
        &["stairscan:scans", "found 0"],
    ),
    (
        |m| m["global"]["stairscan:scans"] = json!(1.5),
        &["stairscan:scans", "1.5"],
    ),
    (
        |m| {
            m["global"]["stairscan:scans"] = json!(4);
            m["global"]["stairscan:truth_travel_m"] = json!([0, 0, 0, 0]);
            m["global"]
                .as_object_mut()
                .unwrap()
                .remove("stairscan:truth_scans");
        },
        &["stairscan:scans", "found 4", "divisor of the 6 captures"],
    ),
    (
        |m| m["global"]["stairscan:truth_travel_m"] = json!([0.02]),
        &["truth_travel_m", "found 1 items", "expected 2"],
    ),
    (
        |m| m["global"]["stairscan:truth_travel_m"][1] = json!("far"),
        &["truth_travel_m[1]", "far", "metres"],
    ),
    (
        |m| m["global"]["stairscan:truth_scans"] = json!({}),
        &["truth_scans", "array of 2"],
    ),
    (
        |m| m["global"]["stairscan:truth_scans"][1]["direction"] = json!("left"),
        &["truth_scans[1] direction", "left", "\"up\""],
    ),
    (
        |m| m["global"]["stairscan:truth_scans"][0]["steps"] = json!([{"distance_m": 1}]),
        &["truth_scans[0] steps[0] height_m", "missing"],
    ),
    (
        |m| m["global"]["stairscan:disturbance"]["harmful"] = json!("yes"),
        &["disturbance harmful", "true or false"],
    ),
    (
        |m| m["global"]["stairscan:disturbance"] = json!("jolt"),
        &["disturbance", "object"],
    ),
    (
        |m| m["global"]["stairscan:pitch_deg"] = json!(90),
        &["global stairscan:pitch_deg", "found 90", "±45"],
    ),
];

const CAPTURES: &[Case] = &[
    (
        |m| m["captures"][4]["stairscan:mirror_angle_deg"] = json!(1.0),
        &[
            "captures[4]",
            "mirror_angle_deg",
            "fall in scan 2",
            "rise in the scan before",
        ],
    ),
    (
        |m| m["captures"][5]["stairscan:mirror_angle_deg"] = json!(0.25),
        &["captures[5]", "mirror_angle_deg", "order", "scan 2"],
    ),
    (
        |m| m["captures"][2]["stairscan:mirror_angle_deg"] = json!(-0.25),
        &["captures[2]", "order", "scan 1"],
    ),
    (
        |m| m["captures"][3]["stairscan:travel_m"] = Value::Null,
        &["captures[3]", "travel_m", "null", "every capture"],
    ),
    (
        |m| {
            drop(
                m["captures"][3]
                    .as_object_mut()
                    .unwrap()
                    .remove("stairscan:travel_m"),
            )
        },
        &["captures[3]", "travel_m", "missing", "every capture"],
    ),
    (
        |m| m["captures"][3]["stairscan:time_s"] = json!(0.1),
        &["captures[3]", "time_s", "found 0.1", "from 0.2"],
    ),
    (
        |m| {
            drop(
                m["captures"][1]
                    .as_object_mut()
                    .unwrap()
                    .remove("stairscan:pitch_deg"),
            )
        },
        &["captures[1]", "pitch_deg", "missing"],
    ),
    (
        |m| m["captures"][1]["stairscan:pitch_deg"] = json!(-60),
        &["captures[1]", "pitch_deg", "-60", "±45"],
    ),
];

#[test]
fn wrong_sequences_name_file_and_key() {
    let scratch = Scratch::new("sequence-values");
    for (change, words) in GLOBAL.iter().chain(CAPTURES) {
        let recording = damaged(&scratch, change);
        refused(&recording, &[&["bad.sigmf-meta"], *words].concat());
    }
    // The unchanged recording is read with all values.
    let good = Recording::read(&damaged(&scratch, |_| ())).unwrap();
    assert_eq!((good.scans(), good.chirps_per_scan()), (2, 3));
    let disturbance = good.meta.disturbance.unwrap();
    assert!(disturbance.misleading && disturbance.extra["row"] == 3);
    // A capture without a pitch uses the recording's.
    let mixed = damaged(&scratch, |m| {
        m["global"]["stairscan:pitch_deg"] = json!(-1);
        m["captures"][1]
            .as_object_mut()
            .unwrap()
            .remove("stairscan:pitch_deg");
    });
    let pitch = Recording::read(&mixed).unwrap().meta.motion.pitch_deg;
    assert_eq!(pitch, [0.2, -1.0, 0.2, 0.2, 0.2, 0.2]);
}

#[test]
fn a_sequence_is_not_turned_round_or_made_longer() {
    let scratch = Scratch::new("sequence-options");
    let path = written(&scratch, false);
    let path = path.to_str().unwrap();
    for (args, word) in [
        (&["--backwards"][..], "its own way round"),
        (&["--scans", "4"], "holds 3"),
    ] {
        let out = sim(&[&["replay", path], args].concat());
        let message = String::from_utf8(out.stderr).unwrap();
        assert!(
            out.status.code() == Some(1) && message.contains(word),
            "{message}"
        );
    }
    assert_eq!(replay(Path::new(path), &["--scans", "2"]).len(), 2);
}
