//! Alterations of a scan's chirps as instruments, dirt and people make them, by plain arithmetic on the samples.

use stairscan::Iq;

/// The chirps of a scan; an empty one is lost.
pub type Chirps = Vec<Vec<Iq>>;

/// An alteration with its name.
pub type Alteration = (&'static str, fn(&mut Chirps));

/// All alterations.
pub const ALTERATIONS: [Alteration; 25] = [
    ("bit 3 stuck high", |c| {
        each(c, |s| Iq::new(s.i | 8, s.q | 8))
    }),
    ("bit 6 of I stuck low", |c| {
        each(c, |s| Iq::new(s.i & !64, s.q))
    }),
    ("I and Q swapped", |c| each(c, |s| Iq::new(s.q, s.i))),
    ("Q missing", |c| each(c, |s| Iq::new(s.i, 0))),
    ("Q equals I", |c| each(c, |s| Iq::new(s.i, s.i))),
    ("Q 4 dB weaker", |c| {
        each(c, |s| Iq::new(s.i, scaled(s.q, 0.63)))
    }),
    ("20 dB weaker", |c| {
        each(c, |s| Iq::new(scaled(s.i, 0.1), scaled(s.q, 0.1)))
    }),
    ("clipped at half the swing", |c| {
        let top = c
            .iter()
            .flatten()
            .map(|s| s.i.saturating_abs())
            .max()
            .unwrap_or(0)
            / 2;
        each(c, |s| Iq::new(s.i.clamp(-top, top), s.q.clamp(-top, top)));
    }),
    ("at full scale", |c| {
        each(c, |s| {
            Iq::new(s.i.saturating_mul(64), s.q.saturating_mul(64))
        })
    }),
    ("offset grows", |c| {
        rows(c, |k, s| Iq::new(s.i.saturating_add(8 * k as i16), s.q))
    }),
    ("gain falls from row to row", |c| {
        rows(c, |k, s| {
            let gain = 1.0 / (1.0 + k as f32 / 60.0);
            Iq::new(scaled(s.i, gain), scaled(s.q, gain))
        });
    }),
    ("every third row lost", |c| {
        c.iter_mut().step_by(3).for_each(Vec::clear)
    }),
    ("the last third lost", |c| {
        let from = c.len() * 2 / 3;
        c[from..].iter_mut().for_each(Vec::clear);
    }),
    ("mirror stuck in the last half", |c| {
        let at = c.len() / 2;
        let stuck = c[at].clone();
        // The noise of another row keeps the chirps different.
        c[at..].iter_mut().for_each(|chirp| mix(chirp, &stuck, 0.9));
    }),
    ("mirror slips by five rows", |c| {
        let at = c.len() / 3;
        c[at..].rotate_left(5);
    }),
    ("two blocks of rows swapped", |c| {
        let third = c.len() / 3;
        let (front, back) = c.split_at_mut(2 * third);
        front[third / 2..][..third / 2].swap_with_slice(&mut back[..third / 2]);
    }),
    ("every other row stale", |c| {
        for k in (1..c.len()).step_by(2) {
            c[k] = c[k - 1].clone();
        }
    }),
    ("all rows the same", |c| {
        let first = c[0].clone();
        c.fill(first);
    }),
    ("silent", |c| each(c, |_| Iq::new(3, -3))),
    ("a burst in every tenth row", |c| {
        for chirp in c.iter_mut().step_by(10) {
            tone(chirp, 0.37, 900.0);
        }
    }),
    ("a burst of twelve rows", |c| {
        c.iter_mut()
            .skip(9)
            .take(12)
            .for_each(|chirp| noise(chirp, 700.0))
    }),
    ("a steady tone", |c| {
        c.iter_mut().for_each(|chirp| tone(chirp, 0.13, 60.0))
    }),
    ("a near target in all rows", |c| {
        c.iter_mut().for_each(|chirp| tone(chirp, 0.11, 4000.0))
    }),
    ("more noise", |c| {
        c.iter_mut().for_each(|chirp| noise(chirp, 60.0))
    }),
    ("phase turns from row to row", |c| {
        rows(c, |k, s| {
            let (sin, cos) = libm::sincosf(0.3 * k as f32);
            let (i, q) = (f32::from(s.i), f32::from(s.q));
            Iq::new((i * cos - q * sin) as i16, (i * sin + q * cos) as i16)
        });
    }),
];

fn scaled(part: i16, gain: f32) -> i16 {
    (f32::from(part) * gain) as i16
}

/// Changes every sample.
fn each(chirps: &mut Chirps, change: impl Fn(Iq) -> Iq) {
    rows(chirps, |_, sample| change(sample));
}

/// Changes every sample, with its row.
fn rows(chirps: &mut Chirps, change: impl Fn(usize, Iq) -> Iq) {
    for (k, chirp) in chirps.iter_mut().enumerate() {
        chirp
            .iter_mut()
            .for_each(|sample| *sample = change(k, *sample));
    }
}

/// Replaces a share of a chirp by that of another.
fn mix(chirp: &mut [Iq], other: &[Iq], share: f32) {
    for (sample, other) in chirp.iter_mut().zip(other) {
        let part = |a: i16, b: i16| (f32::from(a) * (1.0 - share) + f32::from(b) * share) as i16;
        *sample = Iq::new(part(sample.i, other.i), part(sample.q, other.q));
    }
}

/// Adds a tone of so many cycles a sample.
fn tone(chirp: &mut [Iq], cycles: f32, amplitude: f32) {
    for (n, sample) in chirp.iter_mut().enumerate() {
        let (sin, cos) = libm::sincosf(std::f32::consts::TAU * cycles * n as f32);
        let add = |part: i16, by: f32| part.saturating_add((amplitude * by) as i16);
        *sample = Iq::new(add(sample.i, cos), add(sample.q, sin));
    }
}

/// Adds uniform noise up to `amplitude`, by a linear congruential generator (Knuth's MMIX) that begins anew with
/// the chirp's first sample.
fn noise(chirp: &mut [Iq], amplitude: f32) {
    let mut state = chirp
        .first()
        .map_or(1, |s| u64::from(s.i as u16) << 16 | u64::from(s.q as u16));
    let mut draw = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (amplitude * ((state >> 40) as f32 / (1 << 23) as f32 - 1.0)) as i16
    };
    for sample in chirp {
        *sample = Iq::new(
            sample.i.saturating_add(draw()),
            sample.q.saturating_add(draw()),
        );
    }
}
