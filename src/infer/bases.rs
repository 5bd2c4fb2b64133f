//! Initial hypotheses of the posterior: the search's best flights and the likely staircases of earlier scans, each
//! refined (its levels, places and overhang fitted to its echoes), level ground and the likeliest steep ramp.

use super::propose::descending;
use super::propose::search::Search;
use super::propose::stairs::{Flight, FlightShape};
use super::refine::{Refinement, refine};
use super::variants::Hypothesis;
use crate::estimate::Estimate;
use crate::math;
use crate::model::cloud::Cloud;
use crate::model::kinds::wall::{self, WALLS, WallEcho};
use crate::model::kinds::without_risers;
use crate::model::treads::Descending;
use crate::model::{MAX_STEPS, Model, Sigmas, Staircase, View};
use crate::params::Numbers;
use crate::params::generative::Generative;
use crate::params::posterior::{
    NEAREST_WALL_M, OTHER_MARGIN_NATS, OVERHANG_STARTS_M, PROPOSAL_MARGIN_NATS, SHORTEST_LANDING_M,
    STRETCHES,
};
use crate::past::History;
use crate::signal::echoes::Echo;
use crate::signal::grid::PolarMap;
use heapless::Vec;

/// Initial hypotheses of the posterior, in no order: refined flights; level ground and the answer of each round, each
/// without a wall and with each likely wall behind it; a steep ramp, in the place of the last of these where all are taken.
pub(super) type Hypotheses = Vec<Hypothesis, { MAX_REFINED + (1 + ROUNDS) * (WALLS + 1) }>;

/// The posterior of a scan: measurement model, initial hypotheses, particles.
///
/// Its methods are in two files. Those that take in echoes and hypotheses ([`Posterior::set_echoes`],
/// [`Posterior::propose`]) are here. Those that fill the cloud and evaluate the particles ([`Posterior::evaluate`],
/// [`Posterior::likeliest`], [`Posterior::outlines`]) are in `judgement.rs`. The type is too large for a small stack:
/// the caller provides its memory.
pub struct Posterior {
    pub(super) model: Model<'static>,
    pub(super) hypotheses: Hypotheses,
    pub(super) cloud: Cloud,
}

impl core::fmt::Debug for Posterior {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Posterior").finish_non_exhaustive()
    }
}

/// Minimum height above the ground of an echo that may be a wall's flash, metres.
const OFF_FLOOR_M: f32 = 0.05;
/// Maximum number of refined flights, set by the computing time.
const MAX_REFINED: usize = 6;
/// Maximum number of rounds. Each round's answer is measured, and it and its variants join the particles. The first
/// answer is final if it is still the likeliest outline, the second one in any case. With one round, 16 of 2,014
/// validation scenes fewer are exact; with three, one.
pub(super) const ROUNDS: usize = 2;
/// Converts a flight of the search to a staircase of equal rises, without overhang and without a wall.
pub(super) fn staircase(flight: &Flight) -> Staircase {
    let mut s = Staircase::nothing();
    for (k, link) in flight.chain.iter().enumerate() {
        s = s.with(k, link.along_m, flight.shape.rise_m * (k + 1) as f32);
    }
    s.open = flight.shape.open;
    s
}

/// Converts a staircase to a flight of the search, and scores it. A riser near a column of echoes is moved to the
/// column.
pub(super) fn flight(search: &Search<'_, '_>, s: &Staircase) -> Flight {
    let mut flight = Flight {
        shape: FlightShape {
            rise_m: s.rise(),
            open: s.open,
        },
        ..Flight::default()
    };
    for x_m in s.x_m.iter().take(s.len()) {
        // Cannot fail: a staircase has no more risers than a flight.
        let _ = flight.chain.push(search.at(*x_m));
    }
    flight.score = search.stairs.whole(&flight.chain, flight.shape);
    flight
}

impl Posterior {
    /// Returns a posterior without echoes.
    pub const fn new(g: &'static Generative, numbers: Numbers) -> Self {
        Self {
            model: Model::empty(g, numbers),
            hypotheses: Hypotheses::new(),
            cloud: Cloud::new(),
        }
    }

