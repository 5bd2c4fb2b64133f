//! Comparison of simulated amplitudes with textbook values, within the bounds that each test states.

use core::f64::consts::{PI, TAU};

use num_complex::Complex64;

use super::Scene;
use super::edge;
use super::maths::LIGHT;
use super::scatter::Echo;

pub(super) const WAVELENGTH: f64 = LIGHT / 94e9;

/// Scene text of a smooth perfect conductor as material, and of an ideal scanner whose beam is so wide that its weight
/// is nearly constant.
pub(super) const PERFECT: &str = r#"
[material.perfect]
permittivity = 1.0
conductivity = 1e9
roughness_m = 0.0
diffuse_db = -300.0

[mount]
beamwidth_deg = 30.0

[mirror]
jitter_deg = 0.0
sidelobe_floor_db = 300.0
"#;

pub(super) fn scene(text: &str) -> Scene {
    Scene::parse(&format!("{PERFECT}{text}")).unwrap()
}

/// Returns the sum of the echoes with the beam pointing at `angle`, radians.
pub(super) fn sum(scene: &Scene, echoes: &[Echo], angle: f64) -> Complex64 {
    let gain = |e: &Echo| scene.beam.in_plane(angle - e.out) * scene.beam.in_plane(angle - e.back);
    echoes
        .iter()
        .map(|e| e.amplitude * gain(e))
        .fold(Complex64::ZERO, |a, b| a + b)
}

/// Returns the simulated √σ, metres, of an object `range` metres away at `angle` radians.
fn root_sigma(scene: &Scene, range: f64, angle: f64) -> f64 {
    sum(scene, &scene.echoes(1), angle).norm_sqr().sqrt() * range * range
}

pub(super) fn assert_close(found: f64, book: f64, share: f64, what: &str) {
    println!(
        "{what}: {found:.5} of {book:.5}: {:+.2} %",
        100.0 * (found / book - 1.0)
    );
    assert!(
        (found / book - 1.0).abs() < share,
        "{what}: {found}, textbook {book}"
    );
}

/// Returns scene text of a plate of `a` × `b` metres, tilted by `tilt` radians, `x` metres away at the mirror's height.
fn plate(a: f64, b: f64, tilt: f64, x: f64) -> String {
    let (dx, dy) = (0.5 * a * tilt.sin(), 0.5 * a * tilt.cos());
    format!(
        "[[polyline]]\npoints = [[{}, {}], [{}, {}]]\nwidth_m = {b}\nmaterial = \"perfect\"\n",
        x - dx,
        0.4 - dy,
        x + dx,
        0.4 + dy
    )
}

/// Returns √σ, metres, of the echoes near `range`, without those of the surfaces' far ends: under a Hann window of ±15
/// cm.
pub(super) fn windowed(echoes: &[Echo], range: f64) -> f64 {
    let window = |e: &Echo| {
        let d = (e.range - range) / 0.15;
        if d.abs() < 1.0 {
            (0.5 * PI * d).cos().powi(2)
        } else {
            0.0
        }
    };
    let sum = echoes
        .iter()
        .map(|e| e.amplitude * window(e))
        .fold(Complex64::ZERO, |a, b| a + b);
    sum.norm_sqr().sqrt() * range * range
}

#[test]
fn a_flat_plate() {
    // σ = 4π (ab)² / λ² (Knott, table 5.1).
    for (a, b) in [(0.02, 0.02), (0.03, 0.015)] {
        let found = root_sigma(&scene(&plate(a, b, 0.0, 4.0)), 4.0, 0.0);
        assert_close(
            found,
            2.0 * PI.sqrt() * a * b / WAVELENGTH,
            0.05,
            "plate √σ",
        );
    }
}

