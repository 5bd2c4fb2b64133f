//! Conversion of the shapes of a scene file to segments and edges.

use super::flight::{Lookup, stairs};
use super::geometry::{BuiltStep, Lateral, Skin, World};
use super::maths::Vec2;
use super::spec::{BoxSpec, DoorSpec, SceneSpec, Way};

/// End of a floor without a given end when no flight goes up from it, metres.
const FLOOR_END: f64 = 4.0;

/// Builds the segments, edges and steps of all shapes of a checked scene; `material` returns a material's index.
pub fn build(spec: &SceneSpec, material: Lookup) -> World {
    let mut world = World::default();
    for s in &spec.stairs {
        stairs(&mut world, s, material);
    }
    let foot = spec
        .stairs
        .iter()
        .filter(|s| s.direction == Way::Up && !s.open)
        .map(|s| s.distance_m + s.nosing_m - s.batter_m)
        .fold(FLOOR_END, f64::min);
    for f in &spec.floor {
        let end = f.to_m.unwrap_or(foot);
        let points = [Vec2::new(f.from_m, f.height_m), Vec2::new(end, f.height_m)];
        world.outline(&points, false, |_| wide(material(&f.material)));
    }
    for r in &spec.ramp {
        let points = [
            Vec2::new(r.from_m, r.from_height_m),
            Vec2::new(r.to_m, r.to_height_m),
        ];
        world.outline(&points, false, |_| wide(material(&r.material)));
    }
    for w in &spec.wall {
        let points = [Vec2::new(w.at_m, w.bottom_m), Vec2::new(w.at_m, w.top_m)];
        world.outline(&points, false, |_| wide(material(&w.material)));
    }
    for p in &spec.post {
        let r = 0.5 * p.diameter_m;
        let skin = Skin {
            material: material(&p.material),
            lateral: Lateral {
                centre: p.lateral_m,
                half: r,
                round: true,
            },
        };
        let corners = [(p.at_m - r, p.bottom_m), (p.at_m + r, p.top_m)];
        world.outline(&rectangle(corners), true, |_| skin);
    }
    for b in &spec.boxes {
        solid(&mut world, b, material);
    }
    for d in &spec.door {
        door(&mut world, d, material);
    }
    for p in &spec.polyline {
        let points: Vec<Vec2> = p.points.iter().map(|&[x, y]| Vec2::new(x, y)).collect();
        let skin = Skin {
            material: material(&p.material),
            lateral: Lateral::of(p.width_m, p.lateral_m),
        };
        if p.closed {
            world.outline(&points, true, |_| skin);
        } else {
            world.sheet(&points, skin);
        }
    }
    world.turn(spec.mount.yaw_deg.to_radians());
    world
}

fn wide(material: usize) -> Skin {
    Skin {
        material,
        lateral: Lateral::WIDE,
    }
}

fn rectangle([(x0, y0), (x1, y1)]: [(f64, f64); 2]) -> [Vec2; 4] {
    [
        Vec2::new(x0, y0),
        Vec2::new(x0, y1),
        Vec2::new(x1, y1),
        Vec2::new(x1, y0),
    ]
}

fn solid(world: &mut World, b: &BoxSpec, material: Lookup) {
    let skin = Skin {
        material: material(&b.material),
        lateral: Lateral::of(b.width_m, b.lateral_m),
    };
    let corners = [(b.from_m, b.bottom_m), (b.to_m, b.top_m)];
    world.outline(&rectangle(corners), true, |_| skin);
    if b.bottom_m > 0.0 {
        return;
    }
    let front = BuiltStep {
        distance: b.from_m,
        height: b.top_m,
        rise: b.top_m,
        edge: Vec2::new(b.from_m, b.top_m),
        span: (b.bottom_m, b.top_m),
        below: None,
    };
    if b.mountable {
        world.up.push(front);
    } else {
        world.boxes.push(front);
    }
}

fn door(world: &mut World, d: &DoorSpec, material: Lookup) {
    let part = |bottom: f64, top: f64, lateral: f64, width: Option<f64>| BoxSpec {
        from_m: d.at_m,
        to_m: d.at_m + d.depth_m,
        bottom_m: bottom,
        top_m: top,
        width_m: width,
        lateral_m: lateral,
        mountable: false,
        material: d.material.clone(),
    };
    let beside = 0.5 * (d.width_m + d.frame_m);
    for side in [-beside, beside] {
        let jamb = part(0.0, d.height_m, d.lateral_m + side, Some(d.frame_m));
        solid(world, &jamb, material);
    }
    let lintel = part(d.height_m, d.height_m + d.frame_m, 0.0, None);
    solid(world, &lintel, material);
    if d.threshold_m > 0.0 {
        let sill = part(0.0, d.threshold_m, d.lateral_m, Some(d.width_m));
        solid(world, &sill, material);
    }
}
