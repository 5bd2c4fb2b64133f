//! Shapes and effects of the random scenes, compared with textbooks and geometry.

use core::f64::consts::PI;

use num_complex::Complex64;

use super::beam::Beam;
use super::edge;
use super::maths::{Random, Vec2};
use super::scatter::Echo;
use super::spec::SceneSpec;
use super::textbook::{PERFECT, WAVELENGTH, assert_close, fresnel, scene, sum, windowed};
use super::{Scene, geometry};
use crate::random::{Kind, random};

/// Returns scene text of a step whose foremost edge lies `r` metres away, `below` radians below the mirror, with a
/// nosing `radius` in metres.
fn nose(r: f64, below: f64, radius: f64) -> String {
    let (x, y) = (r * below.cos(), 0.4 - r * below.sin());
    format!(
        "[[stairs]]\ndistance_m = {x}\nbase_m = {}\ncount = 1\nrise_m = 0.6\ngoing_m = 0.5\n\
         tread_thickness_m = 0.5\nnosing_radius_m = {radius}\nwidth_m = 0.02\nlanding_m = 1.5\n\
         material = \"perfect\"\n",
        y - 0.6
    )
}

#[test]
fn a_nose_of_one_or_two_centimetres_is_a_cylinder() {
    // Echo width πρ (Knott, table 5.1); a sharp edge has |f|²/k (Keller), 14 to 20 dB more. The
    // echo comes from the nearest point of the rounding, not from the intersection of the faces.
    let r = 1.5;
    for radius in [0.010, 0.015, 0.020] {
        for below in [25.0_f64, 45.0, 65.0] {
            let t = below.to_radians();
            let round = scene(&nose(r, t, radius));
            let (x, y) = (r * t.cos() + radius, r * t.sin() + radius);
            let range = (x * x + y * y).sqrt() - radius;
            let found = windowed(&round.echoes(1), range);
            let line = (2.0 / WAVELENGTH).sqrt() * 0.02;
            assert_close(found, line * (PI * radius).sqrt(), 0.05, "round nose √σ");
            let sharp = 0.02 * edge::keller(PI - t, 1.5 * PI, true).abs() / PI.sqrt();
            let gain = 20.0 * (found / sharp).log10();
            assert!((10.0..26.0).contains(&gain), "{radius} {below}: {gain} dB");
        }
    }
}

#[test]
fn chords_keep_to_the_arc_of_a_nose_within_a_tenth_of_a_radian() {
    let (up, forward) = (Vec2::new(0.0, 1.0), Vec2::new(1.0, 0.0));
    for radius in [0.002, 0.008, 0.012, 0.020] {
        let arc = geometry::rounded(Vec2::new(0.0, 0.0), up, forward, radius);
        let centre = Vec2::new(radius, -radius);
        for pair in arc.windows(2) {
            let middle = pair[0].towards(pair[1], 0.5);
            let off = radius - (middle - centre).len();
            assert!(4.0 * PI / WAVELENGTH * off < 0.12, "{radius}: {off}");
        }
    }
}

/// Returns the simulated γ of σ° = γ cos θ of a floor of `material`, relief and volume together, dB.
fn gamma(spec: &SceneSpec, material: &str) -> f64 {
    let mut floor = SceneSpec::default();
    let m = &spec.materials[material];
    floor.materials.insert("it".into(), m.clone());
    floor.floor.push(super::spec::FloorSpec {
        from_m: 0.9,
        to_m: Some(1.1),
        height_m: 0.0,
        material: "it".into(),
    });
    floor.mirror.sidelobe_floor_db = 300.0;
    let s = Scene::new(floor).unwrap();
    let r = (1.0_f64 + 0.16).sqrt();
    let width = r * 5.0_f64.to_radians() * (PI / (8.0 * core::f64::consts::LN_2)).sqrt();
    // In cells of a few centimetres, as the radar resolves them, because the relief's echoes add
    // coherently.
    let mut power = 0.0;
    let runs = 10;
    for seed in 0..runs {
        let echoes = s.echoes(seed);
        for cell in 0..9 {
            let middle = 1.00 + 0.02 * f64::from(cell);
            power += cell_power(&echoes, middle);
        }
    }
    let patch = 0.02 * r / 1.0;
    let area = patch * width * 9.0 * runs as f64;
    10.0 * (power / area / (0.4 / r)).log10()
}

