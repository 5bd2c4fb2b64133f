//! Phases from row to row: what vibrations, run-out, drifts and jitter do to a target's echo and to the mirror's own.

use core::f64::consts::{PI, TAU};

use num_complex::Complex64;

use super::Scene;
use super::maths::{LIGHT, cis};
use crate::recording::Recording;

/// Scene text without noise and errors: a small plate that faces the mirror, [`RANGE_M`] away and [`BELOW_DEG`] below it.
const SCENE: &str = "[mirror]\njitter_deg = 0.0\nrunout_m = 0.0\nMIRROR\n\
                     [receiver]\nnoise_figure_db = -100.0\nadc_bits = 16\nfull_scale_dbm = -50.0\n\
                     leakage_dbfs = -200.0\nmirror_echo_dbfs = -20.0\ndc_i = 0.0\ndc_q = 0.0\niq_gain_db = 0.0\n\
                     iq_phase_deg = 0.0\nphase_noise_dbc_hz = -300.0\nRECEIVER\n[mount]\nMOUNT\n";
/// Range of the plate from the mirror, metres.
const RANGE_M: f64 = 1.5;
/// Distance from radar to mirror, metres.
const OFFSET_M: f64 = 0.22;
/// Angle of the plate below the horizontal, degrees.
const BELOW_DEG: f64 = 10.0;
/// Rows whose beam lights the plate.
const ROWS: core::ops::Range<usize> = 112..129;
/// Phase of an echo per metre of range, radians, and time of a row per index, s.
const WAVE: f64 = 2.0 * TAU * 94e9 / LIGHT;
const ROW_S: f64 = 4.63e-3;

/// Phases of the plate's echo and of the mirror's own echo in one row, as complex numbers of magnitude 1.
#[derive(Clone, Copy)]
struct Turned {
    target: Complex64,
    own: Complex64,
}

fn scan(mount: &str, mirror: &str, receiver: &str) -> Recording {
    let (sin, cos) = BELOW_DEG.to_radians().sin_cos();
    let (x, y, h) = (RANGE_M * cos, 0.4 - RANGE_M * sin, 0.002);
    let (top, bottom) = ([x - h * sin, y - h * cos], [x + h * sin, y + h * cos]);
    let plate = format!(
        "[[polyline]]\npoints = [{top:?}, {bottom:?}]\nwidth_m = 0.01\nmaterial = \"metal\"\n"
    );
    let text = SCENE.replace("MOUNT", mount).replace("MIRROR", mirror);
    let text = text.replace("RECEIVER", receiver);
    let scene = Scene::parse(&format!("{text}{plate}"));
    scene.unwrap().simulate("scan", 1)
}

/// Returns the amplitude at `range_m` metres from the radar in one row, under a Hann window; its phase is that in the
/// middle of the chirp.
fn amplitude(recording: &Recording, row: usize, range_m: f64) -> Complex64 {
    let beat = 2.0 * range_m * 10e9 / LIGHT / 200.0;
    let chirp = recording.chirp(row).unwrap().iter().enumerate();
    let terms = chirp.map(|(n, s)| {
        let window = (PI * (n as f64 + 0.5) / 200.0).sin().powi(2);
        let sample = Complex64::new(f64::from(s.i), f64::from(s.q));
        sample * cis(-TAU * beat * (n as f64 - 99.5)) * window
    });
    terms.sum()
}

/// Returns by how much the echoes of each of [`ROWS`] turn with these keys, compared with a scene without them.
fn turned(mount: &str, mirror: &str, receiver: &str) -> Vec<(usize, Turned)> {
    let (steady, moved) = (scan("", "", ""), scan(mount, mirror, receiver));
    let turn = |row: usize, range_m: f64| {
        let product = amplitude(&moved, row, range_m) * amplitude(&steady, row, range_m).conj();
        product / product.norm_sqr().sqrt()
    };
    let one = |row| {
        let target = turn(row, OFFSET_M + RANGE_M);
        let own = turn(row, OFFSET_M);
        (row, Turned { target, own })
    };
    ROWS.map(one).collect()
}

/// Returns the angle of a phase factor, radians.
fn angle(factor: Complex64) -> f64 {
    factor.im.atan2(factor.re)
}

