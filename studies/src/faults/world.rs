//! Faults in front of the scanner, and motion of the chair.

use num_complex::Complex64;

use super::signal::Signal;
use host_sim::scene::maths::{LIGHT, amplitude, cis};

/// Level of the echo of a hand, a bag or a coat over the scanner: dB over the signal of the scene's strongest row.
const BLOCKER_DB: f64 = 6.0;
/// Attenuation of the second echo of an object over the scanner, at twice its range by way of the mirror: dB below the
/// object's first echo.
const BOUNCE_DB: f64 = 20.0;
/// Level of the echo of a person's legs, dB below the signal of the scene's strongest row.
const PERSON_DB: f64 = 10.0;
/// Range up to which the echo of an object in front of the scanner has its full amplitude, metres; beyond it the
/// amplitude falls with the square of the range.
const NEAR_M: f64 = 0.5;

/// Rain or dirt on the window attenuates the scene's echoes by `db` dB; the noise stays.
pub fn window(signal: &mut Signal, db: f64) {
    let gain = amplitude(-db);
    for row in 0..signal.rows() {
        let mut echoes = signal.scene_echoes(row);
        for echo in &mut echoes {
            *echo = *echo * gain + signal.noise(1.0 - gain * gain);
        }
        signal.set_scene_echoes(row, &echoes);
    }
}

/// Replaces the echoes of `rows` by those of an object that hides everything behind it. `range_m` gives its distance
/// from the mirror for each row, metres; the echo is `db` dB over the signal of the scene's strongest row.
fn hide(
    signal: &mut Signal,
    rows: impl Iterator<Item = usize>,
    db: f64,
    range_m: impl Fn(usize) -> f64,
) {
    let strongest = signal.strongest() * amplitude(db);
    // A level that saturates the converter is no longer a fault of the scene.
    let level = strongest.min(0.2 * 32768.0);
    for row in rows {
        let range = range_m(row);
        let rough = signal.random.between(0.7, 1.0);
        let near = level * rough * (NEAR_M / range.max(NEAR_M)) * (NEAR_M / range.max(NEAR_M));
        let first = signal.tone(range);
        let second = signal.tone(2.0 * range);
        let echoes: Vec<Complex64> = first
            .iter()
            .zip(&second)
            .map(|(a, b)| a * near + b * (near * amplitude(-BOUNCE_DB)) + signal.noise(1.0))
            .collect();
        signal.set_scene_echoes(row, &echoes);
    }
}

/// An object hides the scene in all rows, `metres` from the mirror.
pub fn blocked(signal: &mut Signal, metres: f64) {
    let rows = 0..signal.rows();
    hide(signal, rows, BLOCKER_DB, |_| metres);
}

/// An object, `metres` from the mirror, hides the scene on one side of a beam angle drawn between 0 and 25°: in all
/// rows at larger angles if `lower`, else in those at smaller ones. Angles count from the plane's zero: downwards from
/// the horizontal (stairs going up), or forwards from straight down (stairs going down).
fn blocked_part(signal: &mut Signal, metres: f64, lower: bool) {
    let edge = signal.random.between(0.0, 25.0);
    let below = |signal: &Signal, row: usize| signal.angle_deg(row) > edge;
    let rows: Vec<usize> = (0..signal.rows())
        .filter(|&r| below(signal, r) == lower)
        .collect();
    hide(signal, rows.into_iter(), BLOCKER_DB, |_| metres);
}

/// An object, `metres` from the mirror, hides the scene in all rows at larger beam angles than a random one of 0 to
/// 25°: below it where angles count from the horizontal, ahead of it where they count from straight down.
pub fn blocked_below(signal: &mut Signal, metres: f64) {
    blocked_part(signal, metres, true);
}

/// An object, `metres` from the mirror, hides the scene in all rows at smaller beam angles than a random one of 0 to
/// 25°: above it where angles count from the horizontal, behind it where they count from straight down.
pub fn blocked_above(signal: &mut Signal, metres: f64) {
    blocked_part(signal, metres, false);
}

/// A person crosses at `metres` from the mirror while the mirror turns by 15°, and hides the scene in these rows.
pub fn person_crosses(signal: &mut Signal, metres: f64) {
    let rows = (15.0 / signal.step_deg().abs()) as usize;
    let first = signal.any_row(rows);
    let rows = first..(first + rows).min(signal.rows());
    hide(signal, rows, -PERSON_DB, |_| metres);
}

/// A person approaches by a metre during the scan, from `metres` + 1 m to `metres`, and hides the scene in all rows.
pub fn person_approaches(signal: &mut Signal, metres: f64) {
    let rows = signal.rows();
    let range = |row: usize| metres + 1.0 - row as f64 / rows as f64;
    hide(signal, 0..rows, -PERSON_DB, range);
}

/// Shifts the scene's echoes in range, in each row by `range_m` of the scan and the row's index, metres, positive away
/// from the radar.
fn shift(signal: &mut Signal, range_m: impl Fn(&Signal, usize) -> f64) {
    let wave = 2.0 * core::f64::consts::TAU * signal.recording.meta.carrier_hz / LIGHT;
    for row in 0..signal.rows() {
        let by = range_m(signal, row);
        let turn = signal.turn(by);
        let mut echoes = signal.scene_echoes(row);
        for (echo, turn) in echoes.iter_mut().zip(&turn) {
            *echo *= turn * cis(wave * by);
        }
        signal.set_scene_echoes(row, &echoes);
    }
}

/// The chair creeps forward by `metres` during the scan. The ground truth becomes that of the final position.
pub fn chair_moves(signal: &mut Signal, metres: f64) {
    let rows = signal.rows() as f64;
    shift(signal, |signal, row| {
        -metres * row as f64 / rows * libm::cos(signal.angle_deg(row).to_radians())
    });
    if let Some(truth) = &mut signal.recording.meta.truth {
        let steps = truth.steps.iter_mut().chain(&mut truth.uncounted);
        steps.for_each(|step| step.distance_m -= metres);
        for drop in truth.drops.iter_mut().flatten() {
            drop.distance_m -= metres;
            drop.far_m = drop.far_m.map(|far| far - metres);
        }
    }
}

/// The chair's pitch oscillates by ±`degrees`, two periods during the scan: each row has the echoes of another angle.
pub fn rocks(signal: &mut Signal, degrees: f64) {
    let rows = signal.rows();
    let (step, turn) = (signal.step_deg().abs(), signal.random.between(0.0, 6.0));
    let rocked: Vec<_> = (0..rows)
        .map(|row| {
            let phase = 2.0 * core::f64::consts::TAU * row as f64 / rows as f64 + turn;
            signal.between(row as f64 + degrees / step * libm::sin(phase), row)
        })
        .collect();
    signal.chirps = rocked;
}
