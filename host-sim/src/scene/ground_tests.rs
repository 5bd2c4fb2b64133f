//! Echo levels of the ground of streets and entrances, compared with each other and with Fresnel's reflection
//! coefficients.

use core::f64::consts::PI;

use num_complex::Complex64;

use super::Scene;
use super::scatter::Echo;
use super::textbook::{assert_close, windowed};

/// Scene text of an ideal mirror: no jitter of the beam, and no floor of side lobes.
const STILL: &str = "[mirror]\njitter_deg = 0.0\nsidelobe_floor_db = 300.0\n";

fn scene(text: &str) -> Scene {
    Scene::parse(&format!("{STILL}{text}")).unwrap()
}

/// Returns the mean power |√σ/(r₁r₂)|² of the echoes between two ranges, metres, over 20 draws of the surfaces, dB over
/// 1/m²: Hann windows of ±3 cm at every 1.5 cm, as the radar resolves them.
fn level(text: &str, (near, far): (f64, f64)) -> f64 {
    let scene = scene(text);
    let (runs, cells) = (20, ((far - near) / 0.015) as usize);
    let mut power = 0.0;
    for seed in 0..runs {
        let echoes = scene.echoes(seed);
        for cell in 0..cells {
            power += seen(&echoes, near + 0.015 * cell as f64).norm_sqr();
        }
    }
    10.0 * (power / (f64::from(runs as u32) * cells as f64)).log10()
}

/// Returns the sum of the echoes' complex amplitudes within 3 cm of `range` (metres), weighted by a Hann window.
fn seen(echoes: &[Echo], range: f64) -> Complex64 {
    let weighed = echoes.iter().filter_map(|e| {
        let d = (e.range - range) / 0.03;
        (d.abs() < 1.0).then(|| e.amplitude * (0.5 * PI * d).cos().powi(2))
    });
    weighed.sum()
}

/// Returns the mean power |√σ/(r₁r₂)|² of the echoes within 3 cm of `range` (metres, Hann window) over ten draws of the
/// surfaces, dB over 1/m².
fn cell(text: &str, range: f64) -> f64 {
    let s = scene(text);
    let power = (0..10).map(|seed| seen(&s.echoes(seed), range).norm_sqr());
    10.0 * (0.1 * power.sum::<f64>()).log10()
}

/// Returns the mean echo power of level ground of `material` seen 15 to 30° below the horizontal, dB over 1/m²; `more`
/// is scene text before the ground.
fn ground(more: &str, material: &str) -> f64 {
    let text = format!("{more}[[floor]]\nto_m = 2.0\nmaterial = \"{material}\"\n");
    let found = level(&text, (0.8, 1.5));
    println!("{material}: {found:.1} dB");
    found
}

const VERTICAL: &str = "[radar]\npolarisation = \"vertical\"\n";

#[test]
fn water_and_dark_carpet_take_the_ground_out_of_sight() {
    for more in ["", VERTICAL] {
        let [asphalt, concrete, wet, dark] =
            ["asphalt", "concrete", "wet", "dark-carpet"].map(|name| ground(more, name));
        assert!(asphalt - wet > 15.0 && concrete - wet > 15.0);
        assert!(concrete - dark > 6.0, "dark carpet");
        assert!(dark > wet);
    }
}

/// Grazing angles of the table in `scenes/README.md`, degrees.
const GRAZING: [f64; 5] = [10.0, 15.0, 20.0, 30.0, 45.0];

/// Returns σ° of `material` at each of [`GRAZING`], dB, relief and volume together, relative to ground of known σ°.
fn sigma(more: &str, material: &str) -> [f64; 5] {
    let known = "[material.known]\npermittivity = 1.0\nconductivity = 0.0\nroughness_m = 0.0\n\
                 diffuse_db = -20.0\n";
    let floor = |name: &str| format!("{known}{more}[[floor]]\nto_m = 2.6\nmaterial = \"{name}\"\n");
    let (it, reference) = (levels(&floor(material)), levels(&floor("known")));
    core::array::from_fn(|k| {
        let sin = GRAZING[k].to_radians().sin();
        it[k] - reference[k] - 20.0 + 10.0 * sin.log10()
    })
}

