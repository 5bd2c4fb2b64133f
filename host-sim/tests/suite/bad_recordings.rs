//! Tests of bad recordings: one clear message that names file and field, exit status 1, nothing on
//! stdout.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{Scratch, refused, sim};
use serde_json::{Value, json};

/// The directory of a test, which writes bad recordings.
trait Bad {
    fn recording(&self, change: impl FnOnce(&mut Value)) -> PathBuf;
}

impl Bad for Scratch {
    /// Writes a recording of 5 chirps of 16 samples with the metadata changed by `change`.
    fn recording(&self, change: impl FnOnce(&mut Value)) -> PathBuf {
        let captures: Vec<Value> = (0..5)
            .map(|k| {
                json!({
                    "core:sample_start": 16 * k,
                    "core:frequency": 94e9,
                    "stairscan:mirror_angle_deg": -1.0 + 0.5 * f64::from(k),
                })
            })
            .collect();
        self.damaged(&captures, json!({}), change)
    }
}

#[test]
fn wrong_values_name_file_and_key() {
    let scratch = Scratch::new("values");
    type Change = fn(&mut Value);
    let global: &[(Change, &[&str])] = &[
        (
            |m| m["global"]["core:datatype"] = json!("cf32_le"),
            &["core:datatype", "cf32_le", "ci16_le"],
        ),
        (
            |m| m["global"]["stairscan:samples_per_chirp"] = json!(0),
            &["samples_per_chirp", "16 to 256"],
        ),
        (
            |m| m["global"]["stairscan:samples_per_chirp"] = json!(257),
            &["samples_per_chirp", "257"],
        ),
        (
            |m| m["global"]["stairscan:bandwidth_hz"] = json!(0),
            &["bandwidth_hz", "found 0"],
        ),
        (
            |m| m["global"]["stairscan:bandwidth_hz"] = json!("wide"),
            &["bandwidth_hz", "wide"],
        ),
        (
            |m| m["global"]["stairscan:scan_plane"] = json!("width"),
            &["scan_plane", "depth", "height"],
        ),
        (
            |m| m["global"]["stairscan:mount_height_m"] = json!(-1),
            &["mount_height_m", "found -1"],
        ),
        (
            |m| {
                drop(
                    m["global"]
                        .as_object_mut()
                        .unwrap()
                        .remove("stairscan:beamwidth_deg"),
                )
            },
            &["beamwidth_deg", "missing"],
        ),
        (
            |m| drop(m.as_object_mut().unwrap().remove("global")),
            &["global"],
        ),
    ];
    let captures: &[(Change, &[&str])] = &[
        (
            |m| m["captures"][2]["stairscan:mirror_angle_deg"] = Value::Null,
            &["captures[2]", "mirror_angle_deg", "null"],
        ),
        (
            |m| m["captures"][2]["stairscan:mirror_angle_deg"] = json!(-0.5),
            &["captures[2]", "order"],
        ),
        (
            |m| m["captures"][3]["stairscan:mirror_angle_deg"] = json!(-0.9),
            &["captures[3]", "order"],
        ),
        (
            |m| m["captures"][1]["stairscan:mirror_angle_deg"] = json!(-1.0),
            &["captures[1]", "order"],
        ),
        (
            |m| m["captures"][4]["core:sample_start"] = json!(63),
            &["captures[4]", "sample_start", "64"],
        ),
        (
            |m| m["captures"][3]["stairscan:mirror_angle_deg"] = json!(0.65),
            &["captures[3]", "mirror_angle_deg", "0.65"],
        ),
    ];
    for (change, words) in global.iter().chain(captures) {
        let recording = scratch.recording(change);
        let file: &[&str] = &["bad.sigmf-meta"];
        refused(&recording, &[file, words].concat());
    }
}

#[test]
fn a_nan_is_no_json_and_still_has_a_name() {
    let scratch = Scratch::new("nan");
    let recording = scratch.recording(|_| ());
    let meta = scratch.path().join("bad.sigmf-meta");
    let text = fs::read_to_string(&meta).unwrap();
    let angle = "\"stairscan:mirror_angle_deg\":";
    fs::write(
        &meta,
        text.replace(&format!("{angle}0.5"), &format!("{angle}NaN")),
    )
    .unwrap();
    refused(
        &recording,
        &["bad.sigmf-meta", "stairscan:mirror_angle_deg", "line 1"],
    );
}

