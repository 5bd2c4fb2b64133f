//! Scenes without stairs: objects that stand where wheelchairs go.

use super::draw::{pick, turn};
use super::flight::floor;
use super::none::{incline, wall_at};
use crate::scene::maths::Random;
use crate::scene::spec::{BoxSpec, DoorSpec, PolylineSpec, PostSpec, SceneSpec};

/// Contents of the scenes of kind `clutter`, each with its number of seeds among 28 consecutive ones.
pub const CLUTTER: [(&str, usize); 13] = [
    ("floor", 2),
    ("wall", 2),
    ("far wall", 3),
    ("ramp", 3),
    ("ramp down", 1),
    ("box", 2),
    ("person", 3),
    ("post", 2),
    ("chair", 2),
    ("table", 2),
    ("door", 2),
    ("doorway", 2),
    ("threshold", 2),
];

/// Materials of floors, in equal shares.
const FLOORS: [&str; 5] = [
    "concrete",
    "dark-ceramic",
    "painted-wood",
    "carpet",
    "metal",
];

/// Draws a scene without stairs; `seed` selects its content from [`CLUTTER`] in turn. Returns the content's name.
pub fn clutter(scene: &mut SceneSpec, seed: u64, rng: &mut Random) -> &'static str {
    let what = turn(&CLUTTER, seed);
    scene
        .floor
        .push(floor(pick(rng, &FLOORS), Some(rng.between(2.0, 3.4))));
    let at = rng.between(0.6, 1.8);
    match what {
        "wall" => {
            let at = rng.between(0.7, 2.6);
            wall(scene, at, rng);
        }
        // Beyond the maximum range of 2.8 m from the mirror: its echo is aliased to the near
        // ranges, attenuated by the anti-alias filter.
        "far wall" => {
            let at = rng.between(2.75, 4.6);
            wall(scene, at, rng);
        }
        "ramp" => {
            let degrees = rng.between(3.0, 12.0);
            ramp(scene, degrees, rng);
        }
        "ramp down" => {
            let degrees = -rng.between(2.0, 6.0);
            ramp(scene, degrees, rng);
        }
        "box" => boxes(scene, rng),
        "person" => {
            let (side, stride) = (rng.between(-0.15, 0.15), rng.between(-0.2, 0.2));
            person(scene, (at, side), stride, rng);
        }
        "post" => post(scene, at, rng),
        "chair" => chair(scene, at, rng),
        "table" => table(scene, at, rng),
        "door" => door(scene, rng),
        "doorway" => doorway(scene, rng),
        "threshold" => threshold(scene, rng),
        _ => {}
    }
    // Half of the scenes have a wall behind, because most rooms end within the range.
    if !matches!(what, "floor" | "wall" | "far wall" | "ramp" | "ramp down") && rng.chance(0.4) {
        let at = rng.between(2.3, 3.6);
        wall(scene, at, rng);
    }
    what
}

fn wall(scene: &mut SceneSpec, at: f64, rng: &mut Random) {
    wall_at(
        scene,
        at,
        pick(rng, &["plaster", "concrete", "painted-wood", "metal"]),
    );
}

/// Adds a ramp 0.6 to 2.2 m long that rises by `degrees`, or falls where they are negative.
fn ramp(scene: &mut SceneSpec, degrees: f64, rng: &mut Random) {
    let (from, length) = (rng.between(0.4, 1.2), rng.between(0.6, 2.2));
    incline(scene, from, length, degrees);
}

/// Adds a box, suitcase, planter or cabinet.
fn boxes(scene: &mut SceneSpec, rng: &mut Random) {
    let from = rng.between(0.5, 1.8);
    scene.boxes.push(BoxSpec {
        from_m: from,
        to_m: from + rng.between(0.15, 0.8),
        bottom_m: 0.0,
        top_m: rng.between(0.33, 1.2),
        width_m: Some(rng.between(0.2, 1.2)),
        lateral_m: rng.between(-0.25, 0.25),
        mountable: false,
        material: pick(rng, &["painted-wood", "metal", "fabric", "concrete"]),
    });
}

