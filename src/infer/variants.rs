//! Variants of a hypothesis: one more riser behind the last, the last ones left out, an odd rise. On bare ground: a step,
//! a box, a threshold, a drop.
//!
//! Each differs from a hypothesis in a few risers, so that only their part of the
//! likelihood is looked at anew.

use super::cloud::{Cloud, Told};
use crate::math;
use crate::model::prior::{GOES_ON, LANDING, going, ln, prior};
use crate::model::surfaces::{SLOT_M, SLOTS};
use crate::model::{BEHIND_M, EchoSums, GroundKind, MAX_STEPS, Model, Sigmas, Staircase};
use crate::params::current;
use crate::params::posterior as number;
use heapless::Vec;

/// Places for one more riser that are tried at most.
const SPOTS: usize = 40;
/// Echoes below show no place for a riser, dB.
const SPOT_DB: f32 = 8.0;
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

/// Standard deviation of a level that a variant puts where it is, metres.
const PLACED_M: f32 = 0.01;
/// Standard deviation of the level of a tread that is seen from above, metres.
const TREAD_M: f32 = 0.003;

impl Base {
    /// Weighs a hypothesis whose levels are known to `sigmas`.
    #[inline(never)]
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

    /// A hypothesis that has been weighed, whose levels are known as those of treads are.
    pub fn weighed(staircase: Staircase, log_weight: f32) -> Self {
        Self {
            staircase,
            sigmas: [TREAD_M; MAX_STEPS],
            steps: [0.0; MAX_STEPS + 1],
            log_weight,
        }
    }

    /// The one of greater weight; the first of two alike.
    pub fn likelier(self, other: Self) -> Self {
        if other.log_weight > self.log_weight {
            other
        } else {
            self
        }
    }

    /// The same with a wall at `wall_m` behind: only the landing changes.
    #[inline(never)]
    pub fn walled(&self, model: &Model<'_>, wall_m: f32) -> Self {
        let mut out = *self;
        out.staircase.wall_m = wall_m;
        let n = self.staircase.len();
        let landing = model.step(&out.staircase, n);
        out.log_weight +=
            prior(&out.staircase) - prior(&self.staircase) + landing - self.part(n, n + 1);
        if let Some(value) = out.steps.get_mut(n) {
            *value = landing;
        }
        out
    }

    /// What risers from number `from` to before `to` say.
    #[inline(never)]
    fn part(&self, from: usize, to: usize) -> f32 {
        self.steps.get(from..to).map_or(0.0, |s| s.iter().sum())
    }
}

/// Puts variants into a cloud.
pub struct Variants<'a> {
    /// What weighs them.
    pub model: &'a Model<'a>,
    /// The answer that they are held against.
    pub told: &'a Told<'a>,
    /// Where they go.
    pub cloud: &'a mut Cloud,
}

/// Places for one more riser, and how much of the way each stands for, metres.
type Spots = Vec<(f32, f32), SPOTS>;