/// Returns σ, m², of the cell at `range` metres: power of the sum of the echoes within 1 cm, times r⁴.
fn cell_power(echoes: &[Echo], range: f64) -> f64 {
    let inside = echoes.iter().filter(|e| (e.range - range).abs() < 0.01);
    let sum: Complex64 = inside.map(|e| e.amplitude).sum();
    sum.norm_sqr() * range.powi(4)
}

#[test]
fn carpets_scatter_like_something_between_asphalt_and_grass() {
    // Constant-γ models at W-band: asphalt -20 dB, short grass -8 (Ulaby and Dobson), a few dB to
    // either side. The total scatter of the drawn carpets must lie there.
    let mut seen = 0;
    for seed in 0..12 {
        let spec = random(Kind::Soft, seed);
        if !spec.materials.contains_key("carpet") {
            continue;
        }
        let found = gamma(&spec, "carpet");
        assert!((-24.0..-5.0).contains(&found), "{seed}: γ {found} dB");
        seen += 1;
    }
    assert!(seen > 3);
}

/// Returns scene text of a floating step with a channel as its front, `width` metres wide across the plane. The middle
/// of the front lies `r` metres away and `below` radians below the mirror.
fn channel(r: f64, below: f64, (height, flange): (f64, f64), width: f64, open: bool) -> String {
    let (x, y) = (r * below.cos(), 0.4 - r * below.sin());
    format!(
        "[[stairs]]\nopen = true\ndistance_m = {x}\nbase_m = {}\ncount = 1\nrise_m = 0.3\n\
         going_m = 0.3\nlanding_m = 0.2\ntread_depth_m = 0.2\ntread_thickness_m = 0.01\n\
         channel_m = {height}\nchannel_flange_m = {flange}\nchannel_open = {open}\n\
         width_m = {width}\nmaterial = \"perfect\"\n",
        y + 0.5 * height - 0.3
    )
}

#[test]
fn the_web_of_a_channel_is_a_plate() {
    // σ = 4π (ab)² / λ² (Knott, table 5.1) at the mirror's height.
    let (a, b, r) = (0.024, 0.02, 4.0);
    let s = scene(&channel(r, 0.0, (a, 0.03), b, false));
    let found = windowed(&s.echoes(1), r);
    assert_close(found, 2.0 * PI.sqrt() * a * b / WAVELENGTH, 0.03, "web √σ");
}

#[test]
fn a_channel_that_opens_forward_is_an_inner_corner() {
    // The lower flange and the web from 45° above form a dihedral of two equal faces, if the
    // opening is twice as high as deep, so that the upper flange does not shade it.
    let (wall, depth, b, r) = (super::flight::CHANNEL_WALL, 0.02, 0.12, 4.0);
    let size = (2.0 * depth + 2.0 * wall, depth + wall);
    let t = PI / 4.0;
    let levels = [true, false].map(|open| {
        let s = scene(&channel(r, t, size, b, open));
        windowed(&s.echoes(1), r)
    });
    let book = fresnel((8.0 * PI).sqrt() * depth * b / WAVELENGTH, b, r);
    assert_close(levels[0], book, 0.20, "channel √σ");
    assert!(
        levels[0] > 5.0 * levels[1],
        "its back is no corner: {levels:?}"
    );
}

#[test]
fn treads_with_fall_rise_to_the_next_riser_and_keep_their_edges() {
    let text = "[[stairs]]\ndistance_m = 0.6\ncount = 3\nrise_m = 0.1\ngoing_m = 0.5\ntread_fall = 0.02\n\
                material = \"concrete\"\nlanding_m = 1.0\n";
    let s = Scene::parse(text).unwrap();
    let truth = s.truth();
    let edges: Vec<(f64, f64)> = (truth.steps.iter().chain(&truth.uncounted))
        .map(|s| (s.distance_m, s.height_m))
        .collect();
    assert_eq!(edges, [(0.6, 0.1), (1.1, 0.2), (1.6, 0.3)]);
    for (x, height) in [(0.6, 0.0), (1.1, 0.11), (1.6, 0.21)] {
        let foot = |p: Vec2| (p.x - x).abs() < 1e-9 && (p.y - height).abs() < 1e-9;
        assert!(s.world.segments.iter().any(|g| foot(g.a)), "{x} {height}");
    }
    let end = s.world.segments.iter().map(|g| g.b.y).fold(0.0, f64::max);
    assert!((end - 0.32).abs() < 1e-9, "{end}");
}