#[test]
fn a_tilted_plate() {
    // The plate's value times cos θ sin(ka sin θ) / (ka sin θ), on the first side lobes.
    let (a, b) = (0.02, 0.02);
    let k = TAU / WAVELENGTH;
    for lobe in [1.43, 2.46] {
        let tilt = (lobe * PI / (k * a)).asin();
        let found = root_sigma(&scene(&plate(a, b, tilt, 4.0)), 4.0, 0.0);
        let x = k * a * tilt.sin();
        let book = 2.0 * PI.sqrt() * a * b / WAVELENGTH * tilt.cos() * (x.sin() / x).abs();
        assert_close(found, book, 0.15, "tilted plate √σ");
    }
}

#[test]
fn echoes_fall_with_the_square_of_the_range() {
    let near = scene(&plate(0.01, 0.01, 0.0, 1.5));
    let far = scene(&plate(0.01, 0.01, 0.0, 3.0));
    let ratio = sum(&near, &near.echoes(1), 0.0).norm_sqr().sqrt()
        / sum(&far, &far.echoes(1), 0.0).norm_sqr().sqrt();
    assert_close(ratio, 4.0, 0.03, "amplitude at half the range");
}

#[test]
fn a_square_inner_corner() {
    // Dihedral at 45°: σ = 8π a² b² / λ² (Knott, table 5.1), b its length, a a face's width.
    let (a, b, r) = (0.02, 0.02, 4.0);
    let (x, y) = (r * 0.5_f64.sqrt(), 0.4 - r * 0.5_f64.sqrt());
    let text = format!(
        "[[polyline]]\npoints = [[{}, {y}], [{x}, {y}]]\nwidth_m = {b}\nmaterial = \"perfect\"\n\
         [[polyline]]\npoints = [[{x}, {y}], [{x}, {}]]\nwidth_m = {b}\nmaterial = \"perfect\"\n",
        x - a,
        y + a
    );
    // Surfaces less than 10 cm wide are no mirrors and would count only by the factor of
    // reciprocity.
    let wide = text.replace("width_m = 0.02", "width_m = 0.12");
    let found = root_sigma(&scene(&wide), r, PI / 4.0);
    let book = (8.0 * PI).sqrt() * a * 0.12 / WAVELENGTH;
    assert_close(found, fresnel(book, 0.12, r), 0.10, "dihedral √σ");
}

/// Returns the textbook value `book` of √σ for a surface `b` metres wide across the plane at `r` metres, corrected for
/// the curvature of the wave front at short range, which the textbook's plane wave does not have.
pub(super) fn fresnel(book: f64, b: f64, r: f64) -> f64 {
    let k = TAU / WAVELENGTH;
    let steps = 20_000;
    let sum: Complex64 = (0..steps)
        .map(|n| {
            let z = b * ((f64::from(n) + 0.5) / f64::from(steps) - 0.5);
            Complex64::new((k * z * z / r).cos(), (k * z * z / r).sin()) / f64::from(steps)
        })
        .fold(Complex64::ZERO, |a, b| a + b);
    book * sum.norm_sqr().sqrt()
}

#[test]
fn a_large_wall_mirrors_the_antenna() {
    // Image theory: the amplitude of an antenna at twice the distance, √σ / r² = √(4π) / (2r) (the
    // radar equation compared with Friis's at 2r).
    for r in [1.0, 2.0] {
        let s = scene(&format!(
            "[[wall]]\nat_m = {r}\nbottom_m = -1.0\ntop_m = 2.0\nmaterial = \"perfect\"\n"
        ));
        let found = sum(&s, &s.echoes(1), 0.0).norm_sqr().sqrt();
        assert_close(found, (4.0 * PI).sqrt() / (2.0 * r), 0.05, "wall √σ/r²");
    }
}