/// Returns the echo power about the range of each of [`GRAZING`], summed over seven cells of 1.5 cm and 30 draws of the
/// surfaces, dB over 1/m².
fn levels(text: &str) -> [f64; 5] {
    let s = scene(text);
    let mut power = [0.0; 5];
    for seed in 0..30 {
        let echoes = s.echoes(seed);
        for (power, grazing) in power.iter_mut().zip(GRAZING) {
            let range = 0.4 / grazing.to_radians().sin();
            for cell in -3..=3 {
                *power += seen(&echoes, range + 0.015 * f64::from(cell)).norm_sqr();
            }
        }
    }
    power.map(|p| 10.0 * p.log10())
}

#[test]
fn sigma_nought_falls_with_the_grazing_angle() {
    let row = |more: &str, material: &str| {
        let found = sigma(more, material);
        println!("{material}: {found:.0?} dB");
        found
    };
    for material in ["concrete", "asphalt", "wet", "dark-carpet", "rubber"] {
        let (across, along) = (row("", material), row(VERTICAL, material));
        for of in [across, along] {
            assert!(of[0] < of[3] + 1.0 && of[0] > -75.0, "{material}: {of:?}");
        }
        if material == "asphalt" {
            // Volume scatter of a road is stronger in vertical polarisation.
            let excess: Vec<f64> = (0..4).map(|k| along[k] - across[k]).collect();
            assert!(
                excess.iter().all(|db| (0.5..11.0).contains(db)),
                "{excess:?}"
            );
            assert!(excess[0] > excess[3] + 2.0, "{excess:?}");
        }
    }
}

/// Returns scene text of a closed `[[polyline]]` with more keys.
fn solid(points: &str, more: &str) -> String {
    format!("[[polyline]]\npoints = {points}\nclosed = true\n{more}\n")
}

#[test]
fn tactile_paving_raises_the_ground_it_stands_on() {
    let dome = |x: f64, z: f64| {
        let points: Vec<String> = (0..=12)
            .map(|k| {
                let t = 0.7610 * (f64::from(k) / 6.0 - 1.0);
                format!(
                    "[{}, {}]",
                    x + 0.018125 * t.sin(),
                    0.018125 * t.cos() - 0.013125
                )
            })
            .collect();
        let (front, back) = (x - 0.0125, x + 0.0125);
        let points = format!(
            "[[{front}, -0.002], {}, [{back}, -0.002]]",
            points.join(", ")
        );
        let more = format!("width_m = 0.02\nlateral_m = {z}\nmaterial = \"dark-ceramic\"");
        solid(&points, &more)
    };
    let domes: String = (0..12)
        .flat_map(|k| [-0.065, 0.0, 0.065].map(|z| dome(0.7 + 0.065 * f64::from(k), z)))
        .collect();
    let (plain, paved) = (ground("", "dark-ceramic"), ground(&domes, "dark-ceramic"));
    assert!((4.0..40.0).contains(&(paved - plain)), "{plain} {paved}");
}

#[test]
fn a_grate_answers_and_its_channel_is_out_of_sight() {
    let bar = |k: u32| {
        let (x, y) = (1.0 + 0.025 * f64::from(k), -0.025);
        let (b, more) = (x + 0.004, "material = \"metal\"");
        solid(
            &format!("[[{x}, {y}], [{x}, 0.0], [{b}, 0.0], [{b}, {y}]]"),
            more,
        )
    };
    let bars: String = (0..9).map(bar).collect();
    let ends = "[[floor]]\nto_m = 1.0\nmaterial = \"concrete\"\n\
                [[floor]]\nfrom_m = 1.204\nto_m = 2.0\nmaterial = \"concrete\"\n";
    let text = |channel: &str| format!("{ends}{bars}{channel}");
    let channel =
        "[[floor]]\nfrom_m = 1.0\nto_m = 1.204\nheight_m = -0.15\nmaterial = \"concrete\"\n";
    let window = (1.08, 1.26);
    let (open, closed) = (level(&text(""), window), level(&text(channel), window));
    let floor = level("[[floor]]\nto_m = 2.0\nmaterial = \"concrete\"\n", window);
    println!("grate {open:.1} dB, over a channel {closed:.1} dB, concrete {floor:.1} dB");
    assert!(
        open > floor - 3.0,
        "bars answer no less than the ground beside them"
    );
    assert!((closed - open).abs() < 3.0);
    let scene = scene(&text(channel));
    assert!(scene.truth().steps.is_empty() && scene.truth().uncounted.is_empty());
}

