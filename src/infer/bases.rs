//! Hypotheses that begin the posterior: the search's best flights, and what earlier scans found likely, refined.

use super::cloud::Cloud;
use super::gauss::TreadLevels;
use super::past::History;
use super::propose::descending;
use super::propose::search::Search;
use super::propose::stairs::{Flight, FlightShape};
use super::readings::Readings;
use super::refine::refine;
use super::variants::Base;
use crate::estimate::Estimate;
use crate::math;
use crate::model::treads::Descending;
use crate::model::{GroundKind, MAX_STEPS, Model, Sigmas, Staircase, View};
use crate::params::current;
use crate::params::generative::Generative;
use crate::signal::echoes::Echo;
use crate::signal::grid::PolarMap;
use heapless::Vec;

/// Hypotheses that begin the posterior: refined flights and a ramp; level ground and each round's answer, with walls behind
/// and without.
pub(super) type Bases = Vec<Base, { MOST_LOOKED + 1 + (1 + ROUNDS) * (WALLS + 1) }>;

/// The posterior of a scan: measurement model, hypotheses that begin it, particles. Its methods stand in two files: here
/// those that take in echoes and hypotheses ([`Posterior::take`], [`Posterior::propose`]), in `judgement.rs` those that
/// fill the cloud and read the particles ([`Posterior::judge`], [`Posterior::likeliest`], [`Posterior::outlines`]).
///
/// Too large for a small stack, so its memory comes from outside.
pub struct Posterior {
    pub(super) model: Model<'static>,
    pub(super) bases: Bases,
    pub(super) cloud: Cloud,
}

impl core::fmt::Debug for Posterior {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Posterior").finish_non_exhaustive()
    }
}

/// Riser heights from which the refinement begins, as multiples of the search's.
const STRETCHES: [f32; 2] = [0.95, 1.05];
/// Overhangs that are tried beside what the echoes say, metres.
const OVERHANGS_M: [f32; 2] = [0.0, 0.03];
/// Flights that the search puts so far behind its best are no proposals, nats: where those up to 5 nats behind are let
/// in, 8 of 2,014 validation scenes fewer are exact, up to 20 nats 14.
const RIVAL_NATS: f32 = 3.0;
/// Its best one in the other build, closed or floating, and what earlier scans carried on may be so far behind, nats: the
/// search knows no walls behind floating treads, and the past not at all.
const ADMITTED_NATS: f32 = 12.0;
/// Most flights that are refined: there is time for no more.
const MOST_LOOKED: usize = 6;
/// Two walls stand so far apart, metres.
const WALLS_APART_M: f32 = 0.05;
/// Nothing that the chair has come up to stands nearer to the mirror, metres: its footrests are there.
pub(super) const NEAREST_M: f32 = 0.3;
/// A wall stands at least this far behind the last riser, metres: the shortest landing.
pub(super) const LANDING_M: f32 = 0.28;
/// Most answers that are tried. Each is measured, and joins the particles with all that is near it; the first stands if it
/// is still their likeliest outline, the second in any case. With one, 16 of 2,014 validation scenes fewer are exact;
/// with three, one.
pub(super) const ROUNDS: usize = 2;
/// Walls that are tried, and echoes that may be one.
pub(super) const WALLS: usize = 2;
/// See [`WALLS`].
const WALL_DB: f32 = 8.0;
/// Where ramps begin, metres, and their slopes.
const RAMPS_FROM_M: [f32; 3] = [0.4, 0.8, 1.2];
/// See [`RAMPS_FROM_M`].
const SLOPES: [f32; 4] = [0.06, 0.09, 0.13, 0.18];
/// The best of them is moved by so much, metres and slope, where that makes it likelier.
const RAMP_MOVES: [(f32, f32); 2] = [(0.2, 0.02), (0.1, 0.01)];

/// A flight of the search as a staircase.
pub(super) fn staircase(flight: &Flight) -> Staircase {
    let mut s = Staircase::nothing();
    for (k, link) in flight.chain.iter().enumerate() {
        s = s.with(k, link.along_m, flight.shape.rise_m * (k + 1) as f32);
    }
    s.open = flight.shape.open;
    s
}

