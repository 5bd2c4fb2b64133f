//! What else may stand there: one riser more or less, another overhang, an odd rise.
//!
//! Each proposal differs from a hypothesis in a few risers, so that only their part of the
//! likelihood is looked at anew.

use super::cloud::{Cloud, Told};
use super::model::Model;
use super::prior::{GOES_ON, going, ln, overhang, prior};
use super::staircase::{Kind, MAX_STEPS, Sigmas, Staircase};
use crate::math;
use heapless::Vec;

/// Places for one more riser that are tried at most.
const SPOTS: usize = 40;
/// Echoes below show no place for a riser, dB.
const SPOT_DB: f32 = 5.0;
/// Two places nearer to each other are one, metres.
const APART_M: f32 = 0.015;

/// Logarithm of prior times likelihood.
pub fn weight(model: &Model<'_>, s: &Staircase) -> f32 {
    prior(s) + model.whole(s)
}

/// A hypothesis, its likelihood riser by riser, and its weight.
#[derive(Clone, Copy, Debug)]
pub struct Base {
    /// The hypothesis.
    pub staircase: Staircase,
    /// Standard deviations of its levels, metres.
    pub sigmas: Sigmas,
    /// Log-likelihood of each riser with the tread before it, and of the landing.
    steps: [f32; MAX_STEPS + 1],
    /// Logarithm of prior times likelihood.
    pub log_weight: f32,
}

/// Standard deviation of a level that a proposal puts where it is, metres.
const PLACED_M: f32 = 0.01;

impl Base {
    /// Weighs a hypothesis whose levels are known to `sigmas`.
    pub fn new(model: &Model<'_>, staircase: Staircase, sigmas: Sigmas) -> Self {
        let mut steps = [0.0; MAX_STEPS + 1];
        let mut total = prior(&staircase);
        for (k, value) in steps.iter_mut().take(staircase.len() + 1).enumerate() {
            *value = model.step(&staircase, k);
            total += *value;
        }
        Self {
            staircase,
            sigmas,
            steps,
            log_weight: total,
        }
    }

    /// What risers from number `from` to before `to` say.
    fn part(&self, from: usize, to: usize) -> f32 {
        self.steps.get(from..to).map_or(0.0, |s| s.iter().sum())
    }
}

/// Puts proposals into a cloud.
pub struct Proposals<'a> {
    /// What weighs them.
    pub model: &'a Model<'a>,
    /// The answer that they are held against.
    pub told: &'a Told<'a>,
    /// Where they go.
    pub cloud: &'a mut Cloud,
}

/// Places for one more riser, and how much of the way each stands for, metres.
type Spots = Vec<(f32, f32), SPOTS>;

