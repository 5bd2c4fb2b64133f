//! Flights going down under the scanner, and drops ahead that a scan of the depth plane must not
//! report as clear.

use super::draw::pick;
use super::flight::flight;
use super::odd::oddity;
use super::shaped::workmanship;
use crate::scene::maths::Random;
use crate::scene::spec::{PlaneSpec, PolylineSpec, SceneSpec, StairsSpec, WallSpec, Way};

/// Draws a flight of one to six steps going down. A pole holds the scanner out, and the first edge
/// lies between 25 cm behind the mirror and 5 cm before it.
pub fn downstairs(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
    scene.mount.plane = PlaneSpec::Height;
    scene.mount.height_m = rng.between(0.95, 1.3);
    let count = 1 + rng.index(6);
    let mut s = flight(rng, count);
    s.direction = Way::Down;
    s.distance_m = rng.between(-0.25, 0.05);
    s.landing_m = rng.between(0.8, 2.5);
    let what = match rng.index(5) {
        0 if count > 1 => {
            oddity(&mut s, rng);
            "odd"
        }
        1 => {
            s.nosing_radius_m = rng.between(0.010, 0.020);
            s.tread_thickness_m = rng.between(0.046, 0.06);
            s.material = pick(rng, &["carpet", "concrete", "painted-wood"]);
            workmanship(&mut s, rng);
            "round noses"
        }
        2 => {
            s.rise_m = rng.between(0.06, 0.12);
            s.going_m = rng.between(0.35, 0.60);
            workmanship(&mut s, rng);
            "low"
        }
        3 => {
            s.open = true;
            s.nosing_m = 0.0;
            workmanship(&mut s, rng);
            "floating"
        }
        _ => {
            workmanship(&mut s, rng);
            "closed"
        }
    };
    // Some stairs end at a wall.
    if rng.chance(0.3) {
        end(scene, &s, rng);
    }
    scene.stairs.push(s);
    what
}

/// Returns the height of the floor below a flight going down, and the distance of that floor's end, metres.
fn bottom(s: &StairsSpec) -> (f64, f64) {
    let part = |list: &[f64], k: usize, all: f64| list.get(k).copied().unwrap_or(all);
    let fall = (0..s.count).fold(0.0, |sum, k| sum + part(&s.rises_m, k, s.rise_m));
    let run = (1..s.count).fold(0.0, |sum, k| sum + part(&s.goings_m, k - 1, s.going_m));
    (s.base_m - fall, s.distance_m + run + s.landing_m)
}

/// Adds a wall at the end of the floor below a flight going down.
fn end(scene: &mut SceneSpec, s: &StairsSpec, rng: &mut Random) {
    let (floor, at) = bottom(s);
    scene.wall.push(WallSpec {
        at_m: at,
        bottom_m: floor,
        top_m: floor + 2.5,
        material: pick(rng, &["plaster", "concrete"]),
    });
}

/// Draws stairs or a kerb going down, 0.5 to 2 m ahead, in the depth plane.
///
/// The truth of such a scan has no steps and no direction, because nothing goes up. The drops are
/// listed as `uncounted`, with negative heights, because reporting them is neither right nor wrong.
/// An `ok` whose horizon lies beyond the first of them is wrong.
pub fn brink(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
    let kerb = rng.chance(0.25);
    let count = if kerb { 1 } else { 1 + rng.index(6) };
    let mut s = flight(rng, count);
    s.direction = Way::Down;
    s.distance_m = rng.between(0.5, 2.0);
    s.landing_m = rng.between(0.6, 2.5);
    if kerb {
        s.rise_m = rng.between(0.06, 0.20);
        s.nosing_m = 0.0;
        s.material = pick(rng, &["concrete", "dark-ceramic"]);
    } else if rng.chance(0.15) {
        s.open = true;
        s.nosing_m = 0.0;
    }
    workmanship(&mut s, rng);
    if rng.chance(0.4) {
        end(scene, &s, rng);
    }
    scene.stairs.push(s);
    if kerb { "kerb down" } else { "stairs down" }
}

/// Draws a hole 0.25 to 1.2 m long and 0.1 to 1 m deep (a pit, an open hatch), or the end of the
/// floor: a loading dock or a platform's edge, 0.3 to 1.2 m above the ground below. The truth is
/// that of [`brink`].
pub fn hole(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
    let dock = rng.chance(0.4);
    let mut s = flight(rng, 1);
    s.direction = Way::Down;
    s.nosing_m = 0.0;
    s.distance_m = rng.between(0.45, 1.8);
    (s.rise_m, s.landing_m) = if dock {
        (rng.between(0.3, 1.2), rng.between(1.5, 3.0))
    } else {
        (rng.between(0.1, 1.0), rng.between(0.25, 1.2))
    };
    if !dock {
        // The floor continues behind it.
        let (from, to) = (s.distance_m + s.landing_m, s.distance_m + s.landing_m + 1.5);
        scene.polyline.push(PolylineSpec {
            points: vec![[from, -s.rise_m], [from, 0.0], [to, 0.0], [to, -s.rise_m]],
            closed: true,
            width_m: None,
            lateral_m: 0.0,
            material: s.material.clone(),
        });
    }
    scene.stairs.push(s);
    if dock { "end of the floor" } else { "hole" }
}
