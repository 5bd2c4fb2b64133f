//! Random scenes for the accuracy tables: plausible buildings, mixed materials, all sorts of weather on
//! the lens.
//!
//! Ranges are those of building codes and of what stands about in buildings; they are not drawn to suit
//! or to annoy a detector. One seed and kind is one scene, for ever: recordings are scored by them.

use core::fmt;
use core::str::FromStr;

use super::maths::Random;
use super::spec::{
    BoxSpec, DoorSpec, FloorSpec, PlaneSpec, PostSpec, RampSpec, SceneSpec, StairsSpec, WallSpec,
    Way,
};

/// What a random scene shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A flight or kerb going up.
    Ascending,
    /// No stairs: what [`NONE`] lists, in turn.
    None,
    /// A flight going down, seen from a pole.
    Descending,
    /// A flight going up, one of whose steps is 2 to 4 cm higher or lower than the others.
    Irregular,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Kind; 4] = [
        Kind::Ascending,
        Kind::None,
        Kind::Descending,
        Kind::Irregular,
    ];

    const fn name(self) -> &'static str {
        match self {
            Kind::Ascending => "ascending",
            Kind::None => "none",
            Kind::Descending => "descending",
            Kind::Irregular => "irregular",
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Kind {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        Kind::ALL
            .into_iter()
            .find(|k| k.name() == text)
            .ok_or_else(|| {
                let names = Kind::ALL.map(Kind::name).join(", ");
                format!("\"{text}\": expected one of {names}")
            })
    }
}

/// What scenes without stairs show, and how many of 40 do.
pub const NONE: [(&str, usize); 10] = [
    ("floor", 5),
    ("wall", 6),
    ("ramp", 6),
    ("box", 5),
    ("legs", 5),
    ("door", 4),
    ("threshold", 4),
    ("noise", 2),
    ("saturated", 2),
    ("silent", 1),
];

/// Streams of random numbers that scenes are drawn from, apart from those that scans are drawn from.
const STREAM: u64 = 0x5343_454E_4500;

/// What treads and floors are made of.
const SOLID: [&str; 4] = ["painted-wood", "dark-ceramic", "concrete", "metal"];

/// Scene `seed` of a kind.
pub fn random(kind: Kind, seed: u64) -> SceneSpec {
    let mut rng = Random::new(seed, STREAM + kind as u64);
    let mut scene = SceneSpec::default();
    equipment(&mut scene, &mut rng);
    let what = match kind {
        Kind::Ascending => ascending(&mut scene, &mut rng),
        Kind::Irregular => irregular(&mut scene, &mut rng),
        Kind::Descending => descending(&mut scene, &mut rng),
        Kind::None => none(&mut scene, seed, &mut rng),
    };
    scene.description = format!("random scene, {kind} {seed}: {what}");
    scene
}

/// A scanner like others of its make: dirt and rain on the lens, a mounting that is not quite true.
fn equipment(scene: &mut SceneSpec, rng: &mut Random) {
    scene.radar.system_loss_db = rng.between(10.0, 46.0);
    scene.mirror.bias_deg = (0.15 * rng.normal()).clamp(-0.4, 0.4);
    scene.mirror.jitter_deg = rng.between(0.005, 0.05);
    scene.mirror.sidelobe_db = rng.between(18.0, 24.0);
    scene.mount.height_error_m = (0.002 * rng.normal()).clamp(-0.005, 0.005);
    let receiver = &mut scene.receiver;
    receiver.leakage_dbfs = rng.between(-14.0, -8.0);
    receiver.mirror_echo_dbfs = rng.between(-30.0, -22.0);
    receiver.dc_i = rng.between(-0.1, 0.1);
    receiver.dc_q = rng.between(-0.1, 0.1);
    receiver.iq_gain_db = rng.between(-0.2, 0.2);
    receiver.iq_phase_deg = rng.between(-1.2, 1.2);
    receiver.sweep_bow = rng.between(-1.5e-4, 1.5e-4);
    receiver.sweep_ripple = rng.between(0.0, 4e-5);
    receiver.sweep_ripple_cycles = rng.between(2.0, 12.0);
}

fn pick(rng: &mut Random, names: &[&str]) -> String {
    names[rng.index(names.len())].into()
}