impl Variants<'_> {
    /// Everything near a hypothesis.
    pub fn around(&mut self, base: &Base) {
        match base.staircase.kind {
            GroundKind::Stairs => {
                let rules = &current().rules;
                type Vary<'a> = fn(&mut Variants<'a>, &Base);
                let kinds: [(bool, Vary<'_>); 3] = [
                    (rules.less, Self::less),
                    (rules.behind, Self::behind),
                    (rules.odd, Self::odd),
                ];
                for (_, vary) in kinds.into_iter().filter(|(on, _)| *on) {
                    vary(self, base);
                }
            }
            GroundKind::Nothing => self.floor(base),
            _ => {}
        }
    }

    #[inline(never)]
    fn put(&mut self, s: &Staircase, log_weight: f32, sigmas: &Sigmas) {
        self.cloud.add(s, log_weight, sigmas, self.told);
    }

    /// Log-likelihood of a staircase's risers from `from` to before `to`.
    fn part(&self, s: &Staircase, from: usize, to: usize) -> f32 {
        (from..to).map(|k| self.model.step(s, k)).sum()
    }

    /// Places on a grid of `step_m` from `from_m` to `to_m`, and of echoes there.
    #[inline(never)]
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
    #[inline(never)]
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
    #[inline(never)]
    fn behind(&mut self, base: &Base) {
        let s = &base.staircase;
        let (x, mean) = (s.last_x(), s.going());
        let end = math::min(x + number::BEHIND_TO_M, s.wall_m - number::BEHIND_WALL_M);
        let (nearest, farthest) = number::BEHIND_GOINGS_M;
        let mut near = self.spots(
            x + nearest,
            math::min(x + farthest, end),
            number::BEHIND_GRID_M,
            number::SPOT_M,
        );
        if let Some(mean) = mean.filter(|mean| x + mean < end) {
            // As far as the others: between the places of the grid it would be missed.
            near.retain(|(at, step)| *step < ECHO_M || (at - x - mean).abs() > REGULAR_M);
            let _ = near.push((x + mean, REGULAR_M));
        }
        let far = self.spots(x + farthest, end, f32::INFINITY, number::SPOT_M);
        let top = s.level(s.len()) + s.rise();
        let before = self.before(base, top - number::RISE_OFF_M);
        for (off, share) in number::BEHIND_RISES {
            let more = self.more(base, top + off, GroundKind::Stairs, before.as_ref());
            for &(at, step) in near.iter().chain(far.iter().skip(1)) {
                let landing = if at > x + number::LANDING_FROM_M {
                    LANDING
                } else {
                    0.0
                };
                let odds = GOES_ON * (going(at - x, mean) + landing) * step * share;
                if odds > number::LEAST_ODDS {
                    let (new, weight) = self.added(base, &more, at);
                    self.put(&new, weight + ln(odds), &base.sigmas);
                }
            }
        }
    }

    /// The echoes on the last tread, which are the same whatever stands behind; nothing where one more riser,
    /// `top_m` high at least, hides what is behind it.
    fn before(&self, base: &Base, top_m: f32) -> Option<EchoSums> {
        let s = &base.staircase;
        (!self.hides(top_m)).then(|| self.model.sums(s, s.len()))
    }

    /// Whether what can be seen behind an edge depends on where that stands: it is above the mirror.
    fn hides(&self, top_m: f32) -> bool {
        top_m > self.model.view.height_m
    }

    /// One more riser behind the last whose top is at `top_m`, wherever it stands, where `before` holds the
    /// echoes on the tread before it.
    fn more<'b>(
        &self,
        base: &Base,
        top_m: f32,
        kind: GroundKind,
        before: Option<&'b EchoSums>,
    ) -> More<'b> {
        let s = &base.staircase;
        let n = s.len();
        let mut far = s.with(n, s.last_x(), top_m);
        far.kind = kind;
        let before = before.filter(|_| !self.hides(top_m));
        More {
            top_m,
            kind,
            sums: before.map(|before| Split {
                before,
                behind: self.model.sums(&far, n + 1),
                wall: self.model.riser(&far, n + 1),
            }),
        }
    }

    /// That riser at `x_m`, and the logarithm of its weight but for its odds.
    #[inline(never)]
    fn added(&self, base: &Base, more: &More<'_>, x_m: f32) -> (Staircase, f32) {
        let (model, s) = (self.model, &base.staircase);
        let n = s.len();
        let mut new = s.with(n, x_m, more.top_m);
        new.kind = more.kind;
        let old = base.part(n, n + 1);
        let part = match &more.sums {
            None => self.part(&new, n, n + 2),
            Some(Split {
                before,
                behind,
                wall,
            }) => {
                let (from, to) = (x_m - NEAR_M, x_m + NEAR_M);
                let at =
                    |sums: &EchoSums, x| sums.get(model.first_beyond(x)).copied().unwrap_or(0.0);
                let start = if n > 0 {
                    s.last_x() + BEHIND_M
                } else {
                    f32::NEG_INFINITY
                };
                let from = math::max(from, start);
                at(before, start) - at(before, from)
                    + model.within(&new, n, from, to)
                    + model.within(&new, n + 1, from, to)
                    + at(behind, to)
                    - model.expected(&new, n)
                    - model.expected(&new, n + 1)
                    + model.riser(&new, n)
                    + wall
            }
        };
        let line = if n == 0 && more.sums.is_some() {
            model.surfaces.of(&new)
        } else {
            0.0
        };
        (new, base.log_weight + part + line - old)
    }

    /// One rise higher or lower than the others, the rest moved along or not.
    #[inline(never)]
    fn odd(&mut self, base: &Base) {
        let s = &base.staircase;
        let n = s.len();
        let odds = ln(number::ODD_ODDS / n as f32 / (2 * ODD_M.len()) as f32);
        // Farther ones lie beyond the horizon as a rule.
        for k in 0..n.min(ODD_RISERS) {
            for off in ODD_M {
                for end in [n, k + 1] {
                    if end == k + 1 && end == n && k > 0 {
                        continue;
                    }
                    let mut new = *s;
                    let tops = new.top_m.get_mut(k..end).unwrap_or(&mut []);
                    tops.iter_mut().for_each(|top| *top += off);
                    if (0..n).any(|i| new.level(i + 1) < new.level(i) + number::LEAST_RISE_M) {
                        continue;
                    }
                    let to = math::min((end + 1) as f32, (n + 1) as f32) as usize;
                    let weight = odds + self.part(&new, k, to) - base.part(k, to);
                    self.put(&new, base.log_weight + weight, &base.sigmas);
                }
            }
        }
    }

    /// The ground ends.
    #[inline(never)]
    fn drops(&mut self, base: &Base) {
        let (model, s) = (self.model, &base.staircase);
        let (before, behind) = (
            model.sums(&Staircase::drop(f32::INFINITY), 0),
            model.sums(&Staircase::drop(f32::NEG_INFINITY), 0),
        );
        let at = |sums: &EchoSums, k| sums.get(k).copied().unwrap_or(0.0);
        let (first, end) = (FIRST_DROP_M / SLOT_M, s.wall_m / SLOT_M);
        for k in first as usize..SLOTS.min(end as usize) {
            let x = (k as f32 + 0.5) * SLOT_M;
            let brink = Staircase::drop(x);
            let first = model.first_beyond(x);
            let part = at(&before, 0) - at(&before, first) + at(&behind, first)
                - model.expected(&brink, 0)
                + model.surfaces.of(&brink);
            let weight = ln(DROP_ODDS * SLOT_M / number::FLOOR_WAY_M) + part - base.part(0, 1);
            self.put(&brink, base.log_weight + weight, &[PLACED_M; MAX_STEPS]);
        }
    }

    /// One step, box or threshold, or a drop, on bare ground.
    #[inline(never)]
    fn floor(&mut self, base: &Base) {
        let s = &base.staircase;
        let (nearest, farthest) = number::FLOOR_FROM_TO_M;
        let end = math::min(farthest, s.wall_m - number::FLOOR_WALL_M);
        let sigmas = [PLACED_M; MAX_STEPS];
        let spots = self.spots(nearest, end, number::FLOOR_GRID_M, number::SPOT_M);
        let before = self.before(base, 0.0);
        let rules = &current().rules;
        for (h, [seen, unseen]) in FLOOR.into_iter().filter(|_| rules.single) {
            let more = self.more(base, h, GroundKind::single(h), before.as_ref());
            for &(x, dx) in &spots {
                let share = if dx < ECHO_M { seen } else { unseen };
                if share > 0.0 {
                    let (new, weight) = self.added(base, &more, x);
                    self.put(
                        &new,
                        weight + ln(number::FLOOR_ODDS * share * dx / number::FLOOR_WAY_M),
                        &sigmas,
                    );
                }
            }
        }
        if rules.drops {
            self.drops(base);
        }
    }
}

