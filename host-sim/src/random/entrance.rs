//! Scenes on the way from the street into a building: kerbs with gutters and worn edges, ramps that end in a
//! kerb, thresholds with seals, glass doors, wet and dark floors, treads with nosing strips. `paving.rs` has
//! the shapes of tactile paving and grates.

use super::draw::{SOLID, pick, turn};
use super::flight::{flight, floor, surroundings, uneven};
use super::paving::{self, solid};
use crate::scene::maths::Random;
use crate::scene::spec::{BoxSpec, RampSpec, SceneSpec, StairsSpec, WallSpec};

/// Contents of the scenes of kind `entrance`, each with its number of seeds among 12 consecutive ones.
pub const ENTRANCE: [(&str, usize); 12] = [
    ("kerb with gutter", 1),
    ("worn kerb", 1),
    ("ramp to a kerb", 1),
    ("tactile paving", 1),
    ("tactile paving, kerb", 1),
    ("tactile paving, stairs", 1),
    ("grate", 1),
    ("threshold with seal", 1),
    ("wet floor", 1),
    ("dark floor", 1),
    ("glass door", 1),
    ("nosing strips", 1),
];

/// Materials of roads, drawn in equal shares by entry, thus asphalt twice as often.
const ROADS: [&str; 3] = ["asphalt", "asphalt", "concrete"];

/// Distance of the end of the ground behind the scene's objects, metres.
const END_M: f64 = 3.4;

/// Draws a scene of a street or an entrance; `seed` selects its content from [`ENTRANCE`] in turn. Returns the
/// content's name.
pub fn entrance(scene: &mut SceneSpec, seed: u64, rng: &mut Random) -> &'static str {
    let what = turn(&ENTRANCE, seed);
    match what {
        "kerb with gutter" => gutter(scene, rng),
        "worn kerb" => worn(scene, rng),
        "ramp to a kerb" => ramp(scene, rng),
        "tactile paving" => tactile(scene, rng),
        "tactile paving, kerb" => tactile_kerb(scene, rng),
        "tactile paving, stairs" => tactile_stairs(scene, rng),
        "grate" => grate(scene, rng),
        "threshold with seal" => threshold(scene, rng),
        "wet floor" => wet(scene, rng),
        "dark floor" => dark(scene, rng),
        "glass door" => glass(scene, rng),
        _ => strips(scene, rng),
    }
    what
}

/// Returns a kerb `rise` metres high at `distance` metres, its edge rounded by 5 to 15 mm.
fn kerb(rng: &mut Random, distance: f64, rise: f64) -> StairsSpec {
    let mut s = flight(rng, 1);
    s.distance_m = distance;
    s.rise_m = rise;
    s.nosing_m = 0.0;
    s.nosing_radius_m = rng.between(0.005, 0.015);
    // Solid, so that the rounding may take as much of the rise as it needs.
    s.tread_thickness_m = 0.5;
    s.material = pick(rng, &["concrete", "concrete", "dark-ceramic"]);
    s
}

/// Draws the height of a kerb over the road, metres: 3 to 8 cm, lowered as at crossings, or 10 to 14 cm.
fn upstand(rng: &mut Random) -> f64 {
    if rng.chance(0.5) {
        rng.between(0.03, 0.08)
    } else {
        rng.between(0.10, 0.14)
    }
}

/// Adds a kerb behind a gutter 20 to 45 cm wide: dished, with 5 to 10 % of fall, or a flat channel
/// 1 to 3 cm deep.
fn gutter(scene: &mut SceneSpec, rng: &mut Random) {
    let at = rng.between(0.6, 1.7);
    let width = rng.between(0.20, 0.45);
    let (road, channel) = (pick(rng, &ROADS), pick(rng, &["concrete", "dark-ceramic"]));
    let rise = upstand(rng);
    let from = at - width;
    let dished = rng.chance(0.5);
    let depth = if dished {
        (width * rng.between(0.05, 0.10)).min(0.03)
    } else {
        rng.between(0.01, 0.03)
    };
    if dished {
        scene.floor.push(floor(road, Some(from)));
    } else {
        // A solid, because its edge over the channel diffracts.
        scene.polyline.push(solid(
            vec![[-0.6, -0.05], [-0.6, 0.0], [from, 0.0], [from, -0.05]],
            road,
        ));
    }
    scene.ramp.push(RampSpec {
        from_m: from,
        to_m: at,
        from_height_m: if dished { 0.0 } else { -depth },
        to_height_m: -depth,
        material: channel,
    });
    let mut s = kerb(rng, at, rise + depth);
    s.base_m = -depth;
    scene.stairs.push(s);
}

