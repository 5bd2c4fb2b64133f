//! Flights of special shapes: soft, low, steep, with a landing, platforms, open treads, kerbs. Each function returns a
//! description of what it drew.

use super::draw::pick;
use super::flight::{flight, floor, opened, surroundings, uneven};
use super::odd::make_irregular;
use crate::scene::maths::Random;
use crate::scene::spec::{MaterialSpec, RampSpec, SceneSpec, StairsSpec, WallSpec};

/// Draws a flight with carpet over the nosings, or with worn or cast round nosings: radii of 1 to 2
/// cm.
///
/// Carpet has strong diffuse scatter: between asphalt's γ of -20 dB and the -8 dB of short grass at
/// W-band (Ulaby and Dobson, Handbook of Radar Scattering Statistics for Terrain). Cut pile is 5 to
/// 12 mm deep and soft; the relief that is drawn is the millimetre that stands up of it.
pub fn soft(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
    let count = 2 + rng.index(5);
    let mut s = flight(rng, count);
    s.nosing_radius_m = rng.between(0.010, 0.020);
    // A round nosing needs a tread slightly thicker than its diameter.
    s.tread_thickness_m = rng.between(0.046, 0.06);
    s.nosing_m = if rng.chance(0.4) {
        rng.between(0.01, 0.03)
    } else {
        0.0
    };
    let carpet = rng.chance(0.5);
    if carpet {
        s.material = "carpet".into();
        let pile = MaterialSpec {
            permittivity: rng.between(1.2, 1.8),
            conductivity: rng.between(0.1, 0.5),
            roughness_m: rng.between(0.4e-3, 1.2e-3),
            correlation_m: rng.between(1.5e-3, 4e-3),
            diffuse_db: rng.between(-20.0, -10.0),
            ..MaterialSpec::default()
        };
        scene.materials.insert("carpet".into(), pile);
    } else {
        s.material = pick(rng, &["painted-wood", "concrete"]);
    }
    uneven(&mut s, rng);
    surroundings(scene, &s, rng);
    if carpet && rng.chance(0.5) {
        scene.floor[0].material = "carpet".into();
    }
    scene.stairs.push(s);
    if carpet { "carpet" } else { "round noses" }
}

/// Draws low and deep steps of parks, forecourts and stands: rises of 6 to 12 cm, goings of 35 to
/// 60 cm, the treads falling towards the front by 1 to 3 % (paving practice; DIN 18318 asks for 2
/// to 3 %).
pub fn low(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
    let count = 1 + rng.index(5);
    let mut s = flight(rng, count);
    s.rise_m = rng.between(0.06, 0.12);
    s.going_m = rng.between(0.35, 0.60);
    s.material = pick(
        rng,
        &["concrete", "concrete", "dark-ceramic", "painted-wood"],
    );
    s.tread_fall = if rng.chance(0.7) {
        rng.between(0.01, 0.03)
    } else {
        0.0
    };
    s.nosing_m = if rng.chance(0.2) {
        rng.between(0.01, 0.03)
    } else {
        0.0
    };
    uneven(&mut s, rng);
    surroundings(scene, &s, rng);
    let what = if s.tread_fall > 0.0 {
        "low, with fall"
    } else {
        "low, level"
    };
    scene.stairs.push(s);
    what
}

/// Draws attic, cellar or ship's stairs: rises of 20 to 25 cm, goings of 18 to 24 cm, whose treads
/// are deep enough only with an overhang.
pub fn steep(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
    let count = 2 + rng.index(5);
    let mut s = flight(rng, count);
    s.rise_m = rng.between(0.20, 0.25);
    s.going_m = rng.between(0.18, 0.24);
    s.nosing_m = if rng.chance(0.6) {
        rng.between(0.02, 0.05)
    } else {
        0.0
    };
    let open = rng.chance(0.3);
    if open {
        opened(&mut s, rng);
        s.tread_depth_m = Some(s.going_m + rng.between(0.02, 0.06));
    }
    uneven(&mut s, rng);
    surroundings(scene, &s, rng);
    scene.stairs.push(s);
    if open { "steep, floating" } else { "steep" }
}

/// Draws two flights with a landing between them, as deep as codes require (0.9 m and more) or
/// slightly less. They are so near that part of the second flight lies within the range.
pub fn landing(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
    let (first, second) = (1 + rng.index(3), 1 + rng.index(3));
    let mut s = flight(rng, first + second);
    s.distance_m = rng.between(0.4, 0.8);
    s.tread_depth_m = None;
    uneven(&mut s, rng);
    s.goings_m[first - 1] = rng.between(0.75, 1.4);
    // The second flight may be of different workmanship.
    if rng.chance(0.3) {
        let off = rng.between(-0.02, 0.02);
        for rise in &mut s.rises_m[first..] {
            *rise += off;
        }
    }
    surroundings(scene, &s, rng);
    scene.stairs.push(s);
    "landing"
}