/// Returns a scene with an ideal receiver and mirror, the mounting keys `mount` and the shapes `text`.
fn plain(mount: &str, text: &str) -> Scene {
    let perfect = PERFECT.replace("[mount]\nbeamwidth_deg = 30.0\n", "");
    Scene::parse(&format!("{perfect}[mount]\n{mount}\n{text}")).unwrap()
}

/// Returns scene text of a small plate that faces the mirror, 1.5 m away and `below` degrees below it (depth plane).
fn target(below: f64) -> String {
    let (sin, cos) = below.to_radians().sin_cos();
    let (x, y, h) = (1.5 * cos, 0.4 - 1.5 * sin, 0.002);
    format!(
        "[[polyline]]\npoints = [[{}, {}], [{}, {}]]\nwidth_m = 0.01\nmaterial = \"perfect\"\n",
        x - h * sin,
        y - h * cos,
        x + h * sin,
        y + h * cos
    )
}

/// Returns the recorded mirror angle of the strongest echo, and the half-power width of the echo over the mirror angle,
/// degrees.
fn strongest(s: &Scene) -> (f64, f64) {
    let receiver = super::Receiver::new(&s.spec.radar, &s.spec.receiver);
    let tones = s.place(&receiver, &s.echoes(1));
    let power: Vec<f64> = (0..s.angles.len())
        .map(|row| {
            let (_, echo) = s.chirp(
                &receiver,
                &[&tones],
                (row, 0.0),
                &mut Random::new(1, row as u64),
            );
            echo.iter().map(Complex64::norm_sqr).sum()
        })
        .collect();
    let most = power.iter().copied().fold(0.0, f64::max);
    let above: Vec<f64> = (0..power.len())
        .filter(|k| power[*k] > 0.5 * most)
        .map(|k| s.angles[k])
        .collect();
    let (first, last) = (above[0], above[above.len() - 1]);
    (0.5 * (first + last), last - first + s.spec.sweep.step_deg)
}

#[test]
fn a_chair_with_its_nose_up_sees_things_at_larger_mirror_angles() {
    // Beam below the horizontal = mirror angle - pitch. The recording contains the pitch but not
    // its error.
    for (pitch, error) in [(0.0, 0.0), (3.0, 0.0), (-4.0, 0.0), (2.0, 0.5)] {
        let mount = format!("pitch_deg = {pitch}\npitch_error_deg = {error}");
        let s = plain(&mount, &target(10.0));
        let (angle, _) = strongest(&s);
        assert!(
            (angle - (10.0 + pitch + error)).abs() < 0.13,
            "{pitch} {error}: {angle}"
        );
        let recording = s.simulate("pitched", 1);
        assert_eq!(recording.meta.motion.pitch_deg, [pitch; 281]);
    }
    // In the height plane angles count from straight down to the front, so that the same pitch
    // reduces them.
    let s = plain("plane = \"height\"\npitch_deg = 3.0", &target(60.0));
    let (angle, _) = strongest(&s);
    assert!((angle - (30.0 - 3.0)).abs() < 0.13, "{angle}");
    let level = plain("", &target(10.0)).simulate("level", 1);
    assert!(level.meta.motion.pitch_deg.is_empty());
}

#[test]
fn truth_knows_which_angles_a_pitched_scan_reaches() {
    // The last edge lies 16.5° above the mirror: just within half a beam of the end of a level scan.
    let flight = "[[stairs]]\ndistance_m = 0.72\ncount = 3\nrise_m = 0.228\ngoing_m = 0.12\n\
                  material = \"perfect\"\n";
    let counted = |pitch: f64| {
        let s = plain(&format!("pitch_deg = {pitch}"), flight);
        s.truth().steps.len()
    };
    assert_eq!((counted(0.0), counted(-5.0), counted(4.0)), (3, 2, 3));
    // The steps' signal-to-noise ratios are measured at the steps' angles.
    let snr = |mount: &str| {
        let s = plain(mount, flight);
        let truth = s.simulate("a", 1).meta.truth.unwrap();
        truth.steps[0].snr_db.unwrap()
    };
    assert!((snr("") - snr("pitch_deg = 3.0")).abs() < 3.0);
}