#[test]
fn wrong_lengths_name_the_data_file() {
    let scratch = Scratch::new("lengths");
    let recording = scratch.recording(|_| ());
    let data = scratch.path().join("bad.sigmf-data");
    for bytes in [0, 319, 316, 324, 640] {
        fs::write(&data, vec![0u8; bytes]).unwrap();
        refused(
            &recording,
            &["bad.sigmf-data", &format!("{bytes} bytes"), "320"],
        );
    }
    fs::remove_file(&data).unwrap();
    refused(&recording, &["bad.sigmf-data"]);
    fs::remove_file(scratch.path().join("bad.sigmf-meta")).unwrap();
    refused(&recording, &["bad.sigmf-meta"]);
}

#[test]
fn a_radar_without_a_mirror_cannot_scan_but_has_profiles() {
    let scratch = Scratch::new("no-mirror");
    let recording = scratch.recording(|m| {
        let global = m["global"].as_object_mut().unwrap();
        global.retain(|key, _| {
            key.starts_with("core:") || key.contains("bandwidth") || key.contains("samples")
        });
        m["captures"] = json!([{"core:sample_start": 0}]);
    });
    refused(
        &recording,
        &["bad.sigmf-meta", "mirror_offset_m", "missing"],
    );
    let out = sim(&["profile", recording.to_str().unwrap(), "--format", "json"]);
    assert_eq!(
        out.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&out.stderr)
    );
}

#[test]
fn times_beyond_the_scanner_s_clock_are_refused() {
    let scratch = Scratch::new("times");
    for late in [1e9, 1e300] {
        let recording = scratch.recording(|m| {
            for k in 0..5 {
                m["captures"][k]["stairscan:travel_m"] = json!(0.0);
                m["captures"][k]["stairscan:time_s"] = json!(late * k as f64);
            }
        });
        refused(
            &recording,
            &["captures[1]", "stairscan:time_s", "from 0 to 3600"],
        );
    }
}

#[test]
fn times_that_stand_still_or_run_backwards_are_refused() {
    let scratch = Scratch::new("times-stand");
    for (times, words) in [
        (
            [0.2; 5],
            "captures[4] stairscan:time_s: found 0.2, expected seconds above 0.2",
        ),
        (
            [0.0, 0.1, 0.2, 0.1, 0.3],
            "captures[3] stairscan:time_s: found 0.1, expected seconds from 0.2",
        ),
    ] {
        let recording = scratch.recording(|m| {
            for (k, time) in times.into_iter().enumerate() {
                m["captures"][k]["stairscan:travel_m"] = json!(0.0);
                m["captures"][k]["stairscan:time_s"] = json!(time);
            }
        });
        refused(&recording, &["bad.sigmf-meta", words]);
    }
}

#[test]
fn absurd_sweeps_have_pictures_or_words() {
    let scratch = Scratch::new("absurd");
    let plots = scratch.path().join("plots");
    for bandwidth in [1e3, 1e4, 1e8, 2e12] {
        for distance in [-1e300, 1e300] {
            let recording = scratch.recording(|m| {
                m["global"]["stairscan:bandwidth_hz"] = json!(bandwidth);
                let step = json!({"distance_m": distance, "height_m": 0.2});
                m["global"]["stairscan:truth"] = json!({"direction": "up", "steps": [step]});
            });
            let (recording, plots) = (recording.to_str().unwrap(), plots.to_str().unwrap());
            for command in ["replay", "inspect"] {
                let out = sim(&[command, recording, "--plots", plots, "--force"]);
                let message = String::from_utf8(out.stderr).unwrap();
                let ended = matches!(out.status.code(), Some(0 | 1));
                assert!(
                    ended && !message.contains("panicked"),
                    "{bandwidth}: {message}"
                );
            }
        }
    }
}

