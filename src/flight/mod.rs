//! The default estimator: from echoes to the staircase that explains them best.
//!
//! | module | does |
//! |---|---|
//! | `scene` | echoes placed, weighed, sorted, gathered into columns |
//! | `roles` | what an echo is if a flight goes up there: the one classifier |
//! | `null` | what else may be there: level ground, ramps |
//! | `stairs` | what a kind of stairs is to the search |
//! | `ascending`, `descending` | how well a flight of each kind explains the echoes |
//! | `search` | the best flight |
//! | `heights` | the levels of all treads, weighed against the flight's regularity |
//! | `readings` | what each riser's own echoes say |
//! | `dimensions` | steps with their standard deviations |
//! | `verdict`, `horizon` | what the answer is worth, and how far ahead |
//! | [`trace`] | what it thought on the way |

// The stages are `inline(never)`: each has its working memory on a stack of 16 KB, and merged into
// one function they would hold all of it at the same time.

mod ascending;
mod descending;
mod dimensions;
mod heights;
mod horizon;
mod null;
mod readings;
mod roles;
mod scene;
mod search;
mod stairs;
pub mod trace;
mod verdict;

#[cfg(test)]
mod tests;

use crate::answer::{Outcome, Reason, Status};
use crate::config::{Config, Plane};
use crate::echoes::{Collector, Echo, Echoes, calibrate};
use crate::estimator::Estimator;
use crate::grid::{Geometry, PolarMap};
use crate::math;
use crate::observer::{Event, Observer};
use crate::params::generative::Generative;
use crate::params::measured;
pub use crate::params::Params;
use ascending::Ascending;
use descending::Descending;
use dimensions::Measured;
use horizon::{Ground, LEAST_HORIZON_M, Vouch};
use readings::Roles;
use roles::Role;
use scene::Scene;
use search::{Beginnings, Search};
use stairs::{Explanation, Flight, Stairs};
use trace::{Hypothesis, Scatterer, Stage};

/// The estimator: what it keeps during a scan, and after the last row the search's memory in the
/// same place.
#[derive(Debug)]
pub struct Likelihood {
    phase: Phase,
    echoes: Echoes,
    params: &'static Params,
    measured: &'static Generative,
}

#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "the phases follow each other in the same memory"
)]
enum Phase {
    Rows(Collector),
    Up(Beginnings<ascending::Shape>),
    Down(Beginnings<descending::Shape>),
}

impl Default for Likelihood {
    fn default() -> Self {
        Self::new()
    }
}

impl Likelihood {
    /// Before the first scan.
    pub const fn new() -> Self {
        Self::with(&Params::DEFAULT)
    }

    /// The same with other numbers than those that were tuned: to see what they do.
    pub const fn with(params: &'static Params) -> Self {
        Self {
            phase: Phase::Rows(Collector::new()),
            echoes: Echoes::new(),
            params,
            measured: &measured::UP,
        }
    }

    /// The same with another measurement model in the depth plane: to fit what rests on it.
    pub const fn measuring(mut self, measured: &'static Generative) -> Self {
        self.measured = measured;
        self
    }
}

impl Estimator for Likelihood {
    fn begin(&mut self, map: &PolarMap) {
        if !matches!(self.phase, Phase::Rows(_)) {
            self.phase = Phase::Rows(Collector::new());
        }
        if let Phase::Rows(collector) = &mut self.phase {
            collector.begin(map);
        }
    }

    fn row(&mut self, map: &PolarMap, k: usize) {
        if let Phase::Rows(collector) = &mut self.phase {
            collector.row(map, k);
        }
    }

