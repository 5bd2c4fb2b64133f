//! Irregular flights: with one step off, with all steps off, or with one odd rise or going.

use super::flight::{flight, opened, surroundings};
use crate::scene::maths::Random;
use crate::scene::spec::{SceneSpec, StairsSpec};

/// Draws a flight with one rise off by 2 to 4 cm, the following steps shifted with it. Returns its description.
pub fn irregular(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
    let count = 3 + rng.index(4);
    let mut s = flight(rng, count);
    let open = rng.chance(0.15);
    if open {
        opened(&mut s, rng);
    }
    s.rises_m = vec![s.rise_m; count];
    s.goings_m = vec![s.going_m; count - 1];
    let odd = rng.index(count);
    let off = rng.between(0.02, 0.04);
    let up = rng.chance(0.5);
    // Between a low kerb and the highest climbable step.
    let rise = if up && s.rise_m + off < 0.235 {
        s.rise_m + off
    } else {
        s.rise_m - off
    };
    s.rises_m[odd] = rise;
    surroundings(scene, &s, rng);
    scene.stairs.push(s);
    if open {
        "floating, one step off"
    } else {
        "closed, one step off"
    }
}

/// Draws a flight whose rises and goings are all slightly off, and returns its description. A building code lets the
/// largest and the smallest differ by 9.5 mm (IRC R311.7.5.1); old, outdoor and hand-made flights exceed that two or
/// three times.
pub fn uneven(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
    let count = 2 + rng.index(5);
    let mut s = flight(rng, count);
    let open = rng.chance(0.15);
    if open {
        opened(&mut s, rng);
    }
    make_irregular(&mut s, rng);
    surroundings(scene, &s, rng);
    scene.stairs.push(s);
    if open {
        "floating, every step off a bit"
    } else {
        "closed, every step off a bit"
    }
}

/// Draws every rise and going of `s` about the flight's own rise and going, with a standard deviation of 4 to 12 mm and
/// 4 to 20 mm.
pub fn make_irregular(s: &mut StairsSpec, rng: &mut Random) {
    let (rise, going) = (rng.between(0.004, 0.012), rng.between(0.004, 0.020));
    s.rises_m = (0..s.count)
        .map(|_| s.rise_m + (rise * rng.normal()).clamp(-0.025, 0.025))
        .collect();
    s.goings_m = (1..s.count)
        .map(|_| s.going_m + (going * rng.normal()).clamp(-0.04, 0.04))
        .collect();
}

/// Minimum and maximum of a rise that is made odd, metres: the lowest that counts as a step, and one higher than a
/// chair can climb.
const RISES: (f64, f64) = (0.06, 0.27);

/// Draws a flight with one odd rise, one odd going, or both, otherwise regular. Returns its description.
pub fn odd(scene: &mut SceneSpec, rng: &mut Random) -> &'static str {
    let count = 2 + rng.index(5);
    let mut s = flight(rng, count);
    let open = rng.chance(0.15);
    if open {
        opened(&mut s, rng);
    }
    let what = oddity(&mut s, rng);
    surroundings(scene, &s, rng);
    scene.stairs.push(s);
    what
}

/// Makes one rise or going (or both) of a regular flight odd, and returns a description of the change.
///
/// A floor laid after the stairs makes the first rise low or the last one high (all following steps are shifted with
/// it). A tread set at a wrong place is compensated by the next one (the following steps stay).
pub fn oddity(s: &mut StairsSpec, rng: &mut Random) -> &'static str {
    s.rises_m = vec![s.rise_m; s.count];
    s.goings_m = vec![s.going_m; s.count - 1];
    let draw = rng.unit();
    let (rise, going) = (draw < 0.8, draw >= 0.7 && s.count > 2);
    let mut staying = false;
    if rise || !going {
        let place = match rng.unit() {
            p if p < 0.35 => 0,
            p if p < 0.55 => s.count - 1,
            _ => rng.index(s.count),
        };
        staying = rng.chance(0.4);
        let off = odd_rise(s.rise_m, rng);
        shift(&mut s.rises_m, place, off, staying);
    }
    if going {
        let place = rng.index(s.count - 1);
        let stays = rng.chance(0.5);
        // Up to 8 cm: a winder's wedge, a tread set back for a pipe.
        let off = rng.between(0.03, 0.08).min(0.3 * s.going_m);
        let off = if rng.chance(0.5) { off } else { -off };
        shift(&mut s.goings_m, place, off, stays);
    }
    match (rise || !going, going, staying) {
        (true, false, false) => "odd rise, rest following",
        (true, false, true) => "odd rise, rest staying",
        (true, true, _) => "odd rise and going",
        _ => "odd going",
    }
}

/// Draws the deviation of an odd rise from the regular `rise`, metres: 2 to 5 cm up or down, as long as the odd rise
/// and the compensating one stay within [`RISES`].
fn odd_rise(rise: f64, rng: &mut Random) -> f64 {
    let room = (RISES.1 - rise).min(rise - RISES.0);
    let off = rng.between(0.02, room.clamp(0.02, 0.05));
    if rng.chance(0.5) { off } else { -off }
}

/// Adds `off`, metres, to `values[place]`, a rise or going. If `staying`, `off` is subtracted from the next value, so
/// that all following steps stay in place.
fn shift(values: &mut [f64], place: usize, off: f64, staying: bool) {
    if let Some(value) = values.get_mut(place) {
        *value += off;
    }
    if let Some(next) = values.get_mut(place + 1).filter(|_| staying) {
        *next -= off;
    }
}