impl Proposals<'_> {
    /// Everything near a hypothesis.
    pub fn around(&mut self, base: &Base) {
        match base.staircase.kind {
            Kind::Stairs => {
                self.less(base);
                self.behind(base);
                self.front(base);
                self.between(base);
                self.odd(base);
                self.overhangs(base);
            }
            Kind::Nothing => self.floor(base),
            _ => {}
        }
    }

    fn put(&mut self, s: &Staircase, log_weight: f32, sigmas: &Sigmas) {
        self.cloud.add(s, log_weight, sigmas, self.told);
    }

    /// Log-likelihood of a staircase's risers from `from` to before `to`.
    fn part(&self, s: &Staircase, from: usize, to: usize) -> f32 {
        (from..to).map(|k| self.model.step(s, k)).sum()
    }

    /// Places on a grid of `step_m` from `from_m` to `to_m`, and of echoes there.
    fn spots(&self, from_m: f32, to_m: f32, step_m: f32, echo_m: f32) -> Spots {
        let mut spots = Spots::new();
        let mut x = from_m;
        while x < to_m && spots.len() < SPOTS / 2 {
            // There is room for as many.
            let _ = spots.push((x, step_m));
            x += step_m;
        }
        let mut last = f32::NEG_INFINITY;
        for e in &self.model.echoes {
            let within = e.x_m > from_m && e.x_m < to_m && e.snr_db > SPOT_DB;
            if within && e.x_m > last + APART_M {
                last = e.x_m;
                // Those that find no room stand among many.
                let _ = spots.push((e.x_m, echo_m));
            }
        }
        spots
    }

    /// The flight less its last steps.
    fn less(&mut self, base: &Base) {
        let mut longer = base.staircase;
        let mut weight = base.log_weight;
        let mut part = base.part(base.staircase.len(), base.staircase.len() + 1);
        for n in (0..base.staircase.len()).rev() {
            let shorter = longer.less_last();
            let landing = self.model.step(&shorter, n);
            part += base.part(n, n + 1);
            weight += prior(&shorter) - prior(&longer) + landing - part;
            self.put(&shorter, weight, &base.sigmas);
            part = landing;
            longer = shorter;
        }
    }

    /// One more riser behind the last, at an echo or where nothing shows it.
    fn behind(&mut self, base: &Base) {
        let s = &base.staircase;
        let (n, x, h) = (s.len(), s.last_x(), s.level(s.len()));
        let (mean, rise) = (s.going(), s.rise());
        let old = base.part(n, n + 1);
        let end = math::min(x + 1.6, s.wall_m - 0.1);
        let near = self.spots(x + 0.20, math::min(x + 0.60, end), 0.04, 0.006);
        let far = self.spots(x + 0.60, end, f32::INFINITY, 0.006);
        for (at, step) in near.into_iter().chain(far.into_iter().skip(1)) {
            let landing = if at > x + 0.4 { 0.03 } else { 0.0 };
            let density = GOES_ON * (going(at - x, mean) + landing) * step;
            for (off, share) in [(0.0, 0.6), (-0.03, 0.2), (0.03, 0.2)] {
                if density * share > 1e-5 {
                    let new = s.with(n, at, h + rise + off);
                    let part = self.part(&new, n, n + 2);
                    let weight = base.log_weight + ln(density * share) + part - old;
                    self.put(&new, weight, &base.sigmas);
                }
            }
        }
    }

    /// One more riser before the first.
    fn front(&mut self, base: &Base) {
        let s = &base.staircase;
        let (n, first) = (s.len(), s.x(0));
        let old = base.part(0, 1);
        for (x, dx) in self.spots(0.3, first - 0.15, 0.12, 0.012) {
            for h in [0.05, 0.10, 0.15] {
                if h < s.level(1) - 0.03 {
                    let new = s.with(0, x, h);
                    let weight = ln(0.01 * dx / 1.5) + self.part(&new, 0, 2) - old;
                    self.put(&new, base.log_weight + weight, &base.sigmas);
                }
            }
        }
        // As regular as the others, each riser lower.
        let Some(going) = s.going().filter(|g| first - g > 0.1 && n < MAX_STEPS) else {
            return;
        };
        let old = base.part(0, n + 1);
        for stretch in [0.94, 1.0, 1.06] {
            let mut new = s.with(0, first - going, 0.0);
            let rise = stretch * s.level(n) / (n + 1) as f32;
            for (k, top) in (1u8..).zip(&mut new.top_m) {
                *top = rise * f32::from(k);
            }
            if rise > 0.06 {
                let weight = ln(GOES_ON / 3.0) + self.part(&new, 0, n + 2) - old;
                self.put(&new, base.log_weight + weight, &base.sigmas);
            }
        }
    }

    /// One more riser between two.
    fn between(&mut self, base: &Base) {
        let s = &base.staircase;
        for k in 1..s.len() {
            let (from, to) = (s.x(k - 1), s.x(k));
            if to - from < 0.34 {
                continue;
            }
            let old = base.part(k, k + 1);
            for share in [0.42, 0.5, 0.58] {
                let level = 0.5 * (s.level(k) + s.level(k + 1));
                let new = s.with(k, from + share * (to - from), level);
                let weight = ln(0.03) + self.part(&new, k, k + 2) - old;
                self.put(&new, base.log_weight + weight, &base.sigmas);
            }
        }
    }

    /// One rise higher or lower than the others, the rest moved along or not.
    fn odd(&mut self, base: &Base) {
        let s = &base.staircase;
        let n = s.len();
        let odds = ln(0.1 / n as f32 / 8.0);
        for k in 0..n {
            for off in [-0.045, -0.03, 0.03, 0.045] {
                for end in [n, k + 1] {
                    if end == k + 1 && end == n && k > 0 {
                        continue;
                    }
                    let mut new = *s;
                    let tops = new.top_m.get_mut(k..end).unwrap_or(&mut []);
                    tops.iter_mut().for_each(|top| *top += off);
                    if (0..n).any(|i| new.level(i + 1) < new.level(i) + 0.03) {
                        continue;
                    }
                    let to = math::min((end + 1) as f32, (n + 1) as f32) as usize;
                    let weight = odds + self.part(&new, k, to) - base.part(k, to);
                    self.put(&new, base.log_weight + weight, &base.sigmas);
                }
            }
        }
    }

    /// Other overhangs of all treads.
    fn overhangs(&mut self, base: &Base) {
        let s = &base.staircase;
        if s.open {
            return;
        }
        let n = s.len();
        for overhang_m in [0.0, 0.015, 0.03, 0.045, 0.06] {
            let new = Staircase { overhang_m, ..*s };
            let weight = overhang(overhang_m) - overhang(s.overhang_m) + self.part(&new, 0, n + 1)
                - base.part(0, n + 1);
            self.put(&new, base.log_weight + weight, &base.sigmas);
        }
    }

    /// One step, box or threshold, or a flight of three, where nothing is told.
    fn floor(&mut self, base: &Base) {
        let s = &base.staircase;
        let old = base.part(0, 1);
        let end = math::min(2.6, s.wall_m - 0.15);
        let sigmas = [PLACED_M; MAX_STEPS];
        for (x, dx) in self.spots(0.24, end, 0.12, 0.006) {
            let brink = Staircase {
                kind: Kind::Drop,
                wall_m: x,
                ..*s
            };
            let weight = ln(DROP * dx / 2.5) + self.part(&brink, 0, 1) - old;
            self.put(&brink, base.log_weight + weight, &sigmas);
            for (h, share, kind) in FLOOR {
                let mut new = s.with(0, x, h);
                new.kind = kind;
                let weight = ln(0.8 * share * dx / 2.5) + self.part(&new, 0, 2) - old;
                self.put(&new, base.log_weight + weight, &sigmas);
            }
            for (rise, open) in [(0.11, false), (0.17, false), (0.17, true)] {
                let mut new = *s;
                for k in 0..3u8 {
                    let k = f32::from(k);
                    new = new.with(usize::from(k as u8), x + 0.28 * k, rise * (k + 1.0));
                }
                new.open = open;
                let weight = ln(0.5 * if open { 0.2 } else { 0.4 } * dx / 2.5);
                let part = self.part(&new, 0, 4) - old;
                self.put(&new, base.log_weight + weight + part, &sigmas);
            }
        }
    }
}

/// The ground ends somewhere ahead so often.
const DROP: f32 = 0.1;
/// What may stand alone on the floor: height, metres, how often, and what that is called.
const FLOOR: [(f32, f32, Kind); 8] = [
    (0.02, 0.5, Kind::Threshold),
    (0.045, 0.05, Kind::Stairs),
    (0.075, 0.08, Kind::Stairs),
    (0.11, 0.10, Kind::Stairs),
    (0.16, 0.14, Kind::Stairs),
    (0.22, 0.06, Kind::Stairs),
    (0.32, 0.15, Kind::Box),
    (0.50, 0.15, Kind::Box),
];