#[test]
fn a_sharp_edge() {
    // Keller's wedge of 270° free space: a line of echo width |f|²/k, off the normals of both faces. Its
    // length √σ = √(2/λ) L √(|f|²/k) = L f / √π, with the wave front's curvature over that length.
    let (r, b) = (2.0, 0.02);
    let cases = [20.0_f64, 30.0, 55.0].map(|t| [(t, true), (t, false)]);
    for (below, soft) in cases.into_iter().flatten() {
        let t = below.to_radians();
        let (x, y) = (r * t.cos(), 0.4 - r * t.sin());
        let text = format!(
            "[[polyline]]\nclosed = true\nwidth_m = {b}\nmaterial = \"perfect\"\n\
             points = [[{x}, {}], [{x}, {y}], [{}, {y}], [{}, {}]]\n",
            y - 0.9,
            x + 0.7,
            x + 0.7,
            y - 0.9
        );
        let field = if soft { "horizontal" } else { "vertical" };
        let s = scene(&format!("{text}[radar]\npolarisation = \"{field}\"\n"));
        let found = windowed(&s.echoes(1), r);
        let f = edge::keller(PI - t, 1.5 * PI, soft);
        assert_close(found, b * f.abs() / PI.sqrt(), 0.10, "edge √σ");
    }
}

#[test]
fn a_rounded_edge() {
    // A cylinder's echo width is πρ when its radius is above the wavelength (Knott, table 5.1). A
    // post across the plane would do as well; here it is a rounded nosing of 8 mm, seen at 45° from
    // below its tread's horizon, where neither face is near its normal.
    let (r, radius) = (1.5, 0.008);
    let t = 45.0_f64.to_radians();
    let (x, y) = (r * t.cos(), 0.4 - r * t.sin());
    let text = format!(
        "[[stairs]]\ndistance_m = {x}\nbase_m = {}\ncount = 1\nrise_m = 0.6\ngoing_m = 0.5\n\
         tread_thickness_m = 0.5\nnosing_radius_m = {radius}\nwidth_m = 0.02\nlanding_m = 1.5\n\
         material = \"perfect\"\n",
        y - 0.6
    );
    let s = scene(&text);
    let centre = (x + radius, y - radius - 0.4);
    let range = (centre.0 * centre.0 + centre.1 * centre.1).sqrt() - radius;
    let found = windowed(&s.echoes(1), range);
    let book = (2.0 / WAVELENGTH).sqrt() * 0.02 * (PI * radius).sqrt();
    assert_close(found, book, 0.15, "rounded edge √σ");
}

#[test]
fn roughness_takes_from_the_specular_what_ament_says() {
    // Coherent reflection falls with exp(-2 (kσ)²) (Ament, Proc. IRE 41, 1953; normal incidence).
    // The beam is narrow, because the incoherent scatter of the roughness grows with the lit area.
    let wall = "[[wall]]\nat_m = 1.5\nbottom_m = -0.2\ntop_m = 1.0\nmaterial = \"rough\"\n";
    let k = TAU / WAVELENGTH;
    let mut smooth = 0.0;
    for rough in [0.0, 100e-6, 250e-6] {
        let s = Scene::parse(&format!(
            "{wall}[material.rough]\npermittivity = 1.0\nconductivity = 1e9\nroughness_m = {rough}\n\
             correlation_m = 1e-3\ndiffuse_db = -300.0\n"
        ))
        .unwrap();
        let mean = (0..12)
            .map(|seed| sum(&s, &s.echoes(seed), 0.0))
            .fold(Complex64::ZERO, |a, b| a + b)
            / 12.0;
        if rough == 0.0 {
            smooth = mean.norm_sqr().sqrt();
        }
        let book = smooth * (-2.0 * (k * rough).powi(2)).exp();
        assert_close(mean.norm_sqr().sqrt(), book, 0.08, "coherent amplitude");
    }
}