    /// Replaces the parameters of the posterior's measurement model by `g`.
    pub const fn measure(&mut self, g: &'static Generative) {
        self.model.g = g;
    }

    /// Puts a scan's echoes into the measurement model, and removes all hypotheses.
    pub fn set_echoes(&mut self, echoes: &[Echo], map: &PolarMap) {
        self.model.set_echoes(echoes, View::of(map), map.geometry());
        self.hypotheses.clear();
    }

    /// Adds the initial hypotheses going up: the search's best flights and the likely staircases of earlier scans,
    /// refined; the best flight also in the other build (closed or open); level ground; the likeliest steep ramp.
    #[inline(never)]
    pub fn propose(&mut self, search: &Search<'_, '_>, past: Option<&History>) {
        let scores = search.leaders.iter().map(|f| f.score);
        let top = scores.fold(f32::NEG_INFINITY, math::max);
        let rules = &search.stairs.scene().params.rules;
        for leader in &search.leaders {
            if leader.score >= top - PROPOSAL_MARGIN_NATS {
                self.refine_flight(leader, None);
            }
        }
        if let Some(past) = past {
            self.refine_past(top, search, past);
        }
        if let Some(leader) = search.leaders.iter().find(|l| l.score >= top)
            && rules.other_build
        {
            let mut other = leader.clone();
            other.shape.open = !leader.shape.open;
            other.score = search.stairs.whole(&other.chain, other.shape);
            if other.score >= top - OTHER_MARGIN_NATS {
                self.refine_flight(&other, None);
            }
        }
        self.add(&Staircase::nothing(), &[0.0; MAX_STEPS], NEAREST_WALL_M);
        if rules.ramp_particles
            && let Some(best) = self.without_risers()
        {
            // Cannot fail: the answers of the rounds come later.
            let _ = self.hypotheses.push(best);
        }
    }

    /// Replaces the hypotheses by those of stairs going down, level ground and a ramp, each with its weight. Where
    /// there are too many, the likeliest are kept.
    #[inline(never)]
    pub fn descend(&mut self, model: &mut Descending, view: View, echoes: &[Echo]) {
        self.model.view = view;
        self.hypotheses.clear();
        model.set_echoes(echoes, view);
        let bases = &mut self.hypotheses;
        descending::propose(model, echoes, &mut |base| {
            if let Err(base) = bases.push(base) {
                // Level ground is kept: it is the reference of all others.
                let stairs = bases.iter_mut().filter(|b| !b.staircase.is_empty());
                let least = stairs.min_by(|a, b| a.log_weight.total_cmp(&b.log_weight));
                if let Some(least) = least
                    && (least.log_weight < base.log_weight || base.staircase.is_empty())
                {
                    *least = base;
                }
            }
        });
    }

    /// Returns the likeliest hypothesis without risers besides level ground.
    #[inline(never)]
    fn without_risers(&self) -> Option<Hypothesis> {
        let mut best: Option<Hypothesis> = None;
        for kind in without_risers() {
            let new = Hypothesis::new(&self.model, Staircase::of(kind), [0.0; MAX_STEPS]);
            best = Some(best.map_or(new, |best| best.likelier(new)));
        }
        best
    }

    /// Adds a staircase to the hypotheses: once without a wall, and once with each likely wall beyond `from_m`, metres.
    #[inline(never)]
    pub(super) fn add(&mut self, staircase: &Staircase, sigmas: &Sigmas, from_m: f32) {
        for &wall_m in &walls(&self.model, from_m) {
            let s = Staircase {
                wall_m,
                ..*staircase
            };
            // Fails only for the last wall behind the last round's answer, where the steep ramp has its place.
            let _ = self
                .hypotheses
                .push(Hypothesis::new(&self.model, s, *sigmas));
        }
    }

    /// Refines a flight and adds it to the hypotheses, if there is room. `from` is the same staircase as refined by an
    /// earlier scan: another start.
    #[inline(never)]
    fn refine_flight(&mut self, flight: &Flight, from: Option<Staircase>) {
        if self.hypotheses.len() < MAX_REFINED {
            // Cannot fail: the length was checked.
            let _ = self.hypotheses.push(self.refined(&staircase(flight), from));
        }
    }