/// A staircase as a flight of the search.
pub(super) fn flight(search: &Search<'_, '_>, s: &Staircase) -> Flight {
    let mut flight = Flight {
        shape: FlightShape {
            rise_m: s.rise(),
            open: s.open,
        },
        ..Flight::default()
    };
    for x_m in s.x_m.iter().take(s.len()) {
        // A staircase has no more risers than a flight.
        let _ = flight.chain.push(search.at(*x_m));
    }
    flight.score = search.stairs.whole(&flight.chain, flight.shape);
    flight
}

impl Posterior {
    /// Without echoes.
    pub const fn new(g: &'static Generative) -> Self {
        Self {
            model: Model::empty(g),
            bases: Bases::new(),
            cloud: Cloud::new(),
        }
    }

    /// Changes the measurement model.
    pub const fn measure(&mut self, g: &'static Generative) {
        self.model.g = g;
    }

    /// Takes in a scan's echoes.
    pub fn take(&mut self, echoes: &[Echo], map: &PolarMap) {
        self.model.take(echoes, View::of(map), map.geometry());
        self.bases.clear();
    }

    /// Takes in the search's leaders, closed and floating, and what earlier scans found likely, each refined.
    #[inline(never)]
    pub fn propose(&mut self, search: &Search<'_, '_>, past: Option<&History>) {
        let scores = search.leaders.iter().map(|f| f.score);
        let top = scores.fold(f32::NEG_INFINITY, math::max);
        let rules = &search.stairs.scene().params.rules;
        for leader in &search.leaders {
            if leader.score >= top - RIVAL_NATS {
                self.look(leader, None);
            }
        }
        if let Some(past) = past {
            self.look_back(top, search, past);
        }
        if let Some(leader) = search.leaders.iter().find(|l| l.score >= top)
            && rules.other_build
        {
            let mut other = leader.clone();
            other.shape.open = !leader.shape.open;
            other.score = search.stairs.whole(&other.chain, other.shape);
            if other.score >= top - ADMITTED_NATS {
                self.look(&other, None);
            }
        }
        self.add(&Staircase::nothing(), &[0.0; MAX_STEPS], NEAREST_M);
        if rules.ramp_particles
            && let Some(ramp) = self.ramp()
        {
            // There is room for one.
            let _ = self.bases.push(ramp);
        }
    }