/// Adds a kerb 6 to 14 cm high, rounded or chamfered by 15 to 30 mm, half of them battered by 1 :
/// 10 to 1 : 4 (EN 1340: bullnosed, splayed and half-batter kerbs, and wear by wheels).
fn worn(scene: &mut SceneSpec, rng: &mut Random) {
    let (at, rise) = (rng.between(0.5, 1.7), rng.between(0.06, 0.14));
    let mut s = kerb(rng, at, rise);
    s.nosing_radius_m = rng.between(0.015, 0.030);
    s.chamfered = rng.chance(0.35);
    if rng.chance(0.5) {
        s.batter_m = rise * rng.between(0.10, 0.25);
    }
    scene.floor.push(floor(pick(rng, &ROADS), None));
    scene.stairs.push(s);
}

/// Adds a ramp of 3 to 8 %, and a kerb of 3 to 8 cm at its end.
fn ramp(scene: &mut SceneSpec, rng: &mut Random) {
    let (from, length) = (rng.between(0.3, 0.7), rng.between(0.4, 1.0));
    let top = length * rng.between(0.03, 0.08);
    let material = pick(rng, &ROADS);
    scene.floor.push(floor(material.clone(), Some(from)));
    scene.ramp.push(RampSpec {
        from_m: from,
        to_m: from + length,
        from_height_m: 0.0,
        to_height_m: top,
        material,
    });
    let rise = rng.between(0.03, 0.08);
    let mut s = kerb(rng, from + length, rise);
    s.base_m = top;
    scene.stairs.push(s);
}

/// Adds a field of blisters (domes of tactile paving) 40 to 80 cm deep to a level pavement.
fn tactile(scene: &mut SceneSpec, rng: &mut Random) {
    let (from, material) = (
        rng.between(0.4, 1.4),
        pick(rng, &["concrete", "dark-ceramic"]),
    );
    scene.floor.push(floor(material.clone(), Some(END_M)));
    paving::blisters(scene, (from, from + rng.between(0.4, 0.8)), &material, rng);
}

/// Adds a field of blisters (domes of tactile paving) up to a kerb, as on the islands of crossings.
fn tactile_kerb(scene: &mut SceneSpec, rng: &mut Random) {
    let (at, rise) = (rng.between(0.9, 1.7), upstand(rng));
    let s = kerb(rng, at, rise);
    let material = pick(rng, &["concrete", "dark-ceramic"]);
    scene.floor.push(floor(material.clone(), None));
    let depth = rng.between(0.4, 0.8);
    paving::blisters(scene, (at - depth, at - 0.02), &material, rng);
    scene.stairs.push(s);
}

/// Adds corduroy (bars of tactile paving) 80 cm deep that ends 40 cm before a flight.
fn tactile_stairs(scene: &mut SceneSpec, rng: &mut Random) {
    let count = 2 + rng.index(4);
    let mut s = flight(rng, count);
    s.distance_m = rng.between(0.8, 1.5);
    s.material = pick(rng, &SOLID);
    uneven(&mut s, rng);
    let material = pick(rng, &["concrete", "dark-ceramic"]);
    scene.floor.push(floor(material.clone(), None));
    let end = s.distance_m - 0.4;
    paving::corduroy(scene, (end - 0.8, end), &material, rng);
    scene.stairs.push(s);
}

/// Adds the grate of a drainage channel, 12 to 40 cm along the way, flush with the floor.
fn grate(scene: &mut SceneSpec, rng: &mut Random) {
    let from = rng.between(0.5, 1.6);
    let to = from + rng.between(0.12, 0.40);
    let material = pick(rng, &["asphalt", "concrete", "dark-ceramic"]);
    scene.floor.push(floor(material.clone(), Some(from)));
    let mut behind = floor(material, Some(to + 1.6));
    behind.from_m = to;
    scene.floor.push(behind);
    paving::grate(scene, (from, to), rng);
}