    /// Refines the likely staircases of earlier scans that the search of this scan did not find, and adds them to the
    /// hypotheses. `top` is the score of the search's best flight, nats.
    #[inline(never)]
    fn refine_past(&mut self, top: f32, search: &Search<'_, '_>, past: &History) {
        for k in 0..past.hypotheses.len() {
            let Some(s) = past.hypotheses.staircase(k) else {
                continue;
            };
            let known = self.hypotheses.iter().any(|b| {
                past.hypotheses.same_visible_steps(&b.staircase, &s) && b.staircase.steps == s.steps
            });
            if known {
                continue;
            }
            let flight = flight(search, &s);
            if flight.score >= top - OTHER_MARGIN_NATS {
                self.refine_flight(&flight, Some(s));
            }
        }
    }

    /// Returns a copy of `start` with the heights of all its treads multiplied by `stretch`, then refined on the echoes
    /// and weighted.
    #[inline(never)]
    fn moved(&self, start: &Staircase, stretch: f32) -> Hypothesis {
        let (mut s, mut sigmas) = (*start, [0.0; MAX_STEPS]);
        s.top_m.iter_mut().for_each(|top| *top *= stretch);
        self.refine(&mut s, &mut sigmas);
        Hypothesis::new(&self.model, s, sigmas)
    }

    /// Fits heights of treads, distances of risers and overhang of staircase `s` to its echoes, and writes the standard
    /// deviations of the heights, metres, to `sigmas`. A function of its own, so that its working memory is free while
    /// the hypothesis is weighted.
    #[inline(never)]
    fn refine(&self, s: &mut Staircase, sigmas: &mut Sigmas) {
        let mut refined = Refinement::default();
        let p = self.model.numbers.get();
        let rise = Estimate::new(s.rise(), p.flight_rise_sigma_m);
        refine(&self.model, s, rise, p, &mut refined);
        for (sigma, level) in sigmas.iter_mut().zip(&refined.levels) {
            *sigma = level.height.sigma();
        }
    }

    /// Returns the likeliest of a flight's refinements from several riser heights, overhangs and walls. `carried` is
    /// the same staircase as refined by an earlier scan.
    #[inline(never)]
    fn refined(&self, start: &Staircase, carried: Option<Staircase>) -> Hypothesis {
        let rules = &self.model.numbers.rules;
        let base = |s, sigmas| Hypothesis::new(&self.model, s, sigmas);
        let [low, high] = STRETCHES;
        let top = match carried {
            None => Hypothesis::likelier(self.moved(start, low), self.moved(start, high)),
            // The riser height of `carried` is a measurement, so one other start is enough.
            Some(s) => {
                let top = Hypothesis::likelier(self.moved(start, high), self.moved(&s, 1.0));
                Hypothesis::likelier(top, base(s, top.sigmas))
            }
        };
        let mut best = top;
        for overhang_m in OVERHANG_STARTS_M
            .into_iter()
            .filter(|_| !start.open && rules.overhang_starts)
        {
            let s = Staircase {
                overhang_m,
                ..top.staircase
            };
            best = Hypothesis::likelier(best, base(s, top.sigmas));
        }
        let open_air = best;
        let behind_m = best.staircase.last_x() + SHORTEST_LANDING_M;
        for &wall_m in walls(&self.model, behind_m)
            .iter()
            .skip(1)
            .filter(|_| rules.walls_behind)
        {
            best = Hypothesis::likelier(best, open_air.walled(&self.model, wall_m));
        }
        best
    }
}

/// Returns "no wall" (infinity) and the distances, metres, of the strongest echoes beyond `from_m` that may be a
/// wall.
pub(super) fn walls(model: &Model<'_>, from_m: f32) -> Vec<f32, { WALLS + 1 }> {
    // Strong echoes of the floor would take the places of walls, which flash.
    let off_floor = model.echoes.iter().filter(|e| e.y_m > OFF_FLOOR_M);
    let echoes = off_floor.map(|e| WallEcho {
        x_m: e.x_m,
        snr_db: e.snr_db,
    });
    wall::places(echoes, from_m)
}
