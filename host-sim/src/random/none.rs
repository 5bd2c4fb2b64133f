//! Scenes without stairs, of the kind `none` that the first accuracy tables were made with.

use super::draw::{pick, turn};
use super::flight::floor;
use crate::scene::maths::Random;
use crate::scene::spec::{BoxSpec, DoorSpec, FloorSpec, PostSpec, RampSpec, SceneSpec, WallSpec};

/// Contents of the scenes of kind `none`, each with its number of seeds among 40 consecutive ones.
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

/// Draws a scene without stairs; `seed` selects its content from [`NONE`] in turn. Returns the content's name.
pub fn none(scene: &mut SceneSpec, seed: u64, rng: &mut Random) -> &'static str {
    let what = turn(&NONE, seed);
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
        // Leakage above the ADC's full scale.
        "saturated" => scene.receiver.leakage_dbfs = rng.between(3.0, 12.0),
        _ => {}
    }
    what
}

fn wall(scene: &mut SceneSpec, rng: &mut Random) {
    let at = rng.between(0.7, 2.4);
    wall_at(
        scene,
        at,
        pick(rng, &["plaster", "concrete", "painted-wood"]),
    );
}

/// Ends the floor at `at` metres, and adds a wall there.
pub fn wall_at(scene: &mut SceneSpec, at: f64, material: String) {
    scene.floor[0].to_m = Some(at);
    scene.wall.push(WallSpec {
        at_m: at,
        bottom_m: 0.0,
        top_m: 2.5,
        material,
    });
}

fn ramp(scene: &mut SceneSpec, rng: &mut Random) {
    let (from, length) = (rng.between(0.4, 1.0), rng.between(0.8, 2.2));
    let degrees = rng.between(3.0, 12.0);
    incline(scene, from, length, degrees);
}

/// Adds a ramp of `degrees` to the floor, from `from` metres on and `length` metres long, and the level surface at its
/// end.
pub fn incline(scene: &mut SceneSpec, from: f64, length: f64, degrees: f64) {
    let slope = libm::tan(degrees.to_radians());
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
        mountable: false,
        material: pick(rng, &["painted-wood", "metal", "fabric"]),
    });
}

/// Adds the legs of a person, or of a chair or table.
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
        // Approached off-centre: one jamb may be in the beam.
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
        mountable: false,
        material: pick(rng, &["metal", "painted-wood", "dark-ceramic"]),
    });
}

/// Makes the transmitter silent: only noise remains or, with noise below the ADC's last bit, no signal at all.
fn silent(scene: &mut SceneSpec, noise_figure_db: f64) {
    scene.radar.tx_power_dbm = -300.0;
    let receiver = &mut scene.receiver;
    receiver.noise_figure_db = noise_figure_db;
    receiver.leakage_dbfs = -300.0;
    receiver.mirror_echo_dbfs = -300.0;
    receiver.dc_i = 0.0;
    receiver.dc_q = 0.0;
}