/// A flight that a building code could have let pass: step length 2 rise + going of 58 to 68 cm for most
/// (Blondel's rule), and what older houses and gardens have for the rest.
fn flight(rng: &mut Random, count: usize) -> StairsSpec {
    let going = rng.between(0.22, 0.39);
    let rule = 0.5 * (rng.between(0.58, 0.68) - going);
    let rise = if rng.chance(0.8) {
        rule
    } else {
        rng.between(0.10, 0.21)
    };
    let radius = rng.between(0.001, 0.008);
    let overhang = if rng.chance(0.4) {
        rng.between(0.01, 0.04)
    } else {
        0.0
    };
    let thickness = rng.between(0.03, 0.06);
    let material = if rng.chance(0.07) {
        "grating".into()
    } else {
        pick(rng, &SOLID)
    };
    StairsSpec {
        direction: Way::Up,
        distance_m: rng.between(0.4, 1.2),
        base_m: 0.0,
        count,
        rise_m: rise.clamp(0.10, 0.21),
        going_m: going,
        rises_m: Vec::new(),
        goings_m: Vec::new(),
        nosing_m: overhang,
        nosing_radius_m: radius,
        tread_thickness_m: thickness,
        open: false,
        tread_depth_m: None,
        landing_m: 2.0,
        material,
        riser_material: None,
        width_m: None,
    }
}

/// Workmanship: every step a few millimetres off, in half of the flights.
fn uneven(s: &mut StairsSpec, rng: &mut Random) {
    let spread = if rng.chance(0.5) {
        rng.between(0.002, 0.008)
    } else {
        0.0
    };
    let mut off = |value: f64| value + (spread * rng.normal()).clamp(-0.015, 0.015);
    s.rises_m = (0..s.count).map(|_| off(s.rise_m)).collect();
    s.goings_m = (1..s.count).map(|_| off(s.going_m)).collect();
}

fn opened(s: &mut StairsSpec, rng: &mut Random) {
    s.open = true;
    s.nosing_m = 0.0;
    s.tread_depth_m = Some(s.going_m + rng.between(0.0, 0.04));
    s.landing_m = s.going_m;
}

/// What stands around a flight: the floor, and often a wall behind it or a post beside it.
fn surroundings(scene: &mut SceneSpec, s: &StairsSpec, rng: &mut Random) {
    let end = s.open.then_some(3.2);
    scene.floor.push(floor(pick(rng, &SOLID), end));
    if s.open && rng.chance(0.6) {
        scene.wall.push(WallSpec {
            at_m: rng
                .between(2.0, 3.0)
                .max(s.distance_m + s.going_m * s.count as f64 + 0.1),
            bottom_m: 0.0,
            top_m: 2.5,
            material: pick(rng, &["plaster", "concrete"]),
        });
    }
    if rng.chance(0.15) {
        let side = if rng.chance(0.5) { 1.0 } else { -1.0 };
        scene.post.push(PostSpec {
            at_m: s.distance_m - rng.between(0.05, 0.15),
            lateral_m: side * rng.between(0.08, 0.3),
            diameter_m: rng.between(0.02, 0.05),
            bottom_m: 0.0,
            top_m: 0.9,
            material: pick(rng, &["metal", "painted-wood"]),
        });
    }
}

fn floor(material: String, to_m: Option<f64>) -> FloorSpec {
    FloorSpec {
        from_m: -0.6,
        to_m,
        height_m: 0.0,
        material,
    }
}

fn ascending(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
    let kerb = rng.chance(0.2);
    let count = if kerb { 1 } else { 2 + rng.index(5) };
    let mut s = flight(rng, count);
    let what = if kerb {
        s.rise_m = rng.between(0.07, 0.16);
        s.nosing_m = 0.0;
        s.material = pick(rng, &["concrete", "painted-wood", "dark-ceramic"]);
        "kerb"
    } else if rng.chance(0.2) {
        opened(&mut s, rng);
        "floating"
    } else {
        "closed"
    };
    uneven(&mut s, rng);
    surroundings(scene, &s, rng);
    scene.stairs.push(s);
    what
}