/// Adds a metal threshold 1.4 to 3 cm high, bevelled on both sides, with a rubber seal that rises 6
/// to 9 mm above it: 2 to 3.9 cm in all.
fn threshold(scene: &mut SceneSpec, rng: &mut Random) {
    let material = pick(rng, &["concrete", "dark-ceramic", "painted-wood", "carpet"]);
    scene.floor.push(floor(material, Some(END_M)));
    let at = rng.between(0.5, 1.7);
    let (length, height) = (rng.between(0.06, 0.14), rng.between(0.014, 0.030));
    let bevel = rng.between(0.1, 0.35) * length;
    let (end, seal) = (at + length, at + rng.between(0.4, 0.6) * length);
    scene.polyline.push(solid(
        vec![
            [at, -0.002],
            [at, 0.003],
            [at + bevel, height],
            [end - bevel, height],
            [end, 0.003],
            [end, -0.002],
        ],
        "metal".into(),
    ));
    let (half, out) = (rng.between(0.004, 0.006), rng.between(0.006, 0.009));
    let lip = [
        [seal - half, height - 0.001],
        [seal - half, height + 0.6 * out],
        [seal - 0.4 * half, height + out],
        [seal + 0.4 * half, height + out],
        [seal + half, height + 0.6 * out],
        [seal + half, height - 0.001],
    ];
    scene.polyline.push(solid(lip.to_vec(), "rubber".into()));
}

/// Adds water on the floor: all over, or a puddle 0.4 to 1.2 m long. Half of the scenes have a wall
/// behind.
fn wet(scene: &mut SceneSpec, rng: &mut Random) {
    let material = pick(rng, &["asphalt", "concrete", "dark-ceramic"]);
    let end = rng.between(1.6, END_M);
    let from = rng.between(0.3, 1.0);
    let (from, to) = if rng.chance(0.5) {
        (from, from + rng.between(0.4, 1.2))
    } else {
        (-0.6, end)
    };
    if from > -0.6 {
        scene.floor.push(floor(material.clone(), Some(from)));
    }
    let to = to.min(end);
    let mut film = floor("wet".into(), Some(to));
    film.from_m = from;
    scene.floor.push(film);
    if to < end {
        let mut behind = floor(material, Some(end));
        behind.from_m = to;
        scene.floor.push(behind);
    }
    if rng.chance(0.5) {
        wall(scene, end, rng);
    }
}

fn wall(scene: &mut SceneSpec, at: f64, rng: &mut Random) {
    scene.wall.push(WallSpec {
        at_m: at,
        bottom_m: 0.0,
        top_m: 2.5,
        material: pick(rng, &["plaster", "concrete"]),
    });
}

/// Adds a floor of dark carpet, in half of the scenes before a wall.
fn dark(scene: &mut SceneSpec, rng: &mut Random) {
    let end = rng.between(1.6, END_M);
    scene.floor.push(floor("dark-carpet".into(), Some(end)));
    if rng.chance(0.5) {
        wall(scene, end, rng);
    }
}

/// Adds a glass door 5 to 10 mm above the floor, half of them with a metal rail 7 to 12 cm high
/// along the foot.
fn glass(scene: &mut SceneSpec, rng: &mut Random) {
    let at = rng.between(0.7, 2.4);
    let material = pick(rng, &["concrete", "dark-ceramic", "painted-wood", "carpet"]);
    scene.floor.push(floor(material, Some(at)));
    let gap = rng.between(0.005, 0.010);
    let rail = if rng.chance(0.5) {
        rng.between(0.07, 0.12)
    } else {
        0.0
    };
    scene.wall.push(WallSpec {
        at_m: at,
        bottom_m: gap + rail,
        top_m: 2.1,
        material: "glass".into(),
    });
    if rail > 0.0 {
        let half = rng.between(0.012, 0.020);
        scene.boxes.push(BoxSpec {
            from_m: at - half,
            to_m: at + half,
            bottom_m: gap,
            top_m: gap + rail,
            width_m: None,
            lateral_m: 0.0,
            mountable: false,
            material: "metal".into(),
        });
    }
}

/// Adds a flight whose treads have nosing strips of aluminium or rubber, 30 to 55 mm wide, half of
/// them flush, half 3 to 5 mm proud.
fn strips(scene: &mut SceneSpec, rng: &mut Random) {
    let count = 2 + rng.index(5);
    let mut s = flight(rng, count);
    s.material = pick(rng, &["painted-wood", "dark-ceramic", "concrete", "carpet"]);
    s.nosing_radius_m = rng.between(0.001, 0.004);
    s.strip_m = rng.between(0.030, 0.055);
    s.strip_material = Some(pick(rng, &["metal", "rubber"]));
    if rng.chance(0.5) {
        s.strip_proud_m = rng.between(0.003, 0.005);
    }
    uneven(&mut s, rng);
    surroundings(scene, &s, rng);
    scene.stairs.push(s);
}
