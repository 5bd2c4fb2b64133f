//! Variants of a hypothesis: one more riser behind the last, the last ones left out, an irregular rise; on bare
//! ground a step, a box, a threshold, a drop.
//!
//! A variant differs from its hypothesis in a few risers. Only their summands of the log-likelihood are computed
//! anew.

use crate::math;
use crate::model::cloud::{Cloud, ReportedAnswer};
use crate::model::kinds::{SINGLE_RISES, Variation, drop};
use crate::model::normal::ln;
use crate::model::prior::{going, prior};
use crate::model::{EchoSums, GroundKind, MAX_STEPS, Model, Sigmas, Staircase};
use crate::params::posterior::{
    self, BEHIND_RISER_M, FACE_NEAR_M, IRREGULAR_M, LANDING_PER_M, Limits, P_CONTINUES,
    PLACED_SIGMA_M, RiseOff, SPOT_DB, SPOTS_APART_M, TREAD_SIGMA_M,
};
use heapless::Vec;

/// Maximum number of places that are tried for one more riser.
const MAX_CANDIDATE_PLACES: usize = 40;

/// Returns the log-weight of a staircase, nats: log-prior plus log-likelihood.
pub fn weight(model: &Model<'_>, s: &Staircase) -> f32 {
    prior(s) + model.log_likelihood(s)
}

/// A hypothesis with its log-likelihood riser by riser, and its weight.
#[derive(Clone, Copy, Debug)]
pub struct Hypothesis {
    /// The staircase, or other ground, that the hypothesis states.
    pub staircase: Staircase,
    /// Standard deviations of the heights of the staircase's treads, metres.
    pub sigmas: Sigmas,
    /// Log-likelihoods, nats: entry k is that of riser k with the tread before it, and the entry behind the last
    /// riser's that of the landing; 0 from there on.
    steps: [f32; MAX_STEPS + 1],
    /// Weight of the hypothesis: log-prior plus log-likelihood, nats.
    pub log_weight: f32,
}

impl Hypothesis {
    /// Returns a hypothesis with its weight computed. `sigmas` are the standard deviations of its treads' heights,
    /// metres.
    #[inline(never)]
    pub fn new(model: &Model<'_>, staircase: Staircase, sigmas: Sigmas) -> Self {
        let mut steps = [0.0; MAX_STEPS + 1];
        let mut total = prior(&staircase);
        for (k, value) in steps.iter_mut().take(staircase.len() + 1).enumerate() {
            *value = model.riser_log_likelihood(&staircase, k);
            total += *value;
        }
        Self {
            staircase,
            sigmas,
            steps,
            log_weight: total,
        }
    }

    /// Returns a hypothesis of known weight, for stairs going down: the heights of its treads have the standard
    /// deviation of treads that are seen from above.
    pub fn weighed(staircase: Staircase, log_weight: f32) -> Self {
        Self {
            staircase,
            sigmas: [TREAD_SIGMA_M; MAX_STEPS],
            steps: [0.0; MAX_STEPS + 1],
            log_weight,
        }
    }

    /// Returns the hypothesis of greater weight; the first of two equal ones.
    pub fn likelier(self, other: Self) -> Self {
        if other.log_weight > self.log_weight {
            other
        } else {
            self
        }
    }

    /// Returns the hypothesis with a wall at `wall_m`, metres. Only the landing's log-likelihood and the prior
    /// change.
    #[inline(never)]
    pub fn walled(&self, model: &Model<'_>, wall_m: f32) -> Self {
        let mut out = *self;
        out.staircase.wall_m = wall_m;
        let n = self.staircase.len();
        let landing = model.riser_log_likelihood(&out.staircase, n);
        out.log_weight += prior(&out.staircase) - prior(&self.staircase) + landing
            - self.log_likelihood_of_risers(n, n + 1);
        if let Some(value) = out.steps.get_mut(n) {
            *value = landing;
        }
        out
    }

    /// Returns the log-likelihood of risers `from` to before `to`, each with the tread before it, nats.
    #[inline(never)]
    fn log_likelihood_of_risers(&self, from: usize, to: usize) -> f32 {
        self.steps.get(from..to).map_or(0.0, |s| s.iter().sum())
    }
}

/// Generator of a hypothesis's variants, which adds them to a cloud of particles.
pub struct Variants<'a> {
    /// Measurement model.
    pub model: &'a Model<'a>,
    /// Answer with which the variants are compared.
    pub reported: &'a ReportedAnswer<'a>,
    /// Cloud to which the variants are added.
    pub cloud: &'a mut Cloud,
}

/// Place for one more riser.
#[derive(Clone, Copy, Debug)]
struct CandidatePlace {
    /// Distance from the mirror, metres.
    x_m: f32,
    /// Length of way that the place represents, metres.
    way_m: f32,
}

