//! Faults of the receiver and its converter: channels, bits, levels, interference.

use num_complex::Complex64;

use super::signal::Signal;
use host_sim::scene::maths::{amplitude, cis};

/// Replaces every sample of every chirp by the result of `change`.
fn each(signal: &mut Signal, change: impl Fn(Complex64) -> Complex64) {
    for sample in signal.chirps.iter_mut().flatten() {
        *sample = change(*sample);
    }
}

/// Replaces the 16-bit word of every sample of one channel, I or Q at random, by the result of `change`.
fn bits(signal: &mut Signal, change: impl Fn(i16) -> i16) {
    let imaginary = signal.random.index(2) == 1;
    let word = |x: f64| f64::from(change(libm::floor(x + 0.5) as i16));
    each(signal, |s| match imaginary {
        true => Complex64::new(s.re, word(s.im)),
        false => Complex64::new(word(s.re), s.im),
    });
}

/// Bit `bit` of I or of Q is always set; bit 0 is the lowest.
pub fn bit_high(signal: &mut Signal, bit: f64) {
    bits(signal, |x| x | (1i16 << bit as u32));
}

/// Bit `bit` of I or of Q is never set; bit 0 is the lowest.
pub fn bit_low(signal: &mut Signal, bit: f64) {
    bits(signal, |x| x & !(1i16 << bit as u32));
}

/// I or Q has lost its sign: its samples are magnitudes.
pub fn sign_lost(signal: &mut Signal, _: f64) {
    bits(signal, |x| x.saturating_abs());
}

/// I and Q change places.
pub fn swapped(signal: &mut Signal, _: f64) {
    each(signal, |s| Complex64::new(s.im, s.re));
}

/// Q has the wrong sign, so that each sample is conjugated.
pub fn conjugated(signal: &mut Signal, _: f64) {
    each(signal, |s| s.conj());
}

/// I or Q is always zero.
pub fn dead(signal: &mut Signal, _: f64) {
    let imaginary = signal.random.index(2) == 1;
    each(signal, |s| match imaginary {
        true => Complex64::new(s.re, 0.0),
        false => Complex64::new(0.0, s.im),
    });
}

/// Both channels have the samples of I.
pub fn equal(signal: &mut Signal, _: f64) {
    each(signal, |s| Complex64::new(s.re, s.re));
}

/// The amplitude of Q is `db` dB below that of I.
pub fn gain_imbalance(signal: &mut Signal, db: f64) {
    let gain = amplitude(-db);
    each(signal, |s| Complex64::new(s.re, s.im * gain));
}

/// The phase between I and Q differs from 90° by `degrees`.
pub fn phase_imbalance(signal: &mut Signal, degrees: f64) {
    let (sin, cos) = libm::sincos(degrees.to_radians());
    each(signal, |s| Complex64::new(s.re, s.im * cos + s.re * sin));
}

/// The converter's offset drifts steadily during the scan, by `share` of full scale from the first row to the last, in
/// a random direction of the I/Q plane.
pub fn offset_drift(signal: &mut Signal, share: f64) {
    let (rows, turn) = (signal.rows() as f64, signal.random.between(0.0, 6.0));
    for (k, chirp) in signal.chirps.iter_mut().enumerate() {
        let off = cis(turn) * (share * 32768.0 * k as f64 / rows);
        chirp.iter_mut().for_each(|s| *s += off);
    }
}

/// The gain falls by `db` dB from a random row on: echoes, noise and offset become weaker alike.
pub fn gain_falls(signal: &mut Signal, db: f64) {
    let from = signal.any_row(40);
    let gain = amplitude(-db);
    for row in from..signal.rows() {
        let kept: Vec<Complex64> = signal.chirps[row].iter().map(|s| s * gain).collect();
        signal.chirps[row] = kept;
    }
}

/// Both channels clip at `share` of the largest magnitude of I or Q in the scan.
pub fn clipped(signal: &mut Signal, share: f64) {
    let parts = signal.chirps.iter().flatten();
    let most = parts
        .map(|s| s.re.abs().max(s.im.abs()))
        .fold(0.0, f64::max);
    let limit = most * share;
    each(signal, |s| {
        Complex64::new(s.re.clamp(-limit, limit), s.im.clamp(-limit, limit))
    });
}

/// Another radar's chirp crosses the band in a fraction `share` of the rows, at random: a burst of 10 to 59 samples
/// with a linear frequency sweep, 15 to 40 dB above the noise in each channel.
pub fn bursts(signal: &mut Signal, share: f64) {
    let samples = signal.recording.meta.samples_per_chirp;
    for row in 0..signal.rows() {
        if !signal.random.chance(share) {
            continue;
        }
        let level = signal.noise_rms() * amplitude(signal.random.between(15.0, 40.0));
        let length = 10 + signal.random.index(50);
        let first = signal.random.index(samples.saturating_sub(length).max(1));
        let slope = signal.random.between(0.005, 0.05);
        let turn = signal.random.between(0.0, core::f64::consts::TAU);
        for (n, sample) in signal.chirps[row]
            .iter_mut()
            .skip(first)
            .take(length)
            .enumerate()
        {
            let n = n as f64 - 0.5 * length as f64;
            *sample += cis(turn + core::f64::consts::PI * slope * n * n) * level;
        }
    }
}

/// An interfering tone is in every row, `db` dB above the noise in each channel. Its beat frequency is that of a random
/// range, its phase is random in each row.
pub fn tone(signal: &mut Signal, db: f64) {
    let level = signal.noise_rms() * amplitude(db);
    let range = signal.random.between(0.3, 2.2);
    let tone = signal.turn(range + signal.mirror().offset_m);
    for row in 0..signal.rows() {
        let turn = cis(signal.random.between(0.0, core::f64::consts::TAU)) * level;
        for (sample, tone) in signal.chirps[row].iter_mut().zip(&tone) {
            *sample += tone * turn;
        }
    }
}
