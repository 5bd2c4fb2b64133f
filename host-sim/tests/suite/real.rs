//! Tests of recordings with real-valued samples: from the simulated receiver without Q to the
//! answer.

use std::fs;
use std::path::Path;

use host_sim::answer::{Answer, metres};
use host_sim::recording::{META_SUFFIX, Recording, meta_path};
use host_sim::replay::{self, Options};
use host_sim::scene::Scene;
use serde_json::{Value, json};

use crate::common::{Scratch, refused, sim};

/// Simulates a scene of the repository, with the radar unchanged or without Q.
fn simulated(scene: &str, real: bool) -> Recording {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../scenes/{scene}.toml"));
    let text = fs::read_to_string(file).unwrap();
    let text = format!("{text}\n[radar]\nreal = {real}\n");
    Scene::parse(&text).unwrap().simulate(scene, 0)
}

fn answer(recording: &Recording) -> Answer {
    let mut answers = replay::answers(recording, &Options::default(), |_| ()).unwrap();
    answers.remove(0)
}

#[test]
fn real_and_complex_samples_of_a_scene_give_the_same_steps() {
    for (scene, apart_m) in [
        ("stair_a", 0.01),
        ("stair_b", 0.01),
        // Its last edge is accurate to 2 cm, with I and Q and without Q.
        ("descending", 0.02),
    ] {
        let [complex, real] = [false, true].map(|real| answer(&simulated(scene, real)));
        assert!(complex.steps.len() >= 3, "{scene}");
        assert_eq!(real.steps.len(), complex.steps.len(), "{scene}");
        for (a, b) in real.steps.iter().zip(&complex.steps) {
            let x = metres(a.distance) - metres(b.distance);
            let y = metres(a.height) - metres(b.height);
            let off = x.hypot(y);
            assert!(off < apart_m, "{scene}: {off} m: {:?} {:?}", a, b);
        }
        let (real, complex) = (real.scan, complex.scan);
        assert_eq!(real.status, complex.status, "{scene}: {:?}", real.reasons);
        assert_eq!(real.reasons, complex.reasons, "{scene}");
    }
}

#[test]
fn no_stairs_are_none_in_real_samples() {
    let answer = answer(&simulated("empty", true));
    assert!(answer.steps.is_empty(), "{:?}", answer.sentences);
}

#[test]
fn a_recording_of_real_samples_is_read_as_it_was_written() {
    let scratch = Scratch::new("real");
    let path = scratch.path().join("real");
    let recording = simulated("stair_a", true);
    recording.write(&path).unwrap();
    let text = fs::read_to_string(meta_path(&path)).unwrap();
    let meta: Value = serde_json::from_str(&text).unwrap();
    let global = &meta["global"];
    assert_eq!(global["core:datatype"], "ri16_le");
    assert_eq!(global["stairscan:samples_per_chirp"], 400);
    assert_eq!(global["core:sample_rate"], 400e3);
    assert_eq!(meta["captures"][2]["core:sample_start"], 800);
    let again = Recording::read(&path).unwrap();
    assert!(again.meta.real);
    assert_eq!(again.samples, recording.samples);
    assert_eq!(
        again.metadata_text().unwrap(),
        recording.metadata_text().unwrap()
    );
    let out = sim(&["replay", path.to_str().unwrap()]);
    let said = String::from_utf8(out.stdout).unwrap();
    assert!(
        out.status.success() && said.contains("3 steps up"),
        "{said}"
    );
}

#[test]
fn what_needs_i_and_q_refuses_real_samples() {
    let scratch = Scratch::new("real-refused");
    let path = scratch.path().join("real");
    let recording = simulated("stair_a", true);
    recording.write(&path).unwrap();
    let array = scratch.path().join("chirps.npy");
    let paths = [path.to_str().unwrap(), array.to_str().unwrap()];
    let out = sim(&["convert", paths[0], "-o", paths[1]]);
    let printed = String::from_utf8(out.stderr).unwrap();
    assert!(
        !out.status.success() && printed.contains("real samples"),
        "{printed}"
    );
    // With other keys they stay real.
    let other = scratch.path().join("other");
    let out = sim(&[
        "convert",
        paths[0],
        "--description",
        "x",
        "-o",
        other.to_str().unwrap(),
    ]);
    assert!(out.status.success(), "{out:?}");
    let kept = Recording::read(&other).unwrap();
    assert!(kept.meta.real && kept.samples == recording.samples);
    assert!(!array.exists());
}

#[test]
fn a_chirp_of_real_samples_has_an_even_number_of_them() {
    let scratch = Scratch::new("real-odd");
    let path = scratch.path().join("real");
    simulated("stair_a", true).write(&path).unwrap();
    let file = meta_path(&path);
    let text = fs::read_to_string(&file).unwrap();
    for (count, words) in [
        (
            json!(399),
            [
                "samples_per_chirp",
                "399",
                "even number of real samples from 32 to 512",
            ],
        ),
        (json!(514), ["samples_per_chirp", "514", "32 to 512"]),
        (json!(30), ["samples_per_chirp", "30", "32 to 512"]),
        (
            json!(200),
            ["captures[1]", "core:sample_start", "200 samples"],
        ),
    ] {
        let mut meta: Value = serde_json::from_str(&text).unwrap();
        meta["global"]["stairscan:samples_per_chirp"] = count;
        fs::write(&file, meta.to_string()).unwrap();
        refused(&path, &words);
        refused(&path, &[META_SUFFIX]);
    }
    fs::write(&file, &text).unwrap();
    let data = path.with_extension("sigmf-data");
    fs::write(&data, vec![0; 281 * 400 * 2 - 2]).unwrap();
    refused(&path, &["real.sigmf-data", "400 samples of 2 bytes"]);
}