    fn finish(
        &mut self,
        map: &PolarMap,
        config: &Config,
        _scan: u32,
        observer: &mut dyn Observer,
    ) -> Outcome {
        let Phase::Rows(collector) = &mut self.phase else {
            return Outcome::fault(Reason::Silent);
        };
        let p = self.params;
        let echoes = &mut self.echoes;
        let noise = collector.finish(map, config, p, echoes);
        observer.event(Event::Noise(noise));
        observer.event(Event::Done(Stage::Echoes));
        let geometry = map.geometry();
        self.phase = match geometry.plane {
            Plane::Depth => Phase::Up(Beginnings::new()),
            Plane::Height => Phase::Down(Beginnings::new()),
        };
        let outcome = match &mut self.phase {
            Phase::Up(memory) => ascend(echoes, geometry, (p, self.measured), memory, observer),
            Phase::Down(memory) => descend(echoes, geometry, p, memory, observer),
            Phase::Rows(_) => Outcome::fault(Reason::Silent),
        };
        observer.event(Event::Done(Stage::Dimensions));
        if echoes.iter().any(|e| e.snr_db >= p.sure_echo_db) {
            outcome
        } else {
            Outcome::fault(Reason::NoEcho)
        }
    }
}

/// The best stairs going up, if they explain the echoes better than everything else.
#[inline(never)]
fn ascend(
    echoes: &mut [Echo],
    geometry: &Geometry,
    (p, generative): (&Params, &Generative),
    memory: &mut Beginnings<ascending::Shape>,
    observer: &mut dyn Observer,
) -> Outcome {
    let found = calibrate::calibrate(echoes, geometry, p);
    observer.event(Event::Calibration {
        bias_rad: found.bias_rad,
        height_m: found.height_m,
    });
    let mut scene = Scene::new(geometry.mount_height_m, p);
    scene.risers(echoes);
    let scene = &scene;
    let stairs = Ascending::new(scene);
    let mut search = Search::new(&stairs);
    let best = search.best(memory);
    let model = crate::posterior::Model::new(
        echoes,
        geometry.mount_height_m,
        geometry.beamwidth_rad,
        geometry.bin_m,
        generative,
    );
    let best = choose(&model, &search, best, p).map(|mut flight| {
        let (rise, score) = stairs.rise(&flight);
        flight.score = score;
        (flight, rise)
    });
    observer.event(Event::Done(Stage::Search));
    let accepted = best.as_ref().filter(|(f, _)| f.score >= p.accept_up_nats);
    let measured = accepted
        .map(|(flight, rise)| dimensions::ascending(&stairs, flight, *rise, found.bias_sigma_rad));
    let best = best.as_ref().map(|b| &b.0);
    let doubts = doubts(&model, &search, measured.as_ref());
    let ended = Ended {
        search: &search,
        best,
        measured,
        accept: p.accept_up_nats,
        geometry,
        doubts,
    };
    ended.tell(echoes, observer);
    ended.conclude(observer)
}

/// The same for stairs going down.
#[inline(never)]
fn descend(
    echoes: &[Echo],
    geometry: &Geometry,
    p: &Params,
    memory: &mut Beginnings<descending::Shape>,
    observer: &mut dyn Observer,
) -> Outcome {
    let mut scene = Scene::new(geometry.mount_height_m, p);
    scene.treads(echoes);
    let scene = &scene;
    let stairs = Descending::new(scene);
    let mut search = Search::new(&stairs);
    let best = search.best(memory);
    observer.event(Event::Done(Stage::Search));
    let accepted = best.as_ref().filter(|f| f.score >= p.accept_down_nats);
    let measured = accepted.map(|flight| dimensions::descending(&stairs, flight));
    let ended = Ended {
        search: &search,
        best: best.as_ref(),
        measured,
        accept: p.accept_down_nats,
        geometry,
        doubts: [0.0; horizon::CELLS],
    };
    ended.tell(echoes, observer);
    ended.conclude(observer)
}