#[test]
fn one_bad_recording_does_not_stop_the_batch() {
    let scratch = Scratch::new("batch");
    let bad = scratch.recording(|m| m["global"]["core:datatype"] = json!("ru8"));
    let good = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings/stair_a");
    let (bad, good) = (bad.to_str().unwrap(), good.to_str().unwrap());
    let out = sim(&["replay", bad, good, "--format", "json"]);
    assert_eq!(out.status.code(), Some(1));
    assert_eq!(String::from_utf8(out.stdout).unwrap().lines().count(), 1);
}

#[test]
fn a_directory_without_recordings() {
    let scratch = Scratch::new("empty");
    let out = sim(&["score", scratch.path().to_str().unwrap()]);
    let message = String::from_utf8(out.stderr).unwrap();
    assert_eq!(out.status.code(), Some(1), "{message}");
    assert!(message.contains("holds no recording"), "{message}");
    let out = sim(&["score", scratch.path().join("nowhere").to_str().unwrap()]);
    assert_eq!(out.status.code(), Some(1));
    assert_eq!(sim(&["replay"]).status.code(), Some(2));
}

#[cfg(unix)]
#[test]
fn devices_are_no_recordings() {
    let scratch = Scratch::new("devices");
    let recording = scratch.recording(|_| ());
    for suffix in ["sigmf-data", "sigmf-meta"] {
        let file = recording.with_extension(suffix);
        fs::remove_file(&file).unwrap();
        std::os::unix::fs::symlink("/dev/zero", &file).unwrap();
        let words = [&format!("bad.{suffix}")[..], "expected a regular file"];
        refused(&recording, &words);
    }
    let out = sim(&["simulate", "/dev/zero", "-o", "nowhere"]);
    let message = String::from_utf8(out.stderr).unwrap();
    assert_eq!(out.status.code(), Some(1));
    assert!(
        message.contains("/dev/zero: expected a regular file"),
        "{message}"
    );
}

#[test]
fn a_recording_without_a_name_is_not_written() {
    let scratch = Scratch::new("nameless");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/stair_a.toml");
    let scene = scene.to_str().unwrap();
    let dir = format!("{}/", scratch.path().display());
    for name in ["/", &dir, ".."] {
        let out = sim(&["simulate", scene, "-o", name]);
        let message = String::from_utf8(out.stderr).unwrap();
        assert_eq!(out.status.code(), Some(1), "{name}");
        assert!(message.contains("expected the name of a file"), "{message}");
    }
    assert_eq!(fs::read_dir(scratch.path()).unwrap().count(), 0);
}

#[cfg(unix)]
#[test]
fn a_name_that_is_no_utf_8_is_kept() {
    use std::os::unix::ffi::OsStrExt as _;
    let scratch = Scratch::new("bytes");
    let good = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings/empty");
    let recording = host_sim::recording::Recording::read(&good).unwrap();
    let name = scratch.path().join(std::ffi::OsStr::from_bytes(b"r\xFFd"));
    recording.write(&name).unwrap();
    let back = host_sim::recording::Recording::read(&name).unwrap();
    assert_eq!(back.samples, recording.samples);
}

#[test]
fn a_misspelt_key_is_reported() {
    let scratch = Scratch::new("misspelt");
    for (key, value, meant) in [
        ("stairscan:scan", json!(1), "stairscan:scans"),
        ("stairscan:thruth", json!({}), "stairscan:truth"),
        ("stairscan:pitch_degs", json!(1.5), "stairscan:pitch_deg"),
    ] {
        let recording = scratch.recording(|m| m["global"][key] = value);
        refused(&recording, &[key, "no such key", meant]);
    }
    let recording = scratch.recording(|m| {
        let capture = m["captures"][3].as_object_mut().unwrap();
        let angle = capture.remove("stairscan:mirror_angle_deg").unwrap();
        capture.insert("stairscan:mirror_angel_deg".into(), angle);
    });
    let printed = ["captures[3] stairscan:mirror_angel_deg", "no such key"];
    refused(&recording, &printed);
    // Unknown keys of other programs are accepted.
    let recording = scratch.recording(|m| m["global"]["stairscan:operator"] = json!("me"));
    let done = sim(&["profile", recording.to_str().unwrap()]);
    let message = String::from_utf8(done.stderr).unwrap();
    assert!(!message.contains("no such key"), "{message}");
}

