//! Flights: dimensions within building codes, workmanship, and surroundings.

use super::draw::{SOLID, pick};
use crate::scene::maths::Random;
use crate::scene::spec::{FloorSpec, PostSpec, SceneSpec, StairsSpec, WallSpec, Way};

/// Draws a flight of `count` steps going up within building codes: step length 2 rise + going of 58 to 68 cm for most
/// (Blondel's rule), and the dimensions of older houses and gardens for the rest.
pub fn flight(rng: &mut Random, count: usize) -> StairsSpec {
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
        chamfered: false,
        batter_m: 0.0,
        strip_m: 0.0,
        strip_proud_m: 0.0,
        strip_material: None,
        tread_thickness_m: thickness,
        open: false,
        tread_depth_m: None,
        tread_fall: 0.0,
        channel_m: 0.0,
        channel_flange_m: 0.03,
        channel_open: false,
        landing_m: 2.0,
        material,
        riser_material: None,
        width_m: None,
    }
}

/// Draws the accuracy of a flight's steps: in half of the flights every step is off by a few millimetres.
pub fn uneven(s: &mut StairsSpec, rng: &mut Random) {
    let spread = if rng.chance(0.5) {
        rng.between(0.002, 0.008)
    } else {
        0.0
    };
    let mut off = |value: f64| value + (spread * rng.normal()).clamp(-0.015, 0.015);
    s.rises_m = (0..s.count).map(|_| off(s.rise_m)).collect();
    s.goings_m = (1..s.count).map(|_| off(s.going_m)).collect();
}

/// Makes a flight floating: treads as deep as the going or slightly deeper.
pub fn opened(s: &mut StairsSpec, rng: &mut Random) {
    s.open = true;
    s.nosing_m = 0.0;
    s.tread_depth_m = Some(s.going_m + rng.between(0.0, 0.04));
    s.landing_m = s.going_m;
}

/// Adds the surroundings of a flight: the floor, and often a wall behind it or a post beside it.
pub fn surroundings(scene: &mut SceneSpec, s: &StairsSpec, rng: &mut Random) {
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

/// Returns a level floor from 0.6 m behind the mirror to `to_m` metres before it; `None`: to the foot of the stairs.
pub fn floor(material: String, to_m: Option<f64>) -> FloorSpec {
    FloorSpec {
        from_m: -0.6,
        to_m,
        height_m: 0.0,
        material,
    }
}
