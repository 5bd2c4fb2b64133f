//! Everything that may stand there instead of what is told.

use super::model::Model;
use super::staircase::{Kind, MAX_STEPS, Staircase};
use crate::math;

pub const CELLS: usize = 29;
pub const FIRST_END_M: f32 = -0.3;
pub const CELL_M: f32 = 0.1;
const RIGHT_M: f32 = 0.03;

/// Mass by where it contradicts the answer.
#[derive(Clone, Copy, Debug)]
pub struct Mass {
    pub cells: [f32; CELLS],
    pub fine: f32,
    top: f32,
}

impl Default for Mass {
    fn default() -> Self {
        Self {
            cells: [0.0; CELLS],
            fine: 0.0,
            top: f32::NEG_INFINITY,
        }
    }
}

impl Mass {
    pub fn add(&mut self, log_weight: f32, bad_m: f32) {
        if log_weight > self.top {
            let shrink = math::exp(math::max(self.top - log_weight, -80.0));
            self.cells.iter_mut().for_each(|c| *c *= shrink);
            self.fine *= shrink;
            self.top = log_weight;
        }
        let weight = math::exp(math::max(log_weight - self.top, -80.0));
        let cell = math::ceil((bad_m - RIGHT_M - FIRST_END_M) / CELL_M);
        let cell = if cell.is_finite() { math::max(cell, 0.0) as usize } else { CELLS };
        match self.cells.get_mut(cell) {
            Some(place) => *place += weight,
            None => self.fine += weight,
        }
    }

    /// Log-odds of an error per cell, right up to there.
    pub fn hazards(&self) -> [f32; CELLS] {
        let mut left: f32 = self.fine + self.cells.iter().sum::<f32>();
        let mut out = [0.0; CELLS];
        for (out, cell) in out.iter_mut().zip(&self.cells) {
            left -= cell;
            let odds = math::max(*cell, 1e-30) / math::max(left, 1e-30);
            *out = (core::f32::consts::LN_2 * math::log2(odds)).clamp(-9.0, 4.0);
        }
        out
    }
}

/// A flight to begin with.
pub type Candidate = Staircase;

struct Assess<'a> {
    model: &'a Model<'a>,
    told: &'a [(f32, f32)],
    mass: Mass,
}

fn ln(x: f32) -> f32 {
    core::f32::consts::LN_2 * math::log2(math::max(x, 1e-30))
}

/// Cost of what lies outside a box, with Gaussian shoulders.
fn shoulder(v: f32, low: f32, high: f32, sigma: f32) -> f32 {
    let d = math::max(math::max(low - v, v - high), 0.0) / sigma;
    -0.5 * d * d
}

/// Logarithm of a heavy-tailed deviation.
fn deviation(z: f32, core: f32, tail: f32, share: f32) -> f32 {
    let g = |s: f32| math::exp(-0.5 * (z / s) * (z / s)) / s;
    ln((1.0 - share) * g(core) + share * g(tail)) - 0.919
}

/// Volume of the posterior in place and rise, per step: σ√2π of each.
const VOLUME: f32 = 0.006 * 0.012;

/// Log prior, with the volume that the echoes leave.
fn prior(s: &Staircase) -> f32 {
    let n = s.len();
    let mut p = ln(0.5)
        + match s.kind {
            Kind::Nothing => ln(0.625) + if s.wall_m.is_finite() { ln(0.4 / 2.5 * 0.006) } else { ln(0.6) },
            Kind::Ramp => ln(0.15),
            Kind::Stairs => ln(0.2),
            Kind::Box => ln(0.125),
            Kind::Threshold => ln(0.10),
        };
    if n == 0 {
        return p;
    }
    p += ln(if s.open { 0.2 } else { 0.8 }) - ln(2.5) + ln(0.006) + ln(0.012);
    let rise = s.level(n) / n as f32;
    p += match s.kind {
        Kind::Box => -ln(0.55),
        Kind::Threshold => -ln(0.05),
        _ => shoulder(rise, if n > 1 { 0.085 } else { 0.05 }, 0.22, 0.02) - ln(0.15),
    };
    if s.wall_m.is_finite() {
        p += ln(0.4 / 2.5 * 0.006);
    } else {
        p += ln(0.6);
    }
    if n > 1 {
        let going = (s.x(n - 1) - s.x(0)) / (n - 1) as f32;
        p += shoulder(going, 0.22, 0.40, 0.03) - ln(0.22) + ln(0.006);
        for k in 1..n {
            p += ln(0.87) + deviation(s.x(k) - s.x(k - 1) - going, 0.004, 0.02, 0.05) + ln(0.006);
        }
        for k in 0..n {
            p += deviation(s.level(k + 1) - s.level(k) - rise, 0.0035, 0.025, 0.05) + ln(0.008);
        }
    }
    if !s.open {
        p += overhang(s.overhang_m);
    }
    p
}

fn overhang(o: f32) -> f32 {
    let z = o / 0.002;
    ln(0.5 * math::exp(-0.5 * z * z) + 0.5 * 0.15)
}

