//! Faults of the mirror and of the order of rows.

use num_complex::Complex64;

use super::signal::Signal;

/// The mirror stops at a random row, more than `rows` rows before the end: all later rows repeat its echoes with other
/// noise.
pub fn stuck(signal: &mut Signal, rows: f64) {
    let from = signal.any_row(rows as usize);
    hold(signal, from, usize::MAX);
}

/// The mirror stops for `rows` rows, which repeat the echoes of the row before them with other noise, and then is at
/// the right angle again.
pub fn sticks(signal: &mut Signal, rows: f64) {
    let from = signal.any_row(rows as usize);
    hold(signal, from, rows as usize);
}

/// Replaces the chirps of the `rows` rows after row `from` by repetitions of the echoes of row `from`, each with its
/// own noise.
fn hold(signal: &mut Signal, from: usize, rows: usize) {
    let end = from
        .saturating_add(1)
        .saturating_add(rows)
        .min(signal.rows());
    let held: Vec<_> = (from + 1..end)
        .map(|row| signal.repeated_chirp(from, row))
        .collect();
    for (row, chirp) in (from + 1..end).zip(held) {
        signal.chirps[row] = chirp;
    }
}

/// The mirror has slipped by `degrees` of beam angle, up or down at random, from a random row on: later rows have the
/// echoes of another angle than recorded.
pub fn slipped(signal: &mut Signal, degrees: f64) {
    let from = signal.any_row(40);
    let way = if signal.random.chance(0.5) { 1.0 } else { -1.0 };
    let off = way * degrees / signal.step_deg().abs();
    let late: Vec<_> = (from..signal.rows())
        .map(|row| signal.between(row as f64 + off, row))
        .collect();
    for (row, chirp) in (from..).zip(late) {
        signal.chirps[row] = chirp;
    }
    // The echoes beyond the last row are unknown.
    let kept = signal.rows() - (off.max(0.0) as usize).min(signal.rows() / 4);
    signal.chirps.truncate(kept);
    signal.recording.meta.angles_deg.truncate(kept);
}

/// The driver's microsteps are `factor` times as large as configured, so that the recorded angles, counted from the
/// first row's, are 1 / `factor` of the true ones.
pub fn microsteps(signal: &mut Signal, factor: f64) {
    let rows = signal.rows();
    let first = signal.angle_deg(0);
    let seen = if factor < 1.0 {
        (rows as f64 * factor) as usize
    } else {
        rows
    };
    signal.chirps.truncate(seen);
    let angles = &mut signal.recording.meta.angles_deg;
    angles.truncate(seen);
    for angle in angles {
        *angle = first + (*angle - first) / factor;
    }
}

/// Returns the indices of `rows` adjacent rows at a random place in the scan.
fn block(signal: &mut Signal, rows: f64) -> core::ops::Range<usize> {
    let rows = (rows as usize).min(signal.rows().saturating_sub(2));
    let first = signal.any_row(rows);
    first..(first + rows).min(signal.rows())
}

/// The two halves of a random block of `rows` rows are exchanged.
pub fn swapped(signal: &mut Signal, rows: f64) {
    let block = block(signal, rows);
    let half = block.len() / 2;
    signal.chirps[block].rotate_left(half);
}

/// The chirps of a random block of `rows` rows are shuffled.
pub fn shuffled(signal: &mut Signal, rows: f64) {
    let block = block(signal, rows);
    for k in (block.start + 1..block.end).rev() {
        let other = block.start + signal.random.index(k - block.start + 1);
        signal.chirps.swap(k, other);
    }
}

/// The chirps of a random block of `rows` rows are in reverse order.
pub fn reversed(signal: &mut Signal, rows: f64) {
    let block = block(signal, rows);
    signal.chirps[block].reverse();
}

/// All rows of a random block of `rows` rows have the same chirp, bit by bit.
pub fn repeated(signal: &mut Signal, rows: f64) {
    let block = block(signal, rows);
    let chirp = signal.chirps[block.start].clone();
    signal.chirps[block].fill(chirp);
}

/// A random block of `rows` rows contains only noise or, with probability ½, zeros.
pub fn empty(signal: &mut Signal, rows: f64) {
    let block = block(signal, rows);
    let noise = if signal.random.chance(0.5) { 1.0 } else { 0.0 };
    for row in block {
        let samples = signal.chirps[row].len();
        let chirp: Vec<Complex64> = (0..samples).map(|_| signal.noise(noise)).collect();
        signal.chirps[row] = chirp;
    }
}

/// A fraction `share` of the rows, at random, has the previous row's chirp in place of its own, with the right row
/// number.
pub fn stale(signal: &mut Signal, share: f64) {
    for row in (1..signal.rows()).rev() {
        if signal.random.chance(share) {
            signal.chirps[row] = signal.chirps[row - 1].clone();
        }
    }
}
