//! Flights with an object beside, under or over them.

use super::clutter::person;
use super::draw::pick;
use super::flight::{flight, opened, surroundings};
use super::shaped::workmanship;
use crate::scene::maths::Random;
use crate::scene::spec::{BoxSpec, PolylineSpec, PostSpec, SceneSpec, StairsSpec};

/// Objects beside, under or over a flight, in equal shares.
const OBJECTS: [&str; 6] = [
    "deep overhang",
    "stringer beside",
    "stringer under the treads",
    "posts",
    "person",
    "ceiling",
];

/// Draws a flight of two to six steps and one of [`OBJECTS`], whose name it returns.
pub fn beside(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
    let count = 2 + rng.index(5);
    let mut s = flight(rng, count);
    let what = OBJECTS[rng.index(OBJECTS.len())];
    if what == "stringer under the treads" || rng.chance(0.15) {
        opened(&mut s, rng);
    }
    workmanship(&mut s, rng);
    match what {
        "deep overhang" => {
            // Deeper than codes allow (32 mm, IRC R311.7.5.3), as on stone slabs and old wood.
            s.open = false;
            s.nosing_m = rng.between(0.03, 0.06);
        }
        "stringer beside" => stringer(scene, &s, rng, false),
        "stringer under the treads" => stringer(scene, &s, rng, true),
        "posts" => posts(scene, &s, rng),
        "person" => {
            let at = s.distance_m - rng.between(0.0, 0.3);
            let side = aside(rng, 0.12, 0.35);
            person(scene, (at.max(0.3), side), 0.0, rng);
        }
        _ => ceiling(scene, &s, rng),
    }
    surroundings(scene, &s, rng);
    scene.stairs.push(s);
    what
}

fn aside(rng: &mut Random, low: f64, high: f64) -> f64 {
    let side = rng.between(low, high);
    if rng.chance(0.5) { side } else { -side }
}

/// Adds the sloping beam that carries the treads: one 4 to 8 cm wide beside them with its top above
/// the nosings (a closed string), or one 8 to 20 cm wide under the middle of floating treads.
fn stringer(scene: &mut SceneSpec, s: &StairsSpec, rng: &mut Random, under: bool) {
    let rise: f64 = s.rises_m.iter().fold(0.0, |sum, r| sum + r) / s.count as f64;
    let run = s.goings_m.iter().fold(0.0, |sum, g| sum + g) + s.going_m;
    let top = rise * s.count as f64;
    // Height of its upper edge relative to the line of the nosings, measured vertically.
    let (above, depth, width, lateral) = if under {
        let clear = s.tread_thickness_m + rng.between(0.01, 0.04);
        (
            -clear,
            rng.between(0.10, 0.20),
            rng.between(0.08, 0.20),
            rng.between(-0.08, 0.08),
        )
    } else {
        let side = aside(rng, 0.06, 0.25);
        (
            rng.between(0.02, 0.08),
            rng.between(0.2, 0.3),
            rng.between(0.04, 0.08),
            side,
        )
    };
    let slope = top / run;
    let line = |x: f64| rise + (x - s.distance_m) * slope + above;
    // It starts on the floor, a little before or behind the first nosing.
    let start = s.distance_m + if under { 0.5 * s.going_m } else { 0.0 };
    let end = s.distance_m + run;
    let foot = start + (depth / slope).min(0.8 * (end - start));
    scene.polyline.push(PolylineSpec {
        points: vec![
            [start, 0.002],
            [start, line(start).max(0.02)],
            [end, line(end)],
            [end, (line(end) - depth).max(0.01)],
            [foot, 0.002],
        ],
        closed: true,
        width_m: Some(width),
        lateral_m: lateral,
        material: pick(rng, &["metal", "painted-wood"]),
    });
}

/// Adds a newel post at the foot and balusters up the flight, on one side.
fn posts(scene: &mut SceneSpec, s: &StairsSpec, rng: &mut Random) {
    let material = pick(rng, &["metal", "painted-wood"]);
    let side = aside(rng, 0.05, 0.3);
    scene.post.push(PostSpec {
        at_m: s.distance_m - rng.between(0.0, 0.15),
        lateral_m: side,
        diameter_m: rng.between(0.04, 0.12),
        bottom_m: 0.0,
        top_m: rng.between(0.9, 1.2),
        material: material.clone(),
    });
    let diameter = rng.between(0.012, 0.04);
    scene.post.extend(balusters(s, side, diameter, &material));
}

/// Returns posts 90 cm high on the middle of every tread of a flight, `lateral_m` beside the plane of the beam.
pub fn balusters(s: &StairsSpec, lateral_m: f64, diameter_m: f64, material: &str) -> Vec<PostSpec> {
    let (mut x, mut height) = (s.distance_m, 0.0);
    let post = |k: usize| {
        height += s.rises_m.get(k).copied().unwrap_or(s.rise_m);
        let post = PostSpec {
            at_m: x + 0.5 * s.going_m,
            lateral_m,
            diameter_m,
            bottom_m: height + 0.001,
            top_m: height + 0.9,
            material: material.to_owned(),
        };
        x += s.goings_m.get(k).copied().unwrap_or(s.going_m);
        post
    };
    (0..s.count).map(post).collect()
}

/// Adds the edge of the floor above or the underside of the next flight, 1.0 to 1.6 m over the
/// first steps: too low to walk under, but in view of a scanner that looks up by 20°.
fn ceiling(scene: &mut SceneSpec, s: &StairsSpec, rng: &mut Random) {
    let from = s.distance_m + rng.between(0.2, 1.2);
    // Above the steps below it, at any height.
    let highest = s.rises_m.iter().fold(0.0, |sum, r| sum + r);
    let bottom = rng.between(1.0, 1.6).max(highest + 0.2);
    scene.boxes.push(BoxSpec {
        from_m: from,
        to_m: from + rng.between(0.3, 1.5),
        bottom_m: bottom,
        top_m: bottom + rng.between(0.1, 0.4),
        width_m: None,
        lateral_m: 0.0,
        mountable: false,
        material: pick(rng, &["concrete", "plaster", "painted-wood"]),
    });
}
