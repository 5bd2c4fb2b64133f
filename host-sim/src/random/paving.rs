//! Shapes that rise a few millimetres above a floor or lie flush with it: tactile paving and
//! grates.

use super::draw::pick;
use crate::scene::maths::Random;
use crate::scene::spec::{FloorSpec, PolylineSpec, SceneSpec, WallSpec};

/// Depth below the floor to which solids reach, metres. It hides edges that exist only in the model.
const DEPTH_M: f64 = 0.002;

/// Returns a solid of the profile `points` (`[x, height]`, metres) that reaches across the whole way.
pub fn solid(points: Vec<[f64; 2]>, material: String) -> PolylineSpec {
    PolylineSpec {
        points,
        closed: true,
        width_m: None,
        lateral_m: 0.0,
        material,
    }
}

/// Returns the profile of a circular arc in `pieces` chords, from `half` metres before `at` to `half` behind it and
/// `height` above the floor, closed below the floor.
fn cap(at: f64, half: f64, height: f64, pieces: usize) -> Vec<[f64; 2]> {
    let radius = (half * half + height * height) / (2.0 * height);
    let most = libm::asin(half / radius);
    let mut points = vec![[at - half, -DEPTH_M]];
    points.extend((0..=pieces).map(|k| {
        let turn = most * (2.0 * k as f64 / pieces as f64 - 1.0);
        let (sin, cos) = libm::sincos(turn);
        [at + radius * sin, height - radius * (1.0 - cos)]
    }));
    points.push([at + half, -DEPTH_M]);
    points
}

/// Adds blisters from `from` to `to`: domes 5 mm high and 25 mm wide at a pitch of 64 to 67 mm
/// (CEN/TS 15209; Guidance on the use of tactile paving surfaces, 2021). Five rows lie beside each
/// other, which covers the beam.
///
/// A dome is modelled as a piece of cylinder, 20 mm wide across the way, the mean width of the
/// circle.
pub fn blisters(scene: &mut SceneSpec, (from, to): (f64, f64), material: &str, rng: &mut Random) {
    let pitch = rng.between(0.064, 0.067);
    let aside = rng.between(-0.5, 0.5) * pitch;
    let rows = ((to - from) / pitch) as usize;
    for row in 0..rows {
        let at = from + (row as f64 + 0.5) * pitch;
        for column in -2..=2 {
            scene.polyline.push(PolylineSpec {
                points: cap(at, 0.0125, 0.005, 12),
                closed: true,
                width_m: Some(0.020),
                lateral_m: aside + f64::from(column) * pitch,
                material: material.into(),
            });
        }
    }
}

/// Adds corduroy from `from` to `to`, metres: rounded bars across the way, 6 mm high and 20 mm wide at a pitch of 50 mm
/// (by the guidance cited for [`blisters`]).
pub fn corduroy(scene: &mut SceneSpec, (from, to): (f64, f64), material: &str, rng: &mut Random) {
    let pitch = rng.between(0.048, 0.052);
    let bars = ((to - from) / pitch) as usize;
    for bar in 0..bars {
        let at = from + (bar as f64 + 0.5) * pitch;
        let points = cap(at, 0.010, 0.006, 16);
        scene.polyline.push(solid(points, material.into()));
    }
}

/// Adds a grate from `from` to `to`, metres from the mirror: bars 3 to 6 mm thick and 20 to 30 mm high across the way,
/// at a pitch of up to 34 mm (EN 1433 channel grates; slots of 10 to 31 mm, into which wheels do not sink), over a
/// channel 8 to 20 cm deep.
pub fn grate(scene: &mut SceneSpec, (from, to): (f64, f64), rng: &mut Random) {
    let (thick, high) = (rng.between(0.003, 0.006), rng.between(0.020, 0.030));
    let wanted = rng.between(0.020, 0.034);
    let depth = rng.between(0.08, 0.20);
    // One bar at each end, and as many between as the pitch requires.
    let gaps = libm::ceil((to - from - thick) / wanted).max(1.0);
    let pitch = (to - from - thick) / gaps;
    for bar in 0..=gaps as usize {
        let front = from + bar as f64 * pitch;
        let (back, foot) = (front + thick, -high);
        let points = vec![[front, foot], [front, 0.0], [back, 0.0], [back, foot]];
        scene.polyline.push(solid(points, "metal".into()));
    }
    let channel = pick(rng, &["concrete", "metal"]);
    scene.floor.push(FloorSpec {
        from_m: from,
        to_m: Some(to),
        height_m: -depth,
        material: channel.clone(),
    });
    scene.wall.push(WallSpec {
        at_m: to,
        bottom_m: -depth,
        top_m: -high,
        material: channel,
    });
}
