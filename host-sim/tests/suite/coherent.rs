//! Tests of the coherent image: from the simulated radar's chirps to echoes and pictures.

use std::fs;
use std::path::Path;

use host_sim::coherent::CoherentView;
use host_sim::recording::Recording;
use host_sim::replay::{self, Options};
use host_sim::scene::Scene;
use serde_json::Value;
use stairscan::signal::echoes::Echoes;

use crate::common::{Scratch, sim};

/// Simulates stair A, with the radar unchanged or without Q.
fn simulated(real: bool) -> Recording {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/stair_a.toml");
    let text = fs::read_to_string(file).unwrap();
    let text = format!("{text}\n[radar]\nreal = {real}\n");
    Scene::parse(&text).unwrap().simulate("stair_a", 0)
}

/// Returns the coherent echoes of a recording.
fn echoes(recording: &Recording, backwards: bool) -> Echoes {
    let mut found = None;
    let options = Options {
        backwards,
        coherent: true,
        ..Options::default()
    };
    let look = |scanned: &replay::Scanned<'_>| {
        found = CoherentView::of(scanned).map(|view| view.echoes.clone());
    };
    replay::answers(recording, &options, look).unwrap();
    found.unwrap()
}

/// Whether an echo lies within 8 mm and 1.5 cm of the point.
fn has(echoes: &Echoes, x_m: f32, y_m: f32) -> bool {
    let near = |e: &stairscan::signal::echoes::Echo| {
        (e.x_m - x_m).abs() < 0.008 && (e.y_m - y_m).abs() < 0.015
    };
    echoes.iter().any(near)
}

#[test]
fn corners_edge_and_flash_of_stairs_are_echoes_in_complex_and_real_samples() {
    for (real, backwards) in [(false, false), (false, true), (true, false), (true, true)] {
        let found = echoes(&simulated(real), backwards);
        for (x_m, y_m) in [(0.5, 0.0), (0.5, 0.165), (0.78, 0.165), (1.06, 0.37)] {
            let case = format!("real {real}, backwards {backwards}: {x_m} {y_m}");
            assert!(has(&found, x_m, y_m), "{case}: {found:?}");
        }
    }
}

#[test]
fn inspect_shows_the_coherent_image_in_every_form() {
    let scratch = Scratch::new("coherent");
    let dir = scratch.path().to_str().unwrap();
    let recording = concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/stair_a");
    let run = |args: &[&str]| {
        let out = sim(&[&["inspect", recording, "--coherent"], args].concat());
        assert!(out.status.success(), "{args:?}: {out:?}");
        String::from_utf8(out.stdout).unwrap()
    };
    let text = run(&["--plots", dir]);
    assert!(text.contains("coherent image: noise -"), "{text}");
    for name in ["inspect", "power", "coherent"] {
        let file = scratch.path().join(format!("stair_a-{name}.png"));
        assert!(
            text.contains(file.to_str().unwrap()) && file.exists(),
            "{text}"
        );
    }
    let json: Value = serde_json::from_str(&run(&["--format", "json"])).unwrap();
    let scatterers = json["coherent"]["scatterers"].as_array().unwrap();
    assert!(scatterers.len() > 8, "{scatterers:?}");
    assert!(scatterers[0]["range_m"].is_f64() && json["coherent"]["noise_dbfs"].is_f64());
}