/// Draws a stage, a loading step or a shower base: one step of 18 to 30 cm, higher than a chair
/// climbs.
pub fn platform(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
    let mut s = flight(rng, 1);
    s.distance_m = rng.between(0.4, 1.8);
    s.rise_m = rng.between(0.18, 0.30);
    s.material = pick(rng, &["painted-wood", "concrete", "dark-ceramic", "metal"]);
    s.nosing_m = if rng.chance(0.3) {
        rng.between(0.01, 0.05)
    } else {
        0.0
    };
    s.landing_m = rng.between(0.6, 2.2);
    surroundings(scene, &s, rng);
    // Half of the platforms end at a wall.
    if rng.chance(0.5) {
        scene.wall.push(WallSpec {
            at_m: s.distance_m + s.landing_m,
            bottom_m: 0.0,
            top_m: 2.5,
            material: pick(rng, &["plaster", "concrete", "painted-wood"]),
        });
    }
    scene.stairs.push(s);
    "platform"
}

/// Draws floating treads: slabs of wood, concrete or stone 3 to 8 cm thick, or gratings 25 to 40 mm
/// high (EN ISO 14122-3), bare or behind a C-channel 30 to 80 mm high as nosing.
pub fn open(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
    let count = 2 + rng.index(5);
    let mut s = flight(rng, count);
    opened(&mut s, rng);
    let what = match rng.index(3) {
        0 => {
            s.material = pick(rng, &["painted-wood", "concrete", "dark-ceramic"]);
            s.tread_thickness_m = rng.between(0.03, 0.08);
            "slabs"
        }
        1 => {
            grating(&mut s, rng);
            "gratings"
        }
        _ => {
            grating(&mut s, rng);
            s.channel_m = rng.between(0.03, 0.08);
            s.channel_flange_m = rng.between(0.02, 0.05);
            s.channel_open = rng.chance(0.25);
            if s.channel_open {
                "gratings behind open channels"
            } else {
                "gratings behind channels"
            }
        }
    };
    uneven(&mut s, rng);
    surroundings(scene, &s, rng);
    scene.stairs.push(s);
    what
}

fn grating(s: &mut StairsSpec, rng: &mut Random) {
    s.material = "grating".into();
    s.tread_thickness_m = rng.between(0.025, 0.04);
    s.nosing_radius_m = rng.between(0.0005, 0.0015);
    // The foremost bearing bar is solid.
    s.riser_material = Some("metal".into());
}

/// Draws a kerb of 3 to 8 cm. The road falls towards it by up to 5 % or rises to a lowered kerb,
/// the pavement behind the kerb stone (12 to 18 cm, EN 1340) rises by 1 to 8 %, or all is level.
pub fn kerb(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
    let mut s = flight(rng, 1);
    s.distance_m = rng.between(0.4, 1.6);
    s.rise_m = rng.between(0.03, 0.08);
    s.nosing_m = 0.0;
    // EN 1340: arris, chamfer or bullnose.
    s.nosing_radius_m = rng.between(0.002, 0.014);
    s.material = pick(rng, &["concrete", "concrete", "dark-ceramic", "metal"]);
    let road = pick(rng, &["concrete", "dark-ceramic"]);
    let (before, after) = (rng.chance(0.5), rng.chance(0.5));
    if before {
        let from = s.distance_m - rng.between(0.2, 0.5);
        let slope = rng.between(0.01, 0.05);
        let down = rng.chance(0.6);
        let base = if down { -slope } else { slope } * (s.distance_m - from);
        scene.floor.push(floor(road.clone(), Some(from)));
        scene.ramp.push(RampSpec {
            from_m: from,
            to_m: s.distance_m,
            from_height_m: 0.0,
            to_height_m: base,
            material: road,
        });
        s.base_m = base;
    } else {
        scene.floor.push(floor(road, None));
    }
    if after {
        s.landing_m = rng.between(0.12, 0.18);
        let from = s.distance_m + s.landing_m;
        let (length, top) = (rng.between(0.5, 1.5), s.base_m + s.rise_m);
        scene.ramp.push(RampSpec {
            from_m: from,
            to_m: from + length,
            from_height_m: top,
            to_height_m: top + length * rng.between(0.01, 0.08),
            material: pick(rng, &["concrete", "dark-ceramic"]),
        });
    }
    scene.stairs.push(s);
    match (before, after) {
        (false, false) => "kerb, level",
        (true, false) => "kerb, slope before",
        (false, true) => "kerb, slope behind",
        (true, true) => "kerb, slopes before and behind",
    }
}

/// Draws the regularity of a flight: as codes require (half of these exact to the millimetre), or with all rises and
/// goings off.
pub fn workmanship(s: &mut StairsSpec, rng: &mut Random) {
    if rng.chance(0.7) {
        uneven(s, rng);
    } else {
        make_irregular(s, rng);
    }
}
