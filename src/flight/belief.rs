//! From the search's flights to hypotheses: which of them explains the echoes best.

use super::ascending::{self, Ascending};
use super::search::Search;
use super::stairs::{Flight, MAX_FLIGHT, Stairs};
use crate::estimate::Estimate;
use crate::fusion::History;
use crate::math;
use crate::params::current;
use crate::params::generative::Generative;
use crate::posterior::gauss::TreadLevels;
use crate::posterior::{
    Base, Cloud, MAX_STEPS, Model, Readings, Sigmas, Staircase, View, refine, weight,
};
use crate::signal::echoes::Echo;
use crate::signal::grid::PolarMap;
use heapless::Vec;

/// Hypotheses that begin the posterior: the best flight of each length with its refined dimensions,
/// level ground, the answer, and either with walls behind.
pub(super) type Bases = Vec<Base, { MAX_FLIGHT + 2 * WALLS + 2 }>;

/// Working memory of the posterior: too large for a small stack, so it comes from outside.
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

/// How much the measurement model's word counts beside the search's score, which rests on the same
/// echoes.
const SHARE: f32 = 0.5;
/// Riser heights from which the refinement begins, as multiples of the search's.
const STRETCHES: [f32; 2] = [0.95, 1.05];
/// Overhangs that are tried beside what the echoes say, metres.
const OVERHANGS_M: [f32; 2] = [0.0, 0.03];
/// Flights that the search puts so far behind its best are not looked at again, nats.
const RIVAL_NATS: f32 = 5.0;
/// So many flights of the search are looked at, its best.
const LEADERS: usize = 3;
/// Its best one closed in place of floating, or the other way, may cost so much more, nats: the search
/// knows no walls behind floating treads.
const SURE_NATS: f32 = 12.0;
/// So many flights are refined at most: what there is time for.
const MOST_LOOKED: usize = 6;
/// Two walls stand so far apart, metres.
const WALLS_APART_M: f32 = 0.05;
/// Nothing that the chair has come up to stands nearer to the mirror, metres: its footrests are there.
pub(super) const NEAREST_M: f32 = 0.3;
/// A wall stands at least this far behind the last riser, metres: the shortest landing.
pub(super) const LANDING_M: f32 = 0.28;
/// Walls that are tried, and echoes that may be one.
pub(super) const WALLS: usize = 2;
/// See [`WALLS`].
const WALL_DB: f32 = 8.0;

/// A flight of the search as a staircase.
fn staircase(flight: &Flight<ascending::AscentShape>) -> Staircase {
    let mut s = Staircase::nothing();
    for (k, link) in flight.chain.iter().enumerate() {
        s = s.with(k, link.along_m, flight.shape.rise_m * (k + 1) as f32);
    }
    s.open = flight.shape.open;
    s
}

/// The flight that explains the echoes best.
#[derive(Debug)]
pub struct Chosen {
    /// The flight.
    pub flight: Flight<ascending::AscentShape>,
    /// Number of the base that its refinement has made of it.
    base: usize,
    /// What the measurement model says for it and against level ground, times its share, nats.
    pub odds: f32,
}

/// How far a choice has come.
struct Looking {
    /// The search's best score, nats.
    top: f32,
    /// So many flights were refined.
    looked: usize,
    /// The best one, with its score and what the models say of it, nats.
    best: Option<(f32, Chosen)>,
    /// The most by this scan alone, of all flights …
    alone: f32,
    /// … and of those that earlier scans thought of.
    expected: f32,
}

impl Chosen {
    /// A flight as the search has it.
    pub fn of(flight: Flight<ascending::AscentShape>) -> Self {
        Self {
            flight,
            base: usize::MAX,
            odds: 0.0,
        }
    }

    /// The same with another flight, which begins like it.
    pub fn with(&self, flight: Flight<ascending::AscentShape>) -> Self {
        Self {
            flight,
            base: self.base,
            odds: self.odds,
        }
    }
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

    /// The staircase that the refinement has made of a flight, with as many risers as the flight has now.
    #[inline(never)]
    pub fn refined_from(&self, chosen: &Chosen) -> Staircase {
        let flight = staircase(&chosen.flight);
        let Some(base) = self.bases.get(chosen.base) else {
            return flight;
        };
        let mut s = base.staircase;
        for k in s.len()..flight.len() {
            s = s.with(k, flight.x(k), flight.level(k + 1));
        }
        s
    }

    /// Takes in a scan's echoes.
    pub fn take(&mut self, echoes: &[Echo], map: &PolarMap) {
        self.model.take(echoes, View::of(map), map.geometry());
        self.bases.clear();
    }