#[test]
fn beams_from_three_to_eight_degrees_are_as_wide_as_they_say() {
    for width in [3.0, 5.0, 8.0] {
        let s = plain(&format!("beamwidth_deg = {width}"), &target(10.0));
        let (angle, found) = strongest(&s);
        assert!((angle - 10.0).abs() < 0.13);
        // Two-way: narrower by √2, within a few per cent of a Gaussian beam.
        let book = width * 0.5_f64.sqrt();
        assert!(
            (found / book - 1.0).abs() < 0.08,
            "{width}: {found} of {book}"
        );
    }
}

#[test]
fn a_wall_looked_at_aslant_fades_with_the_beam_twice() {
    // The wall's mirror image of the antenna lies `yaw` off the beam's axis, out and back. Its
    // range is the wall's perpendicular distance, which is shorter than that along the beam by the
    // cosine.
    let wall = "[[wall]]\nat_m = 2.0\nbottom_m = -1.0\ntop_m = 2.0\nmaterial = \"perfect\"\n";
    let level = |yaw: f64| {
        let s = plain(&format!("beamwidth_deg = 5.0\nyaw_deg = {yaw}"), wall);
        let echoes = s.echoes(1);
        let nearest = echoes.iter().map(|e| e.range).fold(9.0, f64::min);
        (sum(&s, &echoes, 0.0).norm_sqr().sqrt(), nearest)
    };
    let (ahead, _) = level(0.0);
    let beam = Beam::new(5.0, 5.0, 20.0, 300.0);
    for yaw in [1.0_f64, 2.0, -3.0] {
        let (found, nearest) = level(yaw);
        let psi = yaw.to_radians();
        let book = ahead * beam.lateral(psi).powi(2) / psi.cos();
        assert_close(found, book, 0.05, "wall looked at aslant");
        assert!((nearest - 2.0 * psi.cos()).abs() < 1e-3, "{nearest}");
    }
}

#[test]
fn what_lies_in_the_plane_of_the_mirror_stays_there_at_any_yaw() {
    // A narrow plate turned with the world keeps its place. Its echo falls as that of an oblique
    // plate: sin x / x with x = k w sin ψ over its width w.
    let ahead = plain("", &target(10.0));
    let peak = |s: &Scene| {
        let e = s.echoes(1);
        (sum(s, &e, 10.0_f64.to_radians()).norm_sqr().sqrt(), e)
    };
    let (full, _) = peak(&ahead);
    let yaw = 4.0_f64;
    let s = plain(&format!("yaw_deg = {yaw}"), &target(10.0));
    let (found, echoes) = peak(&s);
    let (angle, _) = strongest(&s);
    assert!((angle - 10.0).abs() < 0.13, "{angle}");
    let range = echoes.iter().map(|e| e.range).sum::<f64>() / echoes.len() as f64;
    assert!((range - 1.5).abs() < 2e-3, "{range}");
    let x = 2.0 * PI / WAVELENGTH * 0.01 * yaw.to_radians().sin() * 10.0_f64.to_radians().cos();
    assert_close(found / full, (x.sin() / x).abs(), 0.03, "plate aslant");
}

#[test]
fn yaw_leaves_what_scatters_evenly_as_strong_as_it_was() {
    let floor = "[material.dull]\npermittivity = 1.0\nconductivity = 0.0\nroughness_m = 0.0\n\
                 diffuse_db = -10.0\n[[floor]]\nfrom_m = 0.9\nto_m = 1.1\nmaterial = \"dull\"\n";
    let power = |yaw: f64| {
        let s = plain(&format!("beamwidth_deg = 5.0\nyaw_deg = {yaw}"), floor);
        (0..40)
            .map(|seed| {
                let e = s.echoes(seed);
                e.iter().map(|e| e.amplitude.norm_sqr()).sum::<f64>()
            })
            .sum::<f64>()
    };
    assert_close(power(4.0), power(0.0), 0.05, "diffuse power");
}
