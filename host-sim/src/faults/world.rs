//! Faults in front of the scanner, and motion of the chair.

use num_complex::Complex64;

use super::signal::Signal;
use crate::scene::maths::{LIGHT, amplitude, cis};

/// Level of a hand, a bag or a coat over the scanner above the strongest echo, dB.
const BLOCKER_DB: f64 = 6.0;
/// Attenuation of its second echo by way of the mirror, dB.
const BOUNCE_DB: f64 = 20.0;
/// Level of a person's legs below a specular reflection, dB.
const PERSON_DB: f64 = 10.0;
/// Reference range of levels, metres; echoes fall with its square.
const NEAR_M: f64 = 0.5;

/// Rain or dirt on the window attenuates every echo from beyond it by `db`.
pub fn window(signal: &mut Signal, db: f64) {
    let gain = amplitude(-db);
    for row in 0..signal.rows() {
        let mut echoes = signal.outside(row);
        for echo in &mut echoes {
            *echo = *echo * gain + signal.noise(1.0 - gain * gain);
        }
        signal.set_outside(row, &echoes);
    }
}

/// An object hides everything behind it in `rows`, at the range `range_m` of each row.
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
        signal.set_outside(row, &echoes);
    }
}

/// An object covers all rows, at `metres`.
pub fn blocked(signal: &mut Signal, metres: f64) {
    let rows = 0..signal.rows();
    hide(signal, rows, BLOCKER_DB, |_| metres);
}

/// An object covers the rows on one side of a random angle between 0 and 25°.
fn blocked_part(signal: &mut Signal, metres: f64, lower: bool) {
    let edge = signal.random.between(0.0, 25.0);
    let below = |signal: &Signal, row: usize| signal.angle_deg(row) > edge;
    let rows: Vec<usize> = (0..signal.rows())
        .filter(|&r| below(signal, r) == lower)
        .collect();
    hide(signal, rows.into_iter(), BLOCKER_DB, |_| metres);
}

/// An object covers the lower rows, at `metres`.
pub fn blocked_below(signal: &mut Signal, metres: f64) {
    blocked_part(signal, metres, true);
}

/// An object covers the upper rows, at `metres`.
pub fn blocked_above(signal: &mut Signal, metres: f64) {
    blocked_part(signal, metres, false);
}

/// A person crosses at `metres` while the mirror turns by 15°.
pub fn person_crosses(signal: &mut Signal, metres: f64) {
    let rows = (15.0 / signal.step_deg().abs()) as usize;
    let first = signal.any_row(rows);
    let rows = first..(first + rows).min(signal.rows());
    hide(signal, rows, -PERSON_DB, |_| metres);
}

/// A person approaches by a metre during the scan, down to `metres`.
pub fn person_approaches(signal: &mut Signal, metres: f64) {
    let rows = signal.rows();
    let range = |row: usize| metres + 1.0 - row as f64 / rows as f64;
    hide(signal, 0..rows, -PERSON_DB, range);
}

/// Shifts the echoes of every row by `range_m`, metres.
fn shift(signal: &mut Signal, range_m: impl Fn(&Signal, usize) -> f64) {
    let wave = 2.0 * core::f64::consts::TAU * signal.recording.meta.carrier_hz / LIGHT;
    for row in 0..signal.rows() {
        let by = range_m(signal, row);
        let turn = signal.turn(by);
        let mut echoes = signal.outside(row);
        for (echo, turn) in echoes.iter_mut().zip(&turn) {
            *echo *= turn * cis(wave * by);
        }
        signal.set_outside(row, &echoes);
    }
}

/// The chair creeps forward by `metres` during the scan. The ground truth is relative to the final
/// position.
pub fn creeps(signal: &mut Signal, metres: f64) {
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

/// The chair rocks by ±`degrees`, twice during the scan.
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