#[test]
fn a_glass_pane_reflects_as_fresnel_says_and_glass_takes_what_passes() {
    let level = |material: &str| {
        let s = scene(&format!(
            "[[wall]]\nat_m = 1.5\nbottom_m = 0.01\ntop_m = 2.1\nmaterial = \"{material}\"\n"
        ));
        windowed(&s.echoes(1), 1.5)
    };
    // (1 - n) / (1 + n), n² = 6.31 + 0.30j: 7.3 dB below metal.
    assert_close(
        level("glass") / level("metal"),
        0.432,
        0.02,
        "pane of glass",
    );
}

/// Returns the mean echo power of the corner at the foot of a kerb 10 cm high, 1 m away, dB over 1/m²; `keys` are more
/// keys of the kerb.
fn kerb(keys: &str) -> f64 {
    let text = format!(
        "[[stairs]]\ndistance_m = 1.0\ncount = 1\nrise_m = 0.1\ngoing_m = 0.3\ntread_thickness_m = 0.5\n\
         material = \"concrete\"\n{keys}\n[[floor]]\nmaterial = \"dark-ceramic\"\n"
    );
    cell(&text, (1.0_f64 + 0.16).sqrt())
}

#[test]
fn a_battered_riser_opens_the_corner_at_its_foot() {
    let (upright, battered) = (kerb(""), kerb("batter_m = 0.02"));
    println!("corner {upright:.1} dB, battered {battered:.1} dB");
    assert!(battered < upright - 6.0, "{upright} {battered}");
}

#[test]
fn strips_of_metal_answer_where_wood_hardly_does() {
    let step = |keys: &str| {
        let text = format!(
            "[[stairs]]\ndistance_m = 1.0\ncount = 1\nrise_m = 0.17\ngoing_m = 0.3\n\
             material = \"painted-wood\"\n{keys}\n"
        );
        cell(&text, (1.0_f64 + 0.23 * 0.23).sqrt())
    };
    let plain = step("");
    let strip = step("strip_m = 0.04\nstrip_material = \"metal\"");
    let proud = step("strip_m = 0.04\nstrip_proud_m = 0.004\nstrip_material = \"metal\"");
    println!("wood {plain:.1} dB, metal strip {strip:.1} dB, proud {proud:.1} dB");
    assert!(strip > plain + 3.0);
    let truth = scene(
        "[[stairs]]\ndistance_m = 1.0\ncount = 2\nrise_m = 0.17\ngoing_m = 0.3\nstrip_m = 0.04\n\
         strip_proud_m = 0.004\nmaterial = \"metal\"\n",
    )
    .truth();
    let heights: Vec<f64> = truth.steps.iter().map(|s| s.height_m).collect();
    assert_eq!(heights, [0.174, 0.344]);
}

#[test]
fn the_edges_of_a_chamfer_are_where_the_faces_end() {
    let s = scene(
        "[[stairs]]\ndistance_m = 1.0\ncount = 1\nrise_m = 0.1\ngoing_m = 0.3\nbatter_m = 0.02\n\
         nosing_radius_m = 0.02\nchamfered = true\ntread_thickness_m = 0.5\nmaterial = \"concrete\"\n",
    );
    // Two obtuse edges, and the foot 2 cm before the sharp corner that the chamfer removes.
    assert_eq!(s.world.wedges.len(), 2);
    assert!((s.world.wedges[1].at.x - 1.02).abs() < 1e-9);
    assert!((s.world.segments[0].a.x - 0.98).abs() < 1e-9);
}
