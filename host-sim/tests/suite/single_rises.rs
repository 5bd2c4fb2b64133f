//! Shows that the echo at the foot does not distinguish a kerb from a wall: in the simulator its level is the same.

use std::f64::consts::TAU;

use host_sim::scene::Scene;

/// Height of the mirror above the ground and its distance from the radar, metres: defaults of scenes.
const MIRROR_M: [f64; 2] = [0.40, 0.22];
/// Range of one cycle a chirp, metres: c/2B with 10 GHz.
const CYCLE_M: f64 = 0.014_99;

/// Returns the maximum power over all rows at the range of the foot of a single rise on level concrete, dB: median of
/// five surfaces.
fn level_db(rise_m: f64, distance_m: f64) -> f64 {
    let scene = Scene::parse(&format!(
        "[[floor]]\nmaterial = \"concrete\"\n[[stairs]]\ncount = 1\ndistance_m = {distance_m}\nrise_m = {rise_m}\n\
         going_m = 1.5\nnosing_radius_m = 0.002\nmaterial = \"concrete\"\n"
    ))
    .unwrap();
    let cycles = (distance_m.hypot(MIRROR_M[0]) + MIRROR_M[1]) / CYCLE_M;
    let mut levels: Vec<f64> = (0..5)
        .map(|seed| {
            let recording = scene.simulate("rise", seed);
            let chirps = recording.samples.chunks(recording.meta.samples_per_chirp);
            let power = chirps.map(|chirp| {
                let (mut re, mut im) = (0.0, 0.0);
                for (n, s) in chirp.iter().enumerate() {
                    let x = n as f64 / chirp.len() as f64;
                    let hann = 0.5 - 0.5 * (TAU * x).cos();
                    let (sin, cos) = (TAU * cycles * x).sin_cos();
                    let (i, q) = (f64::from(s.i), f64::from(s.q));
                    re += hann * (i * cos + q * sin);
                    im += hann * (q * cos - i * sin);
                }
                re * re + im * im
            });
            10.0 * power.fold(0.0, f64::max).log10()
        })
        .collect();
    levels.sort_by(f64::total_cmp);
    levels[2]
}

/// From a height of 4 cm on, the first Fresnel zone of 3 mm waves at 1 m, a dihedral's echo no longer grows with its
/// height.
#[test]
fn a_foots_echo_is_as_strong_before_a_kerb_as_before_a_high_riser() {
    for distance_m in [0.9, 1.4] {
        let [sill, low, kerb, high] =
            [0.01, 0.045, 0.075, 0.14].map(|rise_m| level_db(rise_m, distance_m));
        println!("{distance_m} m: {sill:.1} {low:.1} {kerb:.1} {high:.1} dB");
        assert!((kerb - high).abs() < 3.0 && (low - high).abs() < 5.0);
        assert!(sill < high - 4.0);
    }
}