/// One more riser behind the last of a hypothesis, wherever it stands.
struct More<'b> {
    top_m: f32,
    kind: GroundKind,
    sums: Option<Split<'b>>,
}

/// What does not depend on where a riser stands.
struct Split<'b> {
    /// Of the echoes from each number on, on the tread before it …
    before: &'b EchoSums,
    /// … and on the one behind it.
    behind: EchoSums,
    /// Of the wall behind.
    wall: f32,
}

/// A regular going is as the flight's within this, times √(2π), metres.
const REGULAR_M: f32 = 0.03;
/// So many risers may be odd ones, the nearest.
const ODD_RISERS: usize = 4;
/// By how much an odd rise is off, metres.
const ODD_M: [f32; 2] = [-0.03, 0.03];
/// Farther from a riser than this its face changes nothing, metres.
const NEAR_M: f32 = 0.10;
/// Of the way, an echo stands for less than this, metres; the places between are farther apart.
const ECHO_M: f32 = 0.02;
/// Nearer than this no scan shows that the ground ends, metres.
const FIRST_DROP_M: f32 = 0.3;
/// The ground ends somewhere ahead so often, beside level ground.
const DROP_ODDS: f32 = 0.3;
/// Single rises on level ground: height, metres, and prior share at an echo and where no echo is. Boxes and thresholds
/// without an echo make no difference to the answer; steps without one look alike, whatever their height.
const FLOOR: [(f32, [f32; 2]); 8] = [
    (0.02, [0.5, 0.0]),
    (0.045, [0.05, 0.0]),
    (0.075, [0.08, 0.13]),
    (0.11, [0.10, 0.0]),
    (0.16, [0.14, 0.25]),
    (0.22, [0.06, 0.0]),
    (0.32, [0.15, 0.0]),
    (0.50, [0.15, 0.0]),
];