#[test]
fn diffuse_echoes_have_the_power_of_constant_gamma() {
    // σ = γ cos θ per area, lit by the two-way beam: a floor patch between two angles.
    let s = Scene::parse(
        "[material.dull]\npermittivity = 1.0\nconductivity = 0.0\nroughness_m = 0.0\n\
         diffuse_db = -10.0\n[[floor]]\nfrom_m = 0.9\nto_m = 1.1\nmaterial = \"dull\"\n",
    )
    .unwrap();
    let runs = 40;
    let power: f64 = (0..runs)
        .map(|seed| {
            let echoes = s.echoes(seed);
            echoes
                .iter()
                .map(|e| e.amplitude.norm_sqr() * e.range.powi(4))
                .sum::<f64>()
        })
        .sum::<f64>()
        / f64::from(runs as u32);
    // Effective width across the plane in terms of power: ∫ 2^(-4 (2φ/w)²) dz = r w √(π / (4 ln 2))
    // / 4 … of the two-way beam, whose power is the fourth power of the one-way amplitude.
    let r = (1.0_f64 + 0.16).sqrt();
    let w = 5.0_f64.to_radians();
    let width = r * w * (PI / (8.0 * core::f64::consts::LN_2)).sqrt();
    let book = 0.1 * (0.4 / r) * 0.2 * width;
    assert_close(power, book, 0.05, "diffuse σ");
}

#[test]
fn many_scatterers_make_speckle() {
    // The power of a sum of many random phases is exponential: its mean square is twice its squared
    // mean (Goodman, Speckle Phenomena in Optics, sec. 3.2).
    let s = Scene::parse(
        "[material.coarse]\npermittivity = 1.0\nconductivity = 1e9\nroughness_m = 2e-3\n\
         correlation_m = 2e-3\ndiffuse_db = -300.0\n\
         [[wall]]\nat_m = 1.0\nbottom_m = 0.37\ntop_m = 0.43\nmaterial = \"coarse\"\n",
    )
    .unwrap();
    let powers: Vec<f64> = (0..400)
        .map(|k| sum(&s, &s.echoes(k), 0.0).norm_sqr())
        .collect();
    let mean = powers.iter().sum::<f64>() / 400.0;
    let square = powers.iter().map(|p| p * p).sum::<f64>() / 400.0;
    assert_close(square / (mean * mean), 2.0, 0.2, "speckle's second moment");
}

#[test]
fn the_radar_equation_end_to_end() {
    // Through pattern, beat tones, ADC and a transform: amplitude at full scale against P_r.
    let s = Scene::parse(&format!(
        "{PERFECT}[radar]\nantenna_gain_dbi = 25.0\n[receiver]\nnoise_figure_db = 0.0\nadc_bits = 16\n\
         dc_i = 0.0\ndc_q = 0.0\nleakage_dbfs = -200.0\nmirror_echo_dbfs = -200.0\niq_gain_db = 0.0\n\
         iq_phase_deg = 0.0\nsweep_bow = 0.0\nsweep_ripple = 0.0\nphase_noise_dbc_hz = -200.0\n\
         full_scale_dbm = -60.0\nantialias_cutoff = 9.0\n{}",
        plate(0.02, 0.02, 0.0, 2.0)
    ))
    .unwrap();
    let recording = s.simulate("plate", 1);
    let row = recording
        .meta
        .angles_deg
        .iter()
        .position(|a| *a == 0.0)
        .unwrap();
    let chirp = recording.chirp(row).unwrap();
    let bin = (2.0 + 0.22) * 2.0 * 10e9 / LIGHT / 200.0;
    let tone = chirp
        .iter()
        .enumerate()
        .map(|(n, s)| {
            let turn = -TAU * bin * n as f64;
            Complex64::new(f64::from(s.i), f64::from(s.q)) * Complex64::new(turn.cos(), turn.sin())
        })
        .fold(Complex64::ZERO, |a, b| a + b);
    let found = tone.norm_sqr().sqrt() / 200.0 / 32768.0;
    let sigma = 4.0 * PI * 0.02_f64.powi(4) / (WAVELENGTH * WAVELENGTH);
    let gain = 10_f64.powf(2.5);
    let received = 1e-3 * 10_f64.powf(-1.5) * gain * gain * WAVELENGTH.powi(2) * sigma
        / ((4.0 * PI).powi(3) * 16.0);
    let book = (received / 1e-9).sqrt();
    assert_close(found, book, 0.05, "amplitude at the ADC");
}