fn irregular(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
    let count = 3 + rng.index(4);
    let mut s = flight(rng, count);
    let open = rng.chance(0.15);
    if open {
        opened(&mut s, rng);
    }
    s.rises_m = vec![s.rise_m; count];
    s.goings_m = vec![s.going_m; count - 1];
    let odd = rng.index(count);
    let off = rng.between(0.02, 0.04);
    let up = rng.chance(0.5);
    // Not lower than a low kerb and not higher than anybody climbs.
    let rise = if up && s.rise_m + off < 0.235 {
        s.rise_m + off
    } else {
        s.rise_m - off
    };
    s.rises_m[odd] = rise;
    surroundings(scene, &s, rng);
    scene.stairs.push(s);
    if open {
        "floating, one step off"
    } else {
        "closed, one step off"
    }
}

fn descending(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
    scene.mount.plane = PlaneSpec::Height;
    scene.mount.height_m = rng.between(0.95, 1.3);
    let count = 2 + rng.index(3);
    let mut s = flight(rng, count);
    s.direction = Way::Down;
    s.distance_m = -rng.between(0.0, 0.2);
    s.landing_m = 2.5;
    uneven(&mut s, rng);
    let open = rng.chance(0.1);
    if open {
        s.open = true;
        s.nosing_m = 0.0;
    }
    scene.stairs.push(s);
    if open { "floating" } else { "closed" }
}

/// The scenes without stairs, by turns: which of them `seed` is.
fn none(scene: &mut SceneSpec, seed: u64, rng: &mut Random) -> &'static str {
    let total: usize = NONE.iter().map(|(_, n)| n).sum();
    let mut turn = (seed % total as u64) as usize;
    let mut what = NONE[0].0;
    for (name, n) in NONE {
        if turn < n {
            what = name;
            break;
        }
        turn -= n;
    }
    let end = rng.between(2.0, 3.4);
    scene.floor.push(floor(
        pick(rng, &["concrete", "dark-ceramic", "painted-wood", "carpet"]),
        Some(end),
    ));
    match what {
        "wall" => wall(scene, rng),
        "ramp" => ramp(scene, rng),
        "box" => boxes(scene, rng),
        "legs" => legs(scene, rng),
        "door" => door(scene, rng),
        "threshold" => threshold(scene, rng),
        "noise" => silent(scene, rng.between(60.0, 80.0)),
        "silent" => silent(scene, -300.0),
        // More leakage than the ADC can take.
        "saturated" => scene.receiver.leakage_dbfs = rng.between(3.0, 12.0),
        _ => {}
    }
    what
}

fn wall(scene: &mut SceneSpec, rng: &mut Random) {
    let at = rng.between(0.7, 2.4);
    scene.floor[0].to_m = Some(at);
    scene.wall.push(WallSpec {
        at_m: at,
        bottom_m: 0.0,
        top_m: 2.5,
        material: pick(rng, &["plaster", "concrete", "painted-wood"]),
    });
}

fn ramp(scene: &mut SceneSpec, rng: &mut Random) {
    let (from, length) = (rng.between(0.4, 1.0), rng.between(0.8, 2.2));
    let slope = libm::tan(rng.between(3.0, 12.0).to_radians());
    let material = scene.floor[0].material.clone();
    scene.floor[0].to_m = Some(from);
    scene.ramp.push(RampSpec {
        from_m: from,
        to_m: from + length,
        from_height_m: 0.0,
        to_height_m: length * slope,
        material: material.clone(),
    });
    scene.floor.push(FloorSpec {
        from_m: from + length,
        to_m: Some(from + length + 1.0),
        height_m: length * slope,
        material,
    });
}

fn boxes(scene: &mut SceneSpec, rng: &mut Random) {
    let from = rng.between(0.6, 1.6);
    scene.boxes.push(BoxSpec {
        from_m: from,
        to_m: from + rng.between(0.2, 0.6),
        bottom_m: 0.0,
        top_m: rng.between(0.25, 0.8),
        width_m: Some(rng.between(0.2, 0.8)),
        lateral_m: rng.between(-0.1, 0.1),
        material: pick(rng, &["painted-wood", "metal", "fabric"]),
    });
}