/// Asserts a phase factor to 0.03 radians.
fn assert_turn(found: Complex64, book_rad: f64, row: usize) {
    let off = angle(found * cis(-book_rad));
    assert!(off.abs() < 0.03, "row {row}: {off:+.3} off {book_rad:.3}");
}

#[test]
fn a_vibrating_chair_turns_echoes_by_its_part_along_them_and_not_the_mirrors_own() {
    let (sin, cos) = BELOW_DEG.to_radians().sin_cos();
    for (up_deg, along) in [(0.0, -cos), (90.0, sin)] {
        let keys = format!(
            "vibration_m = 1e-4\nvibration_hz = 20.0\nvibration_up_deg = {up_deg:?}\n\
             vibration_phase_deg = 30.0\n"
        );
        for (row, turned) in turned(&keys, "", "") {
            let phase = TAU * 20.0 * row as f64 * ROW_S + 30_f64.to_radians();
            assert_turn(turned.target, WAVE * 1e-4 * along * phase.sin(), row);
            assert_turn(turned.own, 0.0, row);
        }
    }
}

#[test]
fn a_shaft_that_runs_out_turns_echoes_and_the_mirrors_own_by_different_amounts() {
    let keys = "shaft_runout_m = 50e-6\nshaft_runout_cycles = 3.0\nshaft_runout_phase_deg = 40.0";
    for (row, turned) in turned("", keys, "") {
        let shaft = (0.25 * row as f64 - 20.0).to_radians();
        let (sin, cos) = (3.0 * shaft + 40_f64.to_radians()).sin_cos();
        assert_turn(turned.own, WAVE * 50e-6 * sin, row);
        assert_turn(turned.target, WAVE * 50e-6 * (sin - cos), row);
    }
}

#[test]
fn a_growing_distance_to_the_mirror_turns_all_echoes_alike() {
    for (row, turned) in turned("", "offset_drift_m_s = 1e-4", "") {
        let book = WAVE * 1e-4 * row as f64 * ROW_S;
        assert_turn(turned.own, book, row);
        assert_turn(turned.target, book, row);
    }
}

#[test]
fn a_drifting_carrier_turns_echoes_in_proportion_to_their_range() {
    for (row, turned) in turned("", "", "carrier_drift_hz_s = 2e7") {
        let per_metre = 2.0 * TAU / LIGHT * 2e7 * row as f64 * ROW_S;
        assert_turn(turned.own, per_metre * OFFSET_M, row);
        assert_turn(turned.target, per_metre * (OFFSET_M + RANGE_M), row);
    }
}

#[test]
fn a_drifting_slope_moves_the_middle_of_the_sweep_by_half() {
    for (row, turned) in turned("", "", "slope_drift_s = 1e-4") {
        let middle_hz = 0.5 * 10e9 * 1e-4 * row as f64 * ROW_S;
        let per_metre = 2.0 * TAU / LIGHT * middle_hz;
        assert_turn(turned.own, per_metre * OFFSET_M, row);
        assert_turn(turned.target, per_metre * (OFFSET_M + RANGE_M), row);
    }
}

#[test]
fn a_jittering_trigger_turns_echoes_by_their_beat_frequency() {
    let rows = turned("", "", "trigger_jitter_s = 2e-7");
    let slope = 10e9 / 1e-3;
    let mut square = 0.0_f64;
    for (row, turned) in &rows {
        let own = angle(turned.own);
        let late_s = own / (2.0 * TAU * OFFSET_M / LIGHT * slope);
        square += late_s * late_s / rows.len() as f64;
        assert_turn(turned.target, own * (OFFSET_M + RANGE_M) / OFFSET_M, *row);
    }
    assert!((1e-7..3e-7).contains(&square.sqrt()), "{}", square.sqrt());
}

#[test]
fn a_random_start_turns_all_echoes_of_a_chirp_alike_and_each_chirp_anew() {
    let rows = turned("", "", "start_phase_deg = 360.0");
    for (row, turned) in &rows {
        assert_turn(turned.target, angle(turned.own), *row);
    }
    let mean: Complex64 = rows.iter().map(|(_, turned)| turned.own).sum();
    assert!(mean.norm_sqr().sqrt() < 0.7 * rows.len() as f64);
}
