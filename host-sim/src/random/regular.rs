//! Regular flights, up and down.

use super::draw::pick;
use super::flight::{flight, opened, surroundings, uneven};
use crate::scene::maths::Random;
use crate::scene::spec::{PlaneSpec, SceneSpec, Way};

/// Draws a flight or kerb going up, with its surroundings. Returns its type.
pub fn ascending(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
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

/// Draws a flight going down from under the scanner, which a pole holds out over the first edge. Returns its type.
pub fn descending(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
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
