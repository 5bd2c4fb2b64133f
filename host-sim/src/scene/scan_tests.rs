//! Whole scans: effects of the mirror, ground truth, and repeatability.

use core::f64::consts::{PI, TAU};

use num_complex::Complex64;
use stairscan::config::Plane;

use super::Scene;
use super::maths::LIGHT;
use crate::recording::Recording;

/// Scene text of a receiver with negligible noise and errors.
const QUIET: &str = "[receiver]\nnoise_figure_db = -100.0\nadc_bits = 16\nfull_scale_dbm = -50.0\n\
                     leakage_dbfs = -200.0\nmirror_echo_dbfs = -200.0\ndc_i = 0.0\ndc_q = 0.0\n";

/// Returns scene text of a small plate that faces the mirror: 1.5 m away, 10° below it.
fn target() -> String {
    let (sin, cos) = (10.0_f64).to_radians().sin_cos();
    let (x, y, h) = (1.5 * cos, 0.4 - 1.5 * sin, 0.002);
    format!(
        "[[polyline]]\npoints = [[{}, {}], [{}, {}]]\nwidth_m = 0.01\nmaterial = \"metal\"\n",
        x - h * sin,
        y - h * cos,
        x + h * sin,
        y + h * cos
    )
}

fn scan(text: &str, seed: u64) -> Recording {
    Scene::parse(text).unwrap().simulate("scan", seed)
}

/// Returns, for every chirp in the order of the recording, the amplitude at `range` metres from the mirror, under a
/// Hann window.
fn profile(recording: &Recording, range: f64) -> Vec<f64> {
    let f = 2.0 * (range + 0.22) * 10e9 / LIGHT / 200.0;
    let one = |k: usize| {
        let chirp = recording.chirp(k).unwrap();
        let sum = chirp.iter().enumerate().map(|(n, s)| {
            let window = (PI * (n as f64 + 0.5) / 200.0).sin().powi(2);
            let turn = -TAU * f * n as f64;
            Complex64::new(f64::from(s.i), f64::from(s.q))
                * Complex64::new(turn.cos(), turn.sin())
                * window
        });
        sum.fold(Complex64::ZERO, |a, b| a + b).norm_sqr().sqrt()
    };
    (0..recording.chirps()).map(one).collect()
}

/// Returns the two angles at which the profile crosses half its maximum power, degrees.
fn half_power(recording: &Recording, profile: &[f64]) -> (f64, f64) {
    let half = profile.iter().copied().fold(0.0, f64::max) * 0.5_f64.sqrt();
    let above: Vec<usize> = (0..profile.len()).filter(|k| profile[*k] >= half).collect();
    let cross = |a: usize, b: usize| {
        let t = (half - profile[a]) / (profile[b] - profile[a]);
        recording.meta.angles_deg[a]
            + t * (recording.meta.angles_deg[b] - recording.meta.angles_deg[a])
    };
    let (first, last) = (above[0], above[above.len() - 1]);
    (cross(first - 1, first), cross(last + 1, last))
}

#[test]
fn the_two_way_beam_is_as_wide_as_its_pattern_squared() {
    let recording = scan(
        &format!("[mirror]\njitter_deg = 0.0\n{QUIET}{}", target()),
        1,
    );
    let (low, high) = half_power(&recording, &profile(&recording, 1.5));
    // Half the two-way power is 2^-1/4 of the one-way amplitude: ±1.79° for a Gaussian beam of 5°,
    // and within a few per cent of that for any pattern.
    assert!((0.5 * (low + high) - 10.0).abs() < 0.03, "{low} {high}");
    assert!(
        ((high - low) / (5.0 * 0.5_f64.sqrt()) - 1.0).abs() < 0.05,
        "{}",
        high - low
    );
}

#[test]
fn a_bias_shifts_what_is_seen() {
    let text = format!(
        "[mirror]\njitter_deg = 0.0\nbias_deg = 0.6\n{QUIET}{}",
        target()
    );
    let recording = scan(&text, 1);
    let (low, high) = half_power(&recording, &profile(&recording, 1.5));
    assert!((0.5 * (low + high) - 9.4).abs() < 0.03, "{low} {high}");
}

#[test]
fn jitter_moves_every_chirp_by_its_deviation() {
    let still = scan(
        &format!("[mirror]\njitter_deg = 0.0\n{QUIET}{}", target()),
        1,
    );
    let smooth = profile(&still, 1.5);
    let text = format!("[mirror]\njitter_deg = 0.1\n{QUIET}{}", target());
    let scene = Scene::parse(&text).unwrap();
    // On the flanks, an amplitude error δ is an angle error of δ over the slope.
    let mut squares = Vec::new();
    for seed in 0..12 {
        let shaken = profile(&scene.simulate("scan", seed), 1.5);
        for k in 1..smooth.len() - 1 {
            let slope = (smooth[k + 1] - smooth[k - 1]) / 0.5;
            let peak = smooth.iter().copied().fold(0.0, f64::max);
            if slope.abs() > 0.15 * peak {
                squares.push(((shaken[k] - smooth[k]) / slope).powi(2));
            }
        }
    }
    let deviation = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!(
        (deviation / 0.1 - 1.0).abs() < 0.15,
        "{deviation} of {}",
        squares.len()
    );
}

