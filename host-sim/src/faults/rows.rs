//! Faults of the mirror and of the order of rows.

use num_complex::Complex64;

use super::signal::Signal;

/// The mirror stands still from some row on; noise goes on.
pub fn stuck(signal: &mut Signal, rows: f64) {
    let from = signal.any_row(rows as usize);
    hold(signal, from, usize::MAX);
}

/// The mirror sticks for `rows` rows and then is where it belongs again.
pub fn sticks(signal: &mut Signal, rows: f64) {
    let from = signal.any_row(rows as usize);
    hold(signal, from, rows as usize);
}

/// Rows after `from` show what it shows, each with noise of its own.
fn hold(signal: &mut Signal, from: usize, rows: usize) {
    let end = from
        .saturating_add(1)
        .saturating_add(rows)
        .min(signal.rows());
    let held: Vec<_> = (from + 1..end).map(|row| signal.again(from, row)).collect();
    for (row, chirp) in (from + 1..end).zip(held) {
        signal.chirps[row] = chirp;
    }
}

/// The mirror has slipped by `degrees`, one way or the other, from some row on.
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
    // Nobody was there to see what lies beyond the last row.
    let kept = signal.rows() - (off.max(0.0) as usize).min(signal.rows() / 4);
    signal.chirps.truncate(kept);
    signal.recording.meta.angles_deg.truncate(kept);
}

/// The driver makes microsteps `factor` times as large as it is told.
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

/// Some `rows` adjacent rows.
fn block(signal: &mut Signal, rows: f64) -> core::ops::Range<usize> {
    let rows = (rows as usize).min(signal.rows().saturating_sub(2));
    let first = signal.any_row(rows);
    first..(first + rows).min(signal.rows())
}

/// Two neighbouring blocks of half as many rows change places.
pub fn swapped(signal: &mut Signal, rows: f64) {
    let block = block(signal, rows);
    let half = block.len() / 2;
    signal.chirps[block].rotate_left(half);
}

/// Rows come in any order.
pub fn shuffled(signal: &mut Signal, rows: f64) {
    let block = block(signal, rows);
    for k in (block.start + 1..block.end).rev() {
        let other = block.start + signal.random.index(k - block.start + 1);
        signal.chirps.swap(k, other);
    }
}

/// Rows come in the wrong order.
pub fn reversed(signal: &mut Signal, rows: f64) {
    let block = block(signal, rows);
    signal.chirps[block].reverse();
}

/// One row's chirp comes again and again, bit by bit.
pub fn repeated(signal: &mut Signal, rows: f64) {
    let block = block(signal, rows);
    let chirp = signal.chirps[block.start].clone();
    signal.chirps[block].fill(chirp);
}

/// Rows hold noise alone, or (for an odd draw) nothing.
pub fn empty(signal: &mut Signal, rows: f64) {
    let block = block(signal, rows);
    let noise = if signal.random.chance(0.5) { 1.0 } else { 0.0 };
    for row in block {
        let samples = signal.chirps[row].len();
        let chirp: Vec<Complex64> = (0..samples).map(|_| signal.noise(noise)).collect();
        signal.chirps[row] = chirp;
    }
}

/// Of `share` of the rows the chirp is that of the row before, under the right number.
pub fn stale(signal: &mut Signal, share: f64) {
    for row in (1..signal.rows()).rev() {
        if signal.random.chance(share) {
            signal.chirps[row] = signal.chirps[row - 1].clone();
        }
    }
}