    /// Takes in stairs going down, weighed: as many of the likeliest as there is room for.
    #[inline(never)]
    pub fn descend(&mut self, model: &mut Descending, view: View, echoes: &[Echo]) {
        self.model.view = view;
        self.bases.clear();
        model.take(echoes, view);
        let bases = &mut self.bases;
        descending::propose(model, echoes, &mut |base| {
            if let Err(base) = bases.push(base) {
                // Level ground is what all others are held against.
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

    /// The likeliest ramp: the best of a grid, moved to where the echoes put it.
    #[inline(never)]
    fn ramp(&self) -> Option<Base> {
        let ramp = |(from_m, slope)| {
            Base::new(
                &self.model,
                Staircase::ramp(from_m, slope),
                [0.0; MAX_STEPS],
            )
        };
        let grid = RAMPS_FROM_M.into_iter();
        let grid = grid.flat_map(|from_m| SLOPES.map(|slope| (from_m, slope)));
        let mut best = grid.map(ramp).reduce(Base::likelier)?;
        for (by_m, by) in RAMP_MOVES {
            let GroundKind::Ramp { from_m, slope } = best.staircase.kind else {
                break;
            };
            let beside = [
                (from_m - by_m, slope),
                (from_m + by_m, slope),
                (from_m, slope - by),
                (from_m, slope + by),
            ];
            for place in beside {
                best = Base::likelier(best, ramp(place));
            }
        }
        Some(best)
    }

    /// Adds a staircase, with walls behind it from a distance on, metres, and without.
    #[inline(never)]
    pub(super) fn add(&mut self, staircase: &Staircase, sigmas: &Sigmas, from_m: f32) {
        for &wall_m in &walls(&self.model, from_m) {
            let s = Staircase {
                wall_m,
                ..*staircase
            };
            // There is room for those of level ground and of each round's answer.
            let _ = self.bases.push(Base::new(&self.model, s, *sigmas));
        }
    }

    /// Refines a flight, from itself or from another staircase.
    #[inline(never)]
    fn look(&mut self, flight: &Flight, from: Option<Staircase>) {
        if self.bases.len() < MOST_LOOKED {
            // There is room for more.
            let _ = self.bases.push(self.refined(&staircase(flight), from));
        }
    }

    /// Looks at the staircases that earlier scans found likely and this one's search did not think of.
    #[inline(never)]
    fn look_back(&mut self, top: f32, search: &Search<'_, '_>, past: &History) {
        for k in 0..past.hypotheses.len() {
            let Some(s) = past.hypotheses.staircase(k) else {
                continue;
            };
            let known = self
                .bases
                .iter()
                .any(|b| past.hypotheses.alike(&b.staircase, &s) && b.staircase.steps == s.steps);
            if known {
                continue;
            }
            let flight = flight(search, &s);
            if flight.score >= top - ADMITTED_NATS {
                self.look(&flight, Some(s));
            }
        }
    }

    /// A hypothesis, its levels so many times as high, moved to where its echoes put it, and weighed.
    #[inline(never)]
    fn moved(&self, start: &Staircase, stretch: f32) -> Base {
        let (mut s, mut sigmas) = (*start, [0.0; MAX_STEPS]);
        s.top_m.iter_mut().for_each(|top| *top *= stretch);
        self.refine(&mut s, &mut sigmas);
        Base::new(&self.model, s, sigmas)
    }

    /// Apart, so that its working memory is gone when the hypothesis is weighed.
    #[inline(never)]
    fn refine(&self, s: &mut Staircase, sigmas: &mut Sigmas) {
        let (mut levels, mut readings) = (TreadLevels::default(), Readings::default());
        let rise = Estimate::new(s.rise(), current().flight_rise_sigma_m);
        refine(
            &self.model,
            s,
            rise,
            current(),
            (&mut levels, &mut readings),
        );
        for (sigma, level) in sigmas.iter_mut().zip(&levels) {
            *sigma = level.height.sigma();
        }
    }

    /// The likeliest of a flight's refinements from several heights, overhangs and walls, and from `carried`, what an
    /// earlier scan made of it.
    #[inline(never)]
    fn refined(&self, start: &Staircase, carried: Option<Staircase>) -> Base {
        let base = |s, sigmas| Base::new(&self.model, s, sigmas);
        let [low, high] = STRETCHES;
        let top = match carried {
            None => Base::likelier(self.moved(start, low), self.moved(start, high)),
            // It knows the riser's height: one other beginning is enough.
            Some(s) => {
                let top = Base::likelier(self.moved(start, high), self.moved(&s, 1.0));
                Base::likelier(top, base(s, top.sigmas))
            }
        };
        let mut best = top;
        for overhang_m in OVERHANGS_M
            .into_iter()
            .filter(|_| !start.open && current().rules.overhang_starts)
        {
            let s = Staircase {
                overhang_m,
                ..top.staircase
            };
            best = Base::likelier(best, base(s, top.sigmas));
        }
        let open_air = best;
        let behind_m = best.staircase.last_x() + LANDING_M;
        for &wall_m in walls(&self.model, behind_m)
            .iter()
            .skip(1)
            .filter(|_| current().rules.walls_behind)
        {
            best = Base::likelier(best, open_air.walled(&self.model, wall_m));
        }
        best
    }
}

/// No wall, and the strongest echoes farther away than `from_m`, where one may stand.
pub(super) fn walls(model: &Model<'_>, from_m: f32) -> Vec<f32, { WALLS + 1 }> {
    let mut walls = Vec::new();
    let _ = walls.push(f32::INFINITY);
    for _ in 0..WALLS {
        let far = model.echoes.iter().filter(|e| {
            let apart = walls
                .iter()
                .all(|w: &f32| (w - e.x_m).abs() > WALLS_APART_M);
            e.snr_db > WALL_DB && e.x_m > from_m && apart
        });
        if let Some(e) = far.max_by(|a, b| a.snr_db.total_cmp(&b.snr_db)) {
            let _ = walls.push(e.x_m);
        }
    }
    walls
}