/// The leader that explains the echoes best under the measurement model, the search's score as a
/// prior.
#[inline(never)]
fn choose(
    model: &crate::posterior::Model<'_>,
    search: &Search<'_, Ascending<'_>>,
    best: Option<Flight<ascending::Shape>>,
    _p: &Params,
) -> Option<Flight<ascending::Shape>> {
    use crate::posterior::{Staircase, weight};
    let share: f32 = VARS.0;
    let best = best?;
    let mut top = (f32::NEG_INFINITY, best.clone());
    for flight in &search.leaders {
        let mut w = f32::NEG_INFINITY;
        for f in [0.88, 0.94, 1.0, 1.06, 1.12] {
            for overhang_m in [0.0, 0.02, 0.04] {
                let mut s = Staircase::nothing();
                for (k, link) in flight.chain.iter().enumerate() {
                    s = s.with(k, link.along_m, f * flight.shape.rise_m * (k + 1) as f32);
                }
                s.open = flight.shape.open;
                s.overhang_m = overhang_m;
                w = math::max(w, weight(model, &s));
            }
        }
        let total = VARS.1 * w + share * flight.score;
        if total > top.0 {
            top = (total, flight.clone());
        }
    }
    Some(top.1)
}
const VARS: (f32, f32) = (1.0, 0.5);

/// What else may stand there.
#[inline(never)]
fn doubts(
    model: &crate::posterior::Model<'_>,
    search: &Search<'_, Ascending<'_>>,
    measured: Option<&Measured>,
) -> [f32; horizon::CELLS] {
    use crate::posterior::{Kind, Staircase, assess};
    let mut bases: heapless::Vec<Staircase, 32> = heapless::Vec::new();
    let mut told: heapless::Vec<(f32, f32), 16> = heapless::Vec::new();
    let open = search.leaders.iter().max_by(|a, b| a.score.total_cmp(&b.score));
    let mut winner = Staircase::nothing();
    if let Some(m) = measured {
        for (k, step) in m.outcome.steps.iter().enumerate() {
            let _ = told.push((step.distance_m, step.height_m));
            winner = winner.with(k, step.distance_m + m.overhang_m, step.height_m);
        }
        winner.overhang_m = m.overhang_m;
        winner.open = open.is_some_and(|f| f.shape.open);
    }
    let mut walls: heapless::Vec<f32, 3> = heapless::Vec::new();
    let _ = walls.push(f32::INFINITY);
    for _ in 0..2 {
        let far = model.echoes.iter().filter(|e| {
            e.snr_db > 8.0 && e.x_m > 0.3 && walls.iter().all(|w| (w - e.x_m).abs() > 0.05)
        });
        if let Some(e) = far.max_by(|a, b| a.snr_db.total_cmp(&b.snr_db)) {
            let _ = walls.push(e.x_m);
        }
    }
    for &wall_m in &walls {
        let _ = bases.push(Staircase { wall_m, ..Staircase::nothing() });
    }
    for from in [0.4, 0.8, 1.2] {
        for slope in [0.06, 0.09, 0.13, 0.18] {
            let _ = bases.push(Staircase { kind: Kind::Ramp, slope, wall_m: from, ..Staircase::nothing() });
        }
    }
    if winner.len() > 0 {
        let _ = bases.push(winner);
        let last = winner.x(winner.len() - 1);
        for &w in walls.iter().filter(|w| w.is_finite() && **w > last + 0.28) {
            let _ = bases.push(Staircase { wall_m: w, ..winner });
        }
    }
    for flight in &search.leaders {
        let mut best = (f32::NEG_INFINITY, Staircase::nothing());
        for f in [0.88, 0.94, 1.0, 1.06, 1.12] {
            for overhang_m in [0.0, 0.02, 0.04] {
                let mut s = Staircase::nothing();
                for (k, link) in flight.chain.iter().enumerate() {
                    s = s.with(k, link.along_m, f * flight.shape.rise_m * (k + 1) as f32);
                }
                s.open = flight.shape.open;
                s.overhang_m = overhang_m;
                let l = model.whole(&s);
                if l > best.0 {
                    best = (l, s);
                }
            }
        }
        let _ = bases.push(best.1);
    }
    assess(model, &bases, &told).hazards()
}

/// A search that has come to its end.
struct Ended<'s, S: Stairs> {
    search: &'s Search<'s, S>,
    best: Option<&'s Flight<S::Shape>>,
    /// The best flight's steps, if it was accepted.
    measured: Option<Measured>,
    /// Score from which a flight counts, nats.
    accept: f32,
    geometry: &'s Geometry,
    doubts: [f32; horizon::CELLS],
}