    /// Takes in the search's leaders, closed and floating, refined and weighed; returns the one that explains
    /// the echoes best.
    #[inline(never)]
    pub fn choose(
        &mut self,
        search: &Search<'_, Ascending<'_>>,
        mut past: Option<&mut History>,
    ) -> Option<Chosen> {
        let scores = search.leaders.iter().map(|f| f.score);
        let top = scores.fold(f32::NEG_INFINITY, math::max);
        let mut looking = Looking {
            top,
            looked: 0,
            best: None,
            alone: f32::NEG_INFINITY,
            expected: f32::NEG_INFINITY,
        };
        let l = &mut looking;
        let rules = &search.stairs.scene().params.rules;
        for leader in &search.leaders {
            let better = search.leaders.iter().filter(|l| l.score > leader.score);
            if better.count() < LEADERS {
                self.look(l, leader.clone(), (RIVAL_NATS, None), past.as_deref_mut());
            }
        }
        if let Some(past) = past.as_deref_mut() {
            self.look_back(l, search, past);
        }
        if let Some(leader) = search.leaders.iter().find(|l| l.score >= top)
            && rules.other_build
        {
            let mut other = leader.clone();
            other.shape.open = !leader.shape.open;
            other.score = search.stairs.whole(&other.chain, other.shape);
            self.look(l, other, (SURE_NATS, None), past.as_deref_mut());
        }
        let mut chosen = looking.best.take().map(|(_, chosen)| chosen);
        if let Some(chosen) = &mut chosen {
            chosen.odds = SHARE * (chosen.odds - self.rival());
        }
        if let Some(past) = past {
            self.remember(&looking, chosen.as_mut(), past);
        }
        chosen
    }

    /// Refines a flight that the search puts at most so many nats behind its best, from itself or from
    /// another staircase, and weighs it.
    #[inline(never)]
    fn look(
        &mut self,
        looking: &mut Looking,
        flight: Flight<ascending::AscentShape>,
        (nats, from): (f32, Option<Staircase>),
        past: Option<&mut History>,
    ) {
        if flight.score < looking.top - nats || looking.looked == MOST_LOOKED {
            return;
        }
        looking.looked += 1;
        let base = self.refined(&staircase(&flight), from);
        let mut worth = flight.score + SHARE * base.log_weight;
        if let Some(past) = past {
            let word = past.hypotheses.word(&base.staircase);
            looking.alone = math::max(looking.alone, worth);
            if word > -current().carried_most_nats {
                looking.expected = math::max(looking.expected, worth);
            }
            worth += word;
            past.hypotheses.keep(&base.staircase, worth);
        }
        if looking.best.as_ref().is_none_or(|(most, _)| worth > *most) {
            let chosen = Chosen {
                flight,
                base: self.bases.len(),
                odds: base.log_weight,
            };
            looking.best = Some((worth, chosen));
        }
        // Room is left for level ground and the answer.
        if self.bases.len() < MAX_FLIGHT {
            let _ = self.bases.push(base);
        }
    }

    /// Looks at the staircases that earlier scans found likely and this one's search did not think of.
    #[inline(never)]
    fn look_back(
        &mut self,
        looking: &mut Looking,
        search: &Search<'_, Ascending<'_>>,
        past: &mut History,
    ) {
        for k in 0..past.hypotheses.len() {
            let Some(s) = past.hypotheses.staircase(k) else {
                continue;
            };
            let known = self
                .bases
                .iter()
                .any(|b| past.hypotheses.alike(&b.staircase, &s) && b.staircase.steps == s.steps);
            if known || s.is_empty() {
                continue;
            }
            let mut flight = Flight {
                shape: ascending::AscentShape {
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
            self.look(looking, flight, (SURE_NATS, Some(s)), Some(past));
        }
    }

    /// Weighs no stairs at all like the flights, by this scan and by earlier ones, and keeps it all for the
    /// next scan; forgets what was carried on if this scan contradicts it.
    #[inline(never)]
    fn remember(&mut self, looking: &Looking, chosen: Option<&mut Chosen>, past: &mut History) {
        let nothing = Staircase::nothing();
        let worth = SHARE * self.rival();
        let word = past.hypotheses.word(&nothing);
        let (mut alone, mut expected) = (looking.alone, looking.expected);
        alone = math::max(alone, worth);
        if word > -current().carried_most_nats {
            expected = math::max(expected, worth);
        }
        past.hypotheses.keep(&nothing, worth + word);
        past.hypotheses.settle();
        let changed = !past.is_empty() && alone > expected + current().scene_changed_nats;
        if let Some(chosen) = chosen {
            let flight = staircase(&chosen.flight);
            chosen.odds += past.hypotheses.word(&flight) - word;
        }
        if changed {
            past.contradict();
        }
    }

    /// Weight of level ground, with or without a wall.
    #[inline(never)]
    fn rival(&self) -> f32 {
        let grounds = walls(&self.model, NEAREST_M)
            .into_iter()
            .map(|wall_m| Staircase {
                wall_m,
                ..Staircase::nothing()
            });
        grounds
            .map(|ground| weight(&self.model, &ground))
            .fold(f32::NEG_INFINITY, math::max)
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
            None => likelier(self.moved(start, low), self.moved(start, high)),
            // It knows the riser's height: one other beginning is enough.
            Some(s) => {
                let top = likelier(self.moved(start, high), self.moved(&s, 1.0));
                likelier(top, base(s, top.sigmas))
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
            best = likelier(best, base(s, top.sigmas));
        }
        let open_air = best;
        let behind_m = best.staircase.last_x() + LANDING_M;
        for &wall_m in walls(&self.model, behind_m)
            .iter()
            .skip(1)
            .filter(|_| current().rules.walls_behind)
        {
            best = likelier(best, open_air.walled(&self.model, wall_m));
        }
        best
    }
}

/// The one of greater weight; the first of two alike.
fn likelier(a: Base, b: Base) -> Base {
    if b.log_weight > a.log_weight { b } else { a }
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
