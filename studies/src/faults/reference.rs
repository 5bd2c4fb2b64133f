//! Faults of the phase reference, the mirror's own echo, to whose phase the scanner brings each row.

use core::f64::consts::TAU;

use num_complex::Complex64;

use super::signal::Signal;
use host_sim::scene::maths::{amplitude, cis};

/// Replaces the mirror's own echo by `factor` times itself in a fraction `share` of the rows, at random.
fn some_rows(signal: &mut Signal, share: f64, mut factor: impl FnMut(&mut Signal) -> Complex64) {
    let own = signal.own_echo();
    for row in 0..signal.rows() {
        if signal.random.chance(share) {
            let more = factor(signal) - Complex64::ONE;
            signal.add_echo(row, &own, more);
        }
    }
}

/// The mirror's own echo is missing in a fraction `share` of the rows, at random.
pub fn lost(signal: &mut Signal, share: f64) {
    some_rows(signal, share, |_| Complex64::ZERO);
}

/// The mirror's own echo is `db` dB weaker in all rows; the scene's echoes keep their levels.
pub fn weak(signal: &mut Signal, db: f64) {
    some_rows(signal, 1.0, |_| Complex64::from(amplitude(-db)));
}

/// The mirror's own echo has a random phase in a fraction `share` of the rows, at random.
pub fn jumps(signal: &mut Signal, share: f64) {
    some_rows(signal, share, |signal| cis(signal.random.between(0.0, TAU)));
}

/// The mirror's own echo is half a turn off in a fraction `share` of the rows, at random.
pub fn flips(signal: &mut Signal, share: f64) {
    some_rows(signal, share, |_| -Complex64::ONE);
}