impl<S: Stairs> Ended<'_, S> {
    /// The outcome and what it is worth: of a flight that was accepted and measured, or of none.
    #[inline(never)]
    fn conclude(mut self, observer: &mut dyn Observer) -> Outcome {
        let scene = self.search.stairs.scene();
        let p = scene.params;
        let roles = self.roles();
        let accepted = self.measured.is_some();
        let (mut outcome, supports) = match self.measured.take() {
            Some(measured) => (measured.outcome, measured.supports),
            None => (Outcome::clear(), heapless::Vec::new()),
        };
        let lead = match self.best.filter(|_| !supports.is_empty()) {
            Some(best) => {
                let pairs = scene.marks.iter().zip(&roles);
                let against = pairs.filter(|(_, role)| role.contradicts()).map(|(m, _)| m);
                let lead = best.score - self.search.rival(best.chain.len()).max(self.accept);
                verdict::judge(&mut outcome, lead, &supports, against, p);
                lead
            }
            None => {
                // A flight that was accepted and then found to be a box or a threshold is no rival.
                let rival = self.best.filter(|_| !accepted);
                let rival = rival.map_or(f32::NEG_INFINITY, |b| b.score - self.accept);
                let strongest_db = scene.marks.iter().map(|m| m.snr_db).fold(0.0, math::max);
                verdict::judge_none(&mut outcome, rival, strongest_db, p);
                rival
            }
        };
        outcome.link();
        let ground = Ground {
            scene,
            roles: &roles,
            steps: &outcome.steps,
            supports: &supports,
            lead,
            open: self.best.is_some_and(|b| S::open(b.shape)),
            geometry: self.geometry,
            doubts: self.doubts,
        };
        if observer.listens() {
            ground
                .cells()
                .for_each(|cell| observer.event(Event::Cell(&cell)));
        }
        let vouch = Vouch::of(&ground);
        promise(&mut outcome, vouch);
        outcome
    }

    /// What each mark is taken for: by the flight that was measured, or on the bare ground.
    fn roles(&self) -> Roles {
        if let Some(measured) = self.measured.as_ref().filter(|m| !m.supports.is_empty()) {
            return measured.roles.clone();
        }
        let mut roles = Roles::new();
        for m in &self.search.stairs.scene().marks {
            // As many as there are marks.
            let _ = roles.push(self.search.stairs.role(m, &[], S::Shape::default()));
        }
        roles
    }

    /// Tells the observer each scatterer's role, and every explanation with its score.
    #[inline(never)]
    fn tell(&self, echoes: &[Echo], observer: &mut dyn Observer) {
        if !observer.listens() {
            return;
        }
        let scene = self.search.stairs.scene();
        let roles = self.roles();
        for (k, &echo) in (0..).zip(echoes) {
            let pair = scene.marks.iter().zip(&roles).find(|(m, _)| m.echo == k);
            let role = pair.map_or(Role::Stray, |(_, role)| *role);
            observer.event(Event::Scatterer(&Scatterer { echo, role }));
        }
        let winner = self.best.filter(|_| self.measured.is_some());
        observer.event(Event::Hypothesis(&Hypothesis {
            explanation: Explanation::NoStairs,
            faces: &[],
            score: 0.0,
            winner: winner.is_none(),
        }));
        for flight in &self.search.leaders {
            observer.event(Event::Hypothesis(&Hypothesis {
                explanation: S::explanation(flight.shape),
                faces: &flight.chain,
                score: flight.score,
                winner: winner.is_some_and(|w| w.chain.len() == flight.chain.len()),
            }));
        }
    }
}

/// Says what an answer vouches for: it is `ok` if that is the first metre at least.
fn promise(outcome: &mut Outcome, vouch: Vouch) {
    outcome.horizon_m = Some(vouch.horizon_m);
    outcome.confidence = Some(vouch.confidence);
    if vouch.horizon_m < LEAST_HORIZON_M {
        outcome.status = Status::Degraded;
        outcome.reasons.add(Reason::ShortHorizon);
    }
}