/// Adds a standing person at `at` metres, `lateral` beside the plane: legs of 9 to 15 cm in diameter over shoes 24 to
/// 32 cm long, one foot up to `stride` metres before the other (DIN 33402-2: calf and thigh circumferences, foot
/// lengths).
pub fn person(scene: &mut SceneSpec, (at, lateral): (f64, f64), stride: f64, rng: &mut Random) {
    let (apart, diameter) = (rng.between(0.08, 0.2), rng.between(0.09, 0.15));
    let (shoe, sole) = (rng.between(0.24, 0.32), rng.between(0.05, 0.09));
    let faces = rng.chance(0.5);
    for side in [-0.5, 0.5] {
        let x = at + side * stride;
        let z = lateral + side * (apart + diameter);
        scene.post.push(PostSpec {
            at_m: x,
            lateral_m: z,
            diameter_m: diameter,
            bottom_m: sole,
            top_m: rng.between(0.75, 0.95),
            material: "fabric".into(),
        });
        // The toes point to the chair or away from it.
        let toes = if faces {
            x - 0.7 * shoe
        } else {
            x - 0.3 * shoe
        };
        scene.boxes.push(BoxSpec {
            from_m: toes,
            to_m: toes + shoe,
            bottom_m: 0.0,
            top_m: sole,
            width_m: Some(rng.between(0.08, 0.11)),
            lateral_m: z,
            mountable: false,
            material: "fabric".into(),
        });
    }
}

/// Adds a post or bollard at `at` metres, mostly with a foot: a base plate, or a block of concrete.
fn post(scene: &mut SceneSpec, at: f64, rng: &mut Random) {
    let diameter = rng.between(0.04, 0.16);
    let lateral = rng.between(-0.08, 0.08);
    let foot = rng.chance(0.75);
    let plate = rng.chance(0.6);
    let (half, height) = match (foot, plate) {
        (false, _) => (0.0, 0.0),
        (true, true) => (
            0.5 * diameter + rng.between(0.03, 0.08),
            rng.between(0.006, 0.02),
        ),
        (true, false) => (
            0.5 * diameter + rng.between(0.05, 0.2),
            rng.between(0.05, 0.15),
        ),
    };
    if foot {
        scene.boxes.push(BoxSpec {
            from_m: at - half,
            to_m: at + half,
            bottom_m: 0.0,
            top_m: height,
            width_m: Some(2.0 * half),
            lateral_m: lateral,
            mountable: false,
            material: if plate { "metal" } else { "concrete" }.into(),
        });
    }
    scene.post.push(PostSpec {
        at_m: at,
        lateral_m: lateral,
        diameter_m: diameter,
        bottom_m: height,
        top_m: rng.between(0.7, 1.6),
        material: pick(rng, &["metal", "painted-wood", "concrete"]),
    });
}

/// Adds four legs `wide` metres apart across the plane and `deep` along it, with tops at `height` metres; the nearest
/// stand at `at`, their middle `lateral` beside the plane. Returns the name of their material.
fn legs(
    scene: &mut SceneSpec,
    (at, lateral): (f64, f64),
    (wide, deep, height): (f64, f64, f64),
    rng: &mut Random,
) -> String {
    let material = pick(rng, &["metal", "painted-wood"]);
    let diameter = rng.between(0.02, 0.06);
    for x in [0.0, deep] {
        for z in [-0.5, 0.5] {
            scene.post.push(PostSpec {
                at_m: at + x,
                lateral_m: lateral + z * wide,
                diameter_m: diameter,
                bottom_m: 0.0,
                top_m: height,
                material: material.clone(),
            });
        }
    }
    material
}

fn plate(
    scene: &mut SceneSpec,
    (from, to): (f64, f64),
    (bottom, top): (f64, f64),
    (width, lateral): (f64, f64),
    material: String,
) {
    scene.boxes.push(BoxSpec {
        from_m: from,
        to_m: to,
        bottom_m: bottom,
        top_m: top,
        width_m: Some(width),
        lateral_m: lateral,
        mountable: false,
        material,
    });
}