#[test]
fn leakage_and_mirror_echo_lie_at_their_ranges() {
    let text = format!("{QUIET}{}", target())
        .replace(
            "leakage_dbfs = -200.0",
            "leakage_dbfs = -20.0\nleakage_range_m = 0.1",
        )
        .replace("mirror_echo_dbfs = -200.0", "mirror_echo_dbfs = -30.0");
    let recording = scan(&text, 1);
    for (range, level) in [(0.1, -20.0), (0.22, -30.0)] {
        let found = profile(&recording, range - 0.22)[140] / 100.0 / 32768.0;
        assert!(
            (20.0 * found.log10() - level).abs() < 0.3,
            "{range}: {found}"
        );
    }
}

#[test]
fn the_mirrors_echo_turns_with_its_run_out() {
    let text = format!("[mirror]\nrunout_m = 40e-6\n{QUIET}{}", target())
        .replace("mirror_echo_dbfs = -200.0", "mirror_echo_dbfs = -20.0");
    let recording = scan(&text, 1);
    let f = 2.0 * 0.22 * 10e9 / LIGHT / 200.0;
    let phase = |k: usize| {
        let chirp = recording.chirp(k).unwrap().iter().enumerate();
        let sum = chirp
            .map(|(n, s)| {
                let turn = -TAU * f * n as f64;
                Complex64::new(f64::from(s.i), f64::from(s.q))
                    * Complex64::new(turn.cos(), turn.sin())
            })
            .fold(Complex64::ZERO, |a, b| a + b);
        sum.im.atan2(sum.re)
    };
    // 2k · 40 µm · (sin 50° + sin 20°) from one end of the scan to the other.
    let book = 2.0 * TAU / (LIGHT / 94e9)
        * 40e-6
        * (50_f64.to_radians().sin() + 20_f64.to_radians().sin());
    assert!(
        ((phase(280) - phase(0)) / book - 1.0).abs() < 0.05,
        "{} {book}",
        phase(280) - phase(0)
    );
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let text = "[[stairs]]\ndistance_m = 0.6\ncount = 2\nrise_m = 0.17\ngoing_m = 0.29\n\
                material = \"concrete\"\n[[floor]]\nmaterial = \"concrete\"\n";
    let scene = Scene::parse(text).unwrap();
    let here = scene.simulate("a", 5);
    let there = std::thread::scope(|s| {
        let spawn = |seed| {
            s.spawn({
                let scene = &scene;
                move || scene.simulate("a", seed)
            })
        };
        let (five, six) = (spawn(5), spawn(6));
        (five.join().unwrap(), six.join().unwrap())
    });
    assert_eq!(here.samples, there.0.samples);
    assert_eq!(here.meta.truth, there.0.meta.truth);
    assert_ne!(here.samples, there.1.samples);
}

#[test]
fn what_cannot_be_seen_is_not_counted() {
    // The third edge lies 18.3° above the mirror, where the scan ends within the beam's half width;
    // a high wall hides everything behind it.
    let flight = "[[stairs]]\ndistance_m = 0.5\ncount = 3\nrise_m = 0.215\ngoing_m = 0.12\n\
                  material = \"metal\"\n";
    let truth = scan(flight, 1).meta.truth.unwrap();
    assert_eq!((truth.steps.len(), truth.uncounted.len()), (2, 1));
    assert_eq!(truth.direction, "up");
    assert_eq!(
        (truth.steps[1].distance_m, truth.steps[1].height_m),
        (0.62, 0.43)
    );
    assert!(
        truth
            .steps
            .iter()
            .all(|s| s.snr_db.is_some_and(|snr| snr > 20.0))
    );
    assert!((truth.uncounted[0].height_m - 0.645).abs() < 1e-9);
    let hidden = format!("{flight}[[wall]]\nat_m = 0.4\nmaterial = \"metal\"\n");
    let truth = scan(&hidden, 1).meta.truth.unwrap();
    assert_eq!((truth.steps.len(), truth.uncounted.len()), (0, 3));
    assert_eq!(truth.direction, "none");
}

#[test]
fn steps_down_are_known_by_the_surface_below_the_edge() {
    let text = "[mount]\nplane = \"height\"\nheight_m = 1.1\n[[stairs]]\ndirection = \"down\"\n\
                distance_m = -0.1\ncount = 2\nrise_m = 0.17\ngoing_m = 0.3\nmaterial = \"concrete\"\n";
    let recording = scan(text, 1);
    assert_eq!(recording.meta.mirror.unwrap().plane, Plane::Height);
    let truth = recording.meta.truth.unwrap();
    let steps: Vec<(f64, f64)> = truth
        .steps
        .iter()
        .map(|s| (s.distance_m, s.height_m))
        .collect();
    assert_eq!(steps, [(-0.1, -0.17), (0.2, -0.34)]);
    assert_eq!(truth.direction, "down");
}

#[test]
fn an_overhang_moves_the_riser_and_not_the_edge() {
    let text = "[[stairs]]\ndistance_m = 0.6\ncount = 1\nrise_m = 0.17\ngoing_m = 0.3\nnosing_m = 0.03\n\
                material = \"metal\"\n";
    let scene = Scene::parse(text).unwrap();
    let foremost = scene
        .world
        .segments
        .iter()
        .map(|s| s.a.x)
        .fold(9.0, f64::min);
    assert!((foremost - 0.6).abs() < 1e-12);
    assert!(
        (scene.world.segments[0].a.x - 0.63).abs() < 1e-12,
        "foot of the riser"
    );
    assert_eq!(
        scene.simulate("a", 1).meta.truth.unwrap().steps[0].distance_m,
        0.6
    );
}