/// Legs of a person, of a chair, or of a table.
fn legs(scene: &mut SceneSpec, rng: &mut Random) {
    let person = rng.chance(0.5);
    let (count, at) = (if person { 2 } else { 4 }, rng.between(0.6, 1.8));
    let material = if person {
        "fabric".into()
    } else {
        pick(rng, &["metal", "painted-wood"])
    };
    for k in 0..count {
        let side = if k % 2 == 0 { -1.0 } else { 1.0 };
        let row = if k < 2 { 0.0 } else { rng.between(0.35, 0.5) };
        let diameter = if person {
            rng.between(0.10, 0.15)
        } else {
            rng.between(0.02, 0.05)
        };
        scene.post.push(PostSpec {
            at_m: at + row + rng.between(-0.05, 0.05),
            lateral_m: side * rng.between(0.0, 0.2),
            diameter_m: diameter,
            bottom_m: 0.0,
            top_m: if person {
                rng.between(0.75, 0.9)
            } else {
                rng.between(0.42, 0.72)
            },
            material: material.clone(),
        });
    }
}

fn door(scene: &mut SceneSpec, rng: &mut Random) {
    let threshold = if rng.chance(0.5) {
        rng.between(0.008, 0.018)
    } else {
        0.0
    };
    let width = rng.between(0.8, 1.0);
    scene.door.push(DoorSpec {
        at_m: rng.between(0.7, 1.8),
        depth_m: rng.between(0.08, 0.2),
        width_m: width,
        height_m: 2.0,
        // Driven at askew: one jamb may come into the beam.
        lateral_m: rng.between(-0.5, 0.5) * (width + 0.05),
        frame_m: rng.between(0.05, 0.1),
        threshold_m: threshold,
        material: pick(rng, &["painted-wood", "metal"]),
    });
}

fn threshold(scene: &mut SceneSpec, rng: &mut Random) {
    let from = rng.between(0.5, 1.6);
    scene.boxes.push(BoxSpec {
        from_m: from,
        to_m: from + rng.between(0.03, 0.12),
        bottom_m: 0.0,
        top_m: rng.between(0.006, 0.019),
        width_m: None,
        lateral_m: 0.0,
        material: pick(rng, &["metal", "painted-wood", "dark-ceramic"]),
    });
}

/// A radar whose transmitter is dead: its noise and nothing else, or, below the last bit, nothing at all.
fn silent(scene: &mut SceneSpec, noise_figure_db: f64) {
    scene.radar.tx_power_dbm = -300.0;
    let receiver = &mut scene.receiver;
    receiver.noise_figure_db = noise_figure_db;
    receiver.leakage_dbfs = -300.0;
    receiver.mirror_echo_dbfs = -300.0;
    receiver.dc_i = 0.0;
    receiver.dc_q = 0.0;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    #[test]
    fn every_random_scene_can_be_built() {
        for kind in Kind::ALL {
            for seed in 0..60 {
                let spec = random(kind, seed);
                assert_eq!(spec, random(kind, seed));
                if let Err(error) = Scene::new(spec) {
                    panic!("{kind} {seed}: {error}");
                }
            }
        }
    }

    #[test]
    fn one_step_of_an_irregular_flight_is_off_by_two_to_four_centimetres() {
        for seed in 0..100 {
            let spec = random(Kind::Irregular, seed);
            let s = &spec.stairs[0];
            let off: Vec<f64> = s.rises_m.iter().map(|r| (r - s.rise_m).abs()).collect();
            assert_eq!(off.iter().filter(|d| **d > 0.0).count(), 1);
            assert!(off.iter().any(|d| (0.02..=0.04).contains(d)));
            assert!(s.rises_m.iter().all(|r| (0.06..0.24).contains(r)));
        }
    }

    #[test]
    fn forty_scenes_without_stairs_show_each_of_the_list() {
        for (name, n) in NONE {
            let wanted = format!(": {name}");
            let scenes = (0..40).map(|seed| random(Kind::None, seed).description);
            assert_eq!(scenes.filter(|d| d.ends_with(&wanted)).count(), n);
        }
    }

    #[test]
    fn kinds_have_names() {
        for kind in Kind::ALL {
            assert_eq!(kind.to_string().parse(), Ok(kind));
        }
        assert!("stairs".parse::<Kind>().is_err());
    }
}