/// Places for one more riser, in no order.
type CandidatePlaces = Vec<CandidatePlace, MAX_CANDIDATE_PLACES>;

impl Variants<'_> {
    /// Adds all variants of a hypothesis to the cloud.
    pub fn add_variants(&mut self, base: &Hypothesis) {
        let rules = &self.model.numbers.rules;
        for variation in base.staircase.kind.variations() {
            match variation {
                Variation::FewerRisers if rules.less => self.shorter(base),
                Variation::OneMoreRiser if rules.behind => self.longer(base),
                Variation::IrregularRiser if rules.odd => self.irregular(base),
                Variation::SingleRise if rules.single => self.single_rises(base),
                Variation::End if rules.drops => self.drops(base),
                Variation::FewerRisers
                | Variation::OneMoreRiser
                | Variation::IrregularRiser
                | Variation::SingleRise
                | Variation::End => {}
            }
        }
    }

    /// Adds variants of a flight with one riser where the goings of the others put it: a stray echo beside a riser may
    /// have taken its place.
    #[inline(never)]
    pub fn regular(&mut self, base: &Hypothesis) {
        let s = &base.staircase;
        for k in 0..s.len().min(IRREGULAR_RISERS) {
            let Some(x_m) = s.regular_x(k) else {
                continue;
            };
            let moved = (x_m - s.x(k)).abs() > SPOTS_APART_M;
            if !moved || x_m < posterior::FLOOR_FROM_TO_M.low {
                continue;
            }
            let mut new = *s;
            if let Some(place) = new.x_m.get_mut(k) {
                *place = x_m;
            }
            let weight = prior(&new) - prior(s) + self.log_likelihood_of_risers(&new, k, k + 2)
                - base.log_likelihood_of_risers(k, k + 2);
            self.add_variant(&new, base.log_weight + weight, &base.sigmas);
        }
    }

    #[inline(never)]
    fn add_variant(&mut self, s: &Staircase, log_weight: f32, sigmas: &Sigmas) {
        self.cloud.add(s, log_weight, sigmas, self.reported);
    }

    /// Returns the log-likelihood of a staircase's risers `from` to before `to`, each with the tread before it, nats.
    fn log_likelihood_of_risers(&self, s: &Staircase, from: usize, to: usize) -> f32 {
        (from..to)
            .map(|k| self.model.riser_log_likelihood(s, k))
            .sum()
    }

    /// Returns the places on a grid of `step_m` from `from_m` to `to_m`, and those of echoes between, each with the
    /// length of way that it represents: `step_m` on the grid, `echo_m` at an echo; metres.
    #[inline(never)]
    fn candidate_places(
        &self,
        from_m: f32,
        to_m: f32,
        step_m: f32,
        echo_m: f32,
    ) -> CandidatePlaces {
        let mut spots = CandidatePlaces::new();
        let mut x = from_m;
        while x < to_m && spots.len() < MAX_CANDIDATE_PLACES / 2 {
            // Cannot fail: the loop leaves room.
            let _ = spots.push(CandidatePlace {
                x_m: x,
                way_m: step_m,
            });
            x += step_m;
        }
        let mut last = f32::NEG_INFINITY;
        for e in &self.model.echoes {
            let within = e.x_m > from_m && e.x_m < to_m && e.snr_db > SPOT_DB;
            if within && e.x_m > last + SPOTS_APART_M {
                last = e.x_m;
                // Where there is no room, enough other places are near.
                let _ = spots.push(CandidatePlace {
                    x_m: e.x_m,
                    way_m: echo_m,
                });
            }
        }
        spots
    }

    /// Adds variants of the flight without its last steps: one less, two less, …
    #[inline(never)]
    fn shorter(&mut self, base: &Hypothesis) {
        let mut longer = base.staircase;
        let mut weight = base.log_weight;
        let mut part =
            base.log_likelihood_of_risers(base.staircase.len(), base.staircase.len() + 1);
        for n in (0..base.staircase.len()).rev() {
            let shorter = longer.without_last();
            let landing = self.model.riser_log_likelihood(&shorter, n);
            part += base.log_likelihood_of_risers(n, n + 1);
            weight += prior(&shorter) - prior(&longer) + landing - part;
            self.add_variant(&shorter, weight, &base.sigmas);
            part = landing;
            longer = shorter;
        }
    }

    /// Adds variants with one more riser behind the last, at an echo or at a place without one.
    #[inline(never)]
    fn longer(&mut self, base: &Hypothesis) {
        let s = &base.staircase;
        let (x, mean) = (s.last_x(), s.going());
        let end = math::min(
            x + posterior::BEHIND_TO_M,
            s.wall_m - posterior::BEHIND_WALL_M,
        );
        let Limits {
            low: nearest,
            high: farthest,
        } = posterior::BEHIND_GOINGS_M;
        let mut near = self.candidate_places(
            x + nearest,
            math::min(x + farthest, end),
            posterior::BEHIND_GRID_M,
            posterior::SPOT_M,
        );
        if let Some(mean) = mean.filter(|mean| x + mean < end) {
            // The mean going is a place of its own: it would be missed between the places of the grid.
            near.retain(|at| at.way_m < ECHO_M || (at.x_m - x - mean).abs() > REGULAR_M);
            let _ = near.push(CandidatePlace {
                x_m: x + mean,
                way_m: REGULAR_M,
            });
        }
        let far = self.candidate_places(x + farthest, end, f32::INFINITY, posterior::SPOT_M);
        let top = s.level(s.len()) + s.rise();
        let before = self.before(base, top - posterior::RISE_OFF_M);
        for RiseOff { off_m, share } in posterior::BEHIND_RISES {
            let more = self.extra_riser(base, top + off_m, GroundKind::Stairs, before.as_ref());
            for place in near.iter().chain(far.iter().skip(1)) {
                let at = place.x_m;
                let landing = if at > x + posterior::LANDING_FROM_M {
                    LANDING_PER_M
                } else {
                    0.0
                };
                let odds = P_CONTINUES * (going(at - x, mean) + landing) * place.way_m * share;
                if odds > posterior::MIN_ODDS {
                    let (new, weight) = self.added(base, &more, at);
                    self.add_variant(&new, weight + ln(odds), &base.sigmas);
                }
            }
        }
    }

    /// Returns the suffix sums of log-likelihood over the echoes on the last tread, which do not depend on where one
    /// more riser stands. It returns none where that riser, at least `top_m` high, would hide the space behind it.
    fn before(&self, base: &Hypothesis, top_m: f32) -> Option<EchoSums> {
        let s = &base.staircase;
        (!self.hides(top_m)).then(|| self.model.sums(s, s.len()))
    }

    /// Whether a riser whose top is at height `top_m`, metres above the ground, hides the space behind it: its top is
    /// above the mirror.
    fn hides(&self, top_m: f32) -> bool {
        top_m > self.model.view.height_m
    }

    /// Returns one more riser behind the last with its top at `top_m`, metres above the ground, without a place yet.
    /// `before` holds the sums over the echoes on the tread before it.
    fn extra_riser<'b>(
        &self,
        base: &Hypothesis,
        top_m: f32,
        kind: GroundKind,
        before: Option<&'b EchoSums>,
    ) -> ExtraRiser<'b> {
        let s = &base.staircase;
        let n = s.len();
        let mut far = s.with(n, s.last_x(), top_m);
        far.kind = kind;
        let before = before.filter(|_| !self.hides(top_m));
        ExtraRiser {
            top_m,
            kind,
            sums: before.map(|before| Split {
                before,
                beyond: self.model.sums(&far, n + 1),
                wall: self.model.riser(&far, n + 1),
            }),
        }
    }

    /// Returns the staircase with riser `more` at `x_m`, metres, and its log-weight without the prior odds of the
    /// riser.
    #[inline(never)]
    fn added(&self, base: &Hypothesis, more: &ExtraRiser<'_>, x_m: f32) -> (Staircase, f32) {
        let (model, s) = (self.model, &base.staircase);
        let n = s.len();
        let mut new = s.with(n, x_m, more.top_m);
        new.kind = more.kind;
        let old = base.log_likelihood_of_risers(n, n + 1);
        let part = match &more.sums {
            None => self.log_likelihood_of_risers(&new, n, n + 2),
            Some(Split {
                before,
                beyond,
                wall,
            }) => {
                let (from, to) = (x_m - FACE_NEAR_M, x_m + FACE_NEAR_M);
                let at =
                    |sums: &EchoSums, x| sums.get(model.first_beyond(x)).copied().unwrap_or(0.0);
                let start = if n > 0 {
                    s.last_x() + BEHIND_RISER_M
                } else {
                    f32::NEG_INFINITY
                };
                let from = math::max(from, start);
                at(before, start) - at(before, from)
                    + model.within(&new, n, from, to)
                    + model.within(&new, n + 1, from, to)
                    + at(beyond, to)
                    - model.expected(&new, n)
                    - model.expected(&new, n + 1)
                    + model.riser(&new, n)
                    + wall
            }
        };
        let line = if n == 0 && more.sums.is_some() {
            new.ground_line(&model.surfaces)
        } else {
            0.0
        };
        (new, base.log_weight + part + line - old)
    }

    /// Adds variants with one irregular riser, higher or lower than the others; all treads behind it are shifted by as
    /// much, or only the first one.
    #[inline(never)]
    fn irregular(&mut self, base: &Hypothesis) {
        let s = &base.staircase;
        let n = s.len();
        let odds = ln(posterior::ODD_ODDS / n as f32 / (2 * IRREGULAR_M.len()) as f32);
        // Risers farther away mostly lie beyond the horizon.
        for k in 0..n.min(IRREGULAR_RISERS) {
            for off in IRREGULAR_M {
                for end in [n, k + 1] {
                    if end == k + 1 && end == n && k > 0 {
                        continue;
                    }
                    let mut new = *s;
                    let tops = new.top_m.get_mut(k..end).unwrap_or(&mut []);
                    tops.iter_mut().for_each(|top| *top += off);
                    if (0..n).any(|i| new.level(i + 1) < new.level(i) + posterior::MIN_RISE_M) {
                        continue;
                    }
                    let to = math::min((end + 1) as f32, (n + 1) as f32) as usize;
                    let weight = odds + self.log_likelihood_of_risers(&new, k, to)
                        - base.log_likelihood_of_risers(k, to);
                    self.add_variant(&new, base.log_weight + weight, &base.sigmas);
                }
            }
        }
    }

    /// Adds variants of bare ground that ends, one for each 5 cm slot of the way.
    #[inline(never)]
    fn drops(&mut self, base: &Hypothesis) {
        let (model, s) = (self.model, &base.staircase);
        let (before, behind) = (
            model.sums(&Staircase::drop(f32::INFINITY), 0),
            model.sums(&Staircase::drop(f32::NEG_INFINITY), 0),
        );
        let at = |sums: &EchoSums, k| sums.get(k).copied().unwrap_or(0.0);
        for x in drop::places(s.wall_m) {
            let brink = Staircase::drop(x);
            let first = model.first_beyond(x);
            let part = at(&before, 0) - at(&before, first) + at(&behind, first)
                - model.expected(&brink, 0)
                + brink.ground_line(&model.surfaces);
            let weight = drop::log_odds() + part - base.log_likelihood_of_risers(0, 1);
            self.add_variant(
                &brink,
                base.log_weight + weight,
                &[PLACED_SIGMA_M; MAX_STEPS],
            );
        }
    }

    /// Adds variants of bare ground with one step, box or threshold at each candidate place.
    #[inline(never)]
    fn single_rises(&mut self, base: &Hypothesis) {
        let s = &base.staircase;
        let Limits {
            low: nearest,
            high: farthest,
        } = posterior::FLOOR_FROM_TO_M;
        let end = math::min(farthest, s.wall_m - posterior::FLOOR_WALL_M);
        let sigmas = [PLACED_SIGMA_M; MAX_STEPS];
        let spots = self.candidate_places(nearest, end, posterior::FLOOR_GRID_M, posterior::SPOT_M);
        let before = self.before(base, 0.0);
        for rise in SINGLE_RISES.into_iter().flatten() {
            let kind = GroundKind::single(rise.height_m, &self.model.numbers);
            let more = self.extra_riser(base, rise.height_m, kind, before.as_ref());
            for spot in &spots {
                let share = if spot.way_m < ECHO_M {
                    rise.at_echo
                } else {
                    rise.elsewhere
                };
                if share > 0.0 {
                    let (new, weight) = self.added(base, &more, spot.x_m);
                    let odds = posterior::FLOOR_ODDS * share * spot.way_m / posterior::FLOOR_WAY_M;
                    self.add_variant(&new, weight + ln(odds), &sigmas);
                }
            }
        }
    }
}

/// One more riser behind the last of a hypothesis, without a place.
struct ExtraRiser<'b> {
    top_m: f32,
    kind: GroundKind,
    sums: Option<Split<'b>>,
}

/// Terms of the log-likelihood with one more riser that do not depend on the riser's place.
struct Split<'b> {
    /// Suffix sums of log-likelihood over the echoes, as if all lay on the tread before the riser, nats.
    before: &'b EchoSums,
    /// Suffix sums of log-likelihood over the echoes, as if all lay on the tread behind the riser, nats.
    beyond: EchoSums,
    /// Log-likelihood ratio of the wall's point features behind the riser, nats; 0 without a wall.
    wall: f32,
}

/// Length of way that the place at the mean going represents, metres: the spread of regular goings times √(2π).
const REGULAR_M: f32 = 0.03;
/// Number of risers, from the nearest on, of which one may be irregular.
const IRREGULAR_RISERS: usize = 4;
/// Limit that tells a place at an echo, which represents a shorter length of way ([`posterior::SPOT_M`], 6 mm), from a
/// place of the grid (8 cm and more), metres.
const ECHO_M: f32 = 0.02;