#[test]
fn files_of_another_kind_are_distinguished() {
    let scratch = Scratch::new("other-kinds");
    let file = |name: &str, bytes: &[u8]| {
        let path = scratch.path().join(name);
        fs::write(&path, bytes).unwrap();
        path.display().to_string()
    };
    let header = "{'descr': '<c8', 'fortran_order': False, 'shape': (0, 200), }";
    let mut none = b"\x93NUMPY\x01\x00".to_vec();
    none.extend((header.len() as u16).to_le_bytes());
    none.extend(header.bytes());
    let setup = "adc_bits = 16\nlanes = 2\nreceivers = 1\nreceiver = 0\nsamples_per_chirp = 4\n\
                 chirps_per_frame = 2\ncomplex = true\n";
    file("capture.toml", setup.as_bytes());
    let [archive, empty, none, capture] = [
        file("chirps.npz", b"PK"),
        file("empty.npy", b""),
        file("none.npy", &none),
        file("capture.bin", b""),
    ];
    let out = scratch.path().join("out").display().to_string();
    for (path, words) in [
        (&archive, "an archive of arrays: expected one array"),
        (&empty, "empty: expected an array of numpy"),
        (&none, "shape [0, 200]: the array is empty"),
        (&capture, "empty: expected frames of 32 bytes"),
    ] {
        let done = sim(&["convert", path, "-o", &out]);
        let message = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(1), "{message}");
        let begins = message.starts_with(&format!("error: {path}: "));
        assert!(begins && message.contains(words), "{message}");
    }
}

#[test]
fn what_is_no_image_is_reported_before_the_emulator_starts() {
    let recording = concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/empty");
    let here = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    for (elf, words) in [
        (env!("CARGO_BIN_EXE_host-sim"), "no ELF file for ARM"),
        (here, "no ELF file"),
        ("/no/such/file", "No such file"),
    ] {
        let done = sim(&["emulate", recording, "--elf", elf]);
        let message = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(1), "{message}");
        let begins = message.starts_with(&format!("error: {elf}: "));
        assert!(begins && message.contains(words), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}

/// A recording that the image cannot scan is refused before the image is built.
#[test]
fn emulate_refuses_bad_arguments_before_it_builds() {
    let path = |name: &str| format!("{}/../recordings/{name}", env!("CARGO_MANIFEST_DIR"));
    let (guard, empty) = (path("guard_kerb"), path("empty"));
    let here = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    for (args, words) in [
        (&["/no/such/recording"][..], "No such file"),
        (&[here], "no recording"),
        (&["/no/such/recording", "/no/other"], "No such file"),
        (
            &[&empty, &guard, "--live"],
            "--live: expected one recording, found 2",
        ),
        (
            &[&guard, "--single"],
            "--single: expected full scans, found guard sweeps",
        ),
        (
            &[&guard, "--scans", "99"],
            "99 scans: the recording holds 6",
        ),
        (&[&guard, "--estimator", "paper"], "guard: estimator"),
        (&[&empty, "--live", "--record", here], "File exists"),
    ] {
        let done = Command::new(env!("CARGO_BIN_EXE_host-sim"))
            .arg("emulate")
            .args(args)
            .env("CARGO", "/no/cargo")
            .output()
            .unwrap();
        let message = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(1), "{args:?}: {message}");
        assert!(message.contains(words), "{args:?}: {message}");
        assert!(!message.contains("cargo build"), "{args:?}: {message}");
    }
}

#[test]
fn the_manual_names_one_program() {
    let scratch = Scratch::new("manual");
    let dir = scratch.path().to_str().unwrap();
    assert!(sim(&["man", dir]).status.success());
    let pages = fs::read_dir(scratch.path()).unwrap();
    let pages: Vec<String> = pages
        .map(|p| fs::read_to_string(p.unwrap().path()).unwrap())
        .collect();
    assert!(pages.len() > 20);
    for page in pages {
        assert!(
            page.contains("host\\-sim") || page.contains("host-sim"),
            "{page}"
        );
        assert!(!page.contains("cargo sim"), "{page}");
    }
}