/// Adds a chair: seat at 42 to 48 cm, 38 to 45 cm wide and deep (EN 1729-1), with its back towards
/// the scanner or away.
fn chair(scene: &mut SceneSpec, at: f64, rng: &mut Random) {
    let (wide, deep) = (rng.between(0.36, 0.44), rng.between(0.36, 0.44));
    let (seat, thick) = (rng.between(0.42, 0.48), rng.between(0.02, 0.08));
    let lateral = rng.between(-0.25, 0.25);
    legs(scene, (at, lateral), (wide, deep, seat - thick), rng);
    let material = pick(rng, &["painted-wood", "fabric"]);
    let across = (wide + 0.04, lateral);
    plate(
        scene,
        (at, at + deep),
        (seat - thick, seat),
        across,
        material.clone(),
    );
    let back = if rng.chance(0.5) {
        at
    } else {
        at + deep - 0.03
    };
    let height = (seat + 0.15, seat + rng.between(0.35, 0.45));
    plate(scene, (back, back + 0.03), height, across, material);
}

/// Adds a table: plate at 70 to 76 cm (EN 527-1), 2 to 5 cm thick, over the legs.
fn table(scene: &mut SceneSpec, at: f64, rng: &mut Random) {
    let (wide, deep) = (rng.between(0.6, 1.6), rng.between(0.5, 0.9));
    let (top, thick) = (rng.between(0.70, 0.76), rng.between(0.02, 0.05));
    let lateral = rng.between(-0.4, 0.4) * wide;
    let material = legs(scene, (at, lateral), (wide, deep, top - thick), rng);
    let material = if rng.chance(0.7) {
        "painted-wood".into()
    } else {
        material
    };
    let span = (at - 0.05, at + deep + 0.05);
    plate(
        scene,
        span,
        (top - thick, top),
        (wide + 0.1, lateral),
        material,
    );
}

/// Adds a closed door in its frame, 4 cm thick with a gap of 5 to 10 mm below.
fn door(scene: &mut SceneSpec, rng: &mut Random) {
    let at = rng.between(0.7, 2.4);
    let width = rng.between(0.8, 1.0);
    let lateral = rng.between(-0.4, 0.4) * width;
    let material = pick(rng, &["painted-wood", "metal"]);
    frame(scene, (at, width, lateral), material.clone(), rng);
    plate(
        scene,
        (at + 0.02, at + 0.06),
        (rng.between(0.005, 0.010), 2.0),
        (width, lateral),
        material,
    );
}

fn frame(
    scene: &mut SceneSpec,
    (at, width, lateral): (f64, f64, f64),
    material: String,
    rng: &mut Random,
) {
    scene.door.push(DoorSpec {
        at_m: at,
        depth_m: rng.between(0.08, 0.2),
        width_m: width,
        height_m: 2.0,
        lateral_m: lateral,
        frame_m: rng.between(0.05, 0.1),
        threshold_m: 0.0,
        material,
    });
}

/// Adds an open doorway in a wall that continues to both sides. One jamb may be in the beam.
fn doorway(scene: &mut SceneSpec, rng: &mut Random) {
    let (at, width) = (rng.between(0.7, 2.0), rng.between(0.8, 1.2));
    let lateral = rng.between(-0.5, 0.5) * width;
    frame(scene, (at, width, lateral), "painted-wood".into(), rng);
    let material = pick(rng, &["plaster", "concrete"]);
    let (part, thick) = (1.5, rng.between(0.1, 0.3));
    for side in [-0.5, 0.5] {
        let middle = lateral + side * (width + 0.2 + part);
        plate(
            scene,
            (at, at + thick),
            (0.0, 2.5),
            (part, middle),
            material.clone(),
        );
    }
    if rng.chance(0.4) {
        sill(scene, at, rng);
    }
}

/// Adds a threshold 0.5 to 2 cm high (ISO 21542 allows 20 mm), its edges upright or bevelled.
fn threshold(scene: &mut SceneSpec, rng: &mut Random) {
    sill(scene, rng.between(0.5, 1.8), rng);
}

fn sill(scene: &mut SceneSpec, at: f64, rng: &mut Random) {
    let (length, height) = (rng.between(0.03, 0.15), rng.between(0.005, 0.020));
    let bevel = if rng.chance(0.5) {
        rng.between(0.2, 0.45) * length
    } else {
        0.0
    };
    let mut points = vec![
        [at, 0.0],
        [at + bevel, height],
        [at + length - bevel, height],
    ];
    points.push([at + length, 0.0]);
    scene.polyline.push(PolylineSpec {
        points,
        closed: true,
        width_m: None,
        lateral_m: 0.0,
        material: pick(rng, &["metal", "painted-wood", "dark-ceramic"]),
    });
}