/// Density of the going to one more riser.
fn going(g: f32, mean: Option<f32>) -> f32 {
    let wide = if (0.18..=0.60).contains(&g) { 2.5 } else { 0.0 };
    match mean {
        None => 0.93 * if (0.22..=0.40).contains(&g) { 5.5 } else { 0.0 } + 0.07 * wide,
        Some(mean) => {
            let z = (g - mean) / 0.012;
            0.93 * 33.2 * math::exp(-0.5 * z * z) + 0.07 * wide
        }
    }
}

impl Assess<'_> {
    fn put(&mut self, s: &Staircase, log_weight: f32) {
        let bad = s.contradicts(self.told, self.model.height_m, RIGHT_M);
        self.mass.add(log_weight, bad);
    }

    /// Likelihood ratio of a change that concerns risers `from..` only.
    fn ratio(&self, old: &Staircase, new: &Staircase, from: usize) -> f32 {
        let of = |s: &Staircase| -> f32 { (from..=s.len()).map(|k| self.model.step(s, k)).sum() };
        of(new) - of(old)
    }

    fn around(&mut self, base: &Staircase, weight: f32) {
        let n = base.len();
        if base.kind == Kind::Stairs {
            self.behind(base, weight);
            self.front(base, weight);
            self.odd(base, weight);
            self.overhangs(base, weight);
            self.between(base, weight);
            let mut less = *base;
            let mut w = weight;
            for _ in 0..n {
                let shorter = less.less_last();
                w += prior(&shorter) - prior(&less)
                    + self.ratio(&less, &shorter, shorter.len());
                self.put(&shorter, w);
                less = shorter;
            }
        }
        if base.kind == Kind::Nothing {
            self.floor(base, weight);
        }
    }

    /// One more riser behind the last.
    fn behind(&mut self, base: &Staircase, weight: f32) {
        let n = base.len();
        let (x, h) = (base.x(n - 1), base.level(n));
        let mean = (n > 1).then(|| (x - base.x(0)) / (n - 1) as f32);
        let rise = h / n as f32;
        let old = self.model.step(base, n);
        let spots: heapless::Vec<(f32, f32), 96> = (0..21)
            .map(|i| (0.20 + 0.02 * i as f32, 0.02))
            .chain(
                self.model
                    .echoes
                    .iter()
                    .filter(|e| e.snr_db > 5.0)
                    .map(|e| (e.x_m - x, 0.006)),
            )
            .filter(|(g, _)| (0.15..1.6).contains(g))
            .take(96)
            .collect();
        for (g, step) in spots {
            if x + g > base.wall_m - 0.1 {
                continue;
            }
            for (dr, share) in [(0.0, 0.6), (-0.03, 0.2), (0.03, 0.2)] {
                let q = 0.87 * (going(g, mean) + if g > 0.4 { 0.03 } else { 0.0 }) * step * share;
                if q < 1e-5 {
                    continue;
                }
                let new = base.with(n, x + g, h + rise + dr);
                let l = self.model.step(&new, n) + self.model.step(&new, n + 1) - old;
                self.put(&new, weight + ln(q) + l);
            }
        }
    }

    /// One more riser before the first.
    fn front(&mut self, base: &Staircase, weight: f32) {
        let first = base.x(0);
        let old = self.model.step(base, 0);
        let spots: heapless::Vec<(f32, f32), 96> = (0..40)
            .map(|i| (0.3 + 0.06 * i as f32, 0.06))
            .chain(
                self.model
                    .echoes
                    .iter()
                    .filter(|e| e.snr_db > 5.0)
                    .map(|e| (e.x_m, 0.012)),
            )
            .filter(|(x, _)| *x > 0.25 && *x < first - 0.15)
            .take(96)
            .collect();
        for (x, dx) in spots {
            for h in [0.05, 0.09, 0.13, 0.17] {
                if h < base.level(1) - 0.03 {
                    let new = base.with(0, x, h);
                    let l = self.model.step(&new, 0) + self.model.step(&new, 1) - old;
                    self.put(&new, weight + ln(0.03 * dx / 1.5 / 4.0) + l);
                }
            }
        }
        let n = base.len();
        if n > 1 {
            let g = (base.x(n - 1) - first) / (n - 1) as f32;
            if first - g > 0.2 && n < MAX_STEPS {
                for f in [0.92, 0.96, 1.0, 1.04, 1.08] {
                    let mut new = base.with(0, first - g, 0.0);
                    let rise = f * base.level(n) / (n + 1) as f32;
                    for (k, top) in new.top_m.iter_mut().enumerate() {
                        *top = rise * (k + 1) as f32;
                    }
                    if rise > 0.06 {
                        let l = self.ratio(base, &new, 0);
                        self.put(&new, weight + ln(0.87 / 5.0) + l);
                    }
                }
            }
        }
    }

    /// A riser between two.
    fn between(&mut self, base: &Staircase, weight: f32) {
        for k in 1..base.len() {
            let (a, b) = (base.x(k - 1), base.x(k));
            if b - a < 0.34 {
                continue;
            }
            let old = self.model.step(base, k);
            for f in [0.4, 0.45, 0.5, 0.55, 0.6] {
                let new = base.with(k, a + f * (b - a), 0.5 * (base.level(k) + base.level(k + 1)));
                let l = self.model.step(&new, k) + self.model.step(&new, k + 1) - old;
                self.put(&new, weight + ln(0.02) + l);
            }
        }
    }

    /// Odd rises, and all of them higher or lower.
    fn odd(&mut self, base: &Staircase, weight: f32) {
        let n = base.len();
        for k in 0..n {
            for size in [0.025, 0.035, 0.045, 0.06] {
                for dh in [-size, size] {
                    for end in [n, k + 1] {
                        if end == k + 1 && end == n && n > 1 && k + 1 == n {
                            // Both are the same for the last.
                        }
                        let mut new = *base;
                        for top in new.top_m.iter_mut().take(end).skip(k) {
                            *top += dh;
                        }
                        let fine = (0..n).all(|i| new.level(i + 1) - new.level(i) > 0.03);
                        if fine {
                            let l = self.ratio(base, &new, k);
                            self.put(&new, weight + ln(0.1 / n as f32 / 16.0) + l);
                        }
                    }
                }
            }
        }
        for f in [-0.16, -0.12, -0.08, -0.04, 0.04, 0.08, 0.12, 0.16] {
            let mut new = *base;
            new.top_m.iter_mut().for_each(|top| *top *= 1.0 + f);
            let l = self.ratio(base, &new, 0);
            self.put(&new, weight + ln(0.5) + prior(&new) - prior(base) + l);
        }
    }

    /// Other overhangs.
    fn overhangs(&mut self, base: &Staircase, weight: f32) {
        if base.open {
            return;
        }
        for o in [0.0, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06] {
            let mut new = *base;
            new.overhang_m = o;
            let l = self.ratio(base, &new, 0);
            self.put(&new, weight + overhang(o) - overhang(base.overhang_m) + l);
        }
    }

    /// Steps, boxes, thresholds where nothing is told.
    fn floor(&mut self, base: &Staircase, weight: f32) {
        let old = self.model.step(base, 0);
        let spots: heapless::Vec<(f32, f32), 128> = (0..60)
            .map(|i| (0.24 + 0.04 * i as f32, 0.04))
            .chain(
                self.model
                    .echoes
                    .iter()
                    .filter(|e| e.snr_db > 5.0)
                    .map(|e| (e.x_m, 0.006)),
            )
            .filter(|(x, _)| *x > 0.2 && *x < math::min(2.66, base.wall_m - 0.15))
            .take(128)
            .collect();
        for (x, dx) in spots {
            for open in [false, true] {
                for (h, share, kind) in [
                    (0.015, 0.3, Kind::Threshold),
                    (0.03, 0.2, Kind::Threshold),
                    (0.045, 0.04, Kind::Stairs),
                    (0.07, 0.06, Kind::Stairs),
                    (0.10, 0.08, Kind::Stairs),
                    (0.14, 0.08, Kind::Stairs),
                    (0.17, 0.08, Kind::Stairs),
                    (0.20, 0.05, Kind::Stairs),
                    (0.25, 0.03, Kind::Stairs),
                    (0.30, 0.1, Kind::Box),
                    (0.40, 0.1, Kind::Box),
                    (0.60, 0.1, Kind::Box),
                ] {
                    let mut new = base.with(0, x, h);
                    new.kind = kind;
                    new.open = open;
                    let q = share * if open { 0.2 } else { 0.8 } * dx / 2.5;
                    let l = self.model.step(&new, 0) + self.model.step(&new, 1) - old;
                    self.put(&new, weight + ln(q) + l);
                }
                for rise in [0.10, 0.14, 0.17, 0.20] {
                    let mut new = *base;
                    new.open = open;
                    for k in 0..3 {
                        new = new.with(k, x + 0.28 * k as f32, rise * (k + 1) as f32);
                    }
                    let q = 0.3 * if open { 0.2 } else { 0.8 } * dx / 2.5;
                    let l = self.ratio(base, &new, 0);
                    self.put(&new, weight + ln(q) + l);
                }
            }
        }
    }
}

/// Weighs all that may stand there, and says where it contradicts what is told.
pub fn assess(model: &Model<'_>, bases: &[Staircase], told: &[(f32, f32)]) -> Mass {
    let mut a = Assess {
        model,
        told,
        mass: Mass::default(),
    };
    let mut weights: heapless::Vec<f32, 32> = heapless::Vec::new();
    let mut top = f32::NEG_INFINITY;
    for s in bases.iter().take(32) {
        let w = model.whole(s) + prior(s);
        let _ = weights.push(w);
        top = math::max(top, w);
    }
    for (s, &w) in bases.iter().zip(&weights) {
        a.put(s, w);
        if w > top - 7.0 {
            a.around(s, w);
        }
    }
    a.mass
}

/// Log posterior weight of a staircase.
pub fn weight(model: &Model<'_>, s: &Staircase) -> f32 {
    model.whole(s) + prior(s)
}
