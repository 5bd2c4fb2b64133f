//! The default estimator: takes in the echoes of one scan, returns the staircase or the ground that explains them
//! best.
//!
//! Going up, a search proposes flights. They and their variants are weighted by the measurement model of
//! [`crate::model`] and become particles. Going down, chains of levels are proposed and weighted, without variants. In
//! both cases the answer is the outline of the highest posterior probability. In the order of the data:
//!
//! | module | content |
//! |---|---|
//! | `propose` | the search: flights that may explain the echoes, each with a score; proposals only |
//! | `bases` | `Posterior` and its initial hypotheses: refined flights, a ramp, level ground |
//! | `readings` | measurements of each riser's place and height from its own echoes |
//! | [`gauss`] | Gaussian mixture over the levels of a flight of which at most one riser or tread is irregular |
//! | `refine` | fit of a hypothesis's levels, places and overhang to its echoes |
//! | `variants` | variants of a hypothesis: a riser more, fewer, irregular; on bare ground a step, a box, a drop |
//! | `judgement` | the other methods of `Posterior`: likeliest outline, log-odds of errors, possible steps |
//! | `inference` | the answer going up: the modules above in at most two rounds |
//! | `nosings` | distance of each nosing, and the common overhang |
//! | `dimensions` | steps with their standard deviations |
//! | `support`, `horizon` | evidence for each step, reasons that an answer is uncertain, and the horizon |
//!
//! Beside it: [`crate::past`], the evidence of earlier scans; [`crate::model::cloud`], the particles;
//! [`crate::observer::trace`], the intermediate results for an observer.
//!
//! This file joins them: [`Likelihood`] takes in the rows of a scan and makes its answer.

// The stages are `inline(never)`. The stack has 18 KB: merged into one function, the stages would hold the working
// memory of all of them at the same time.

mod bases;
mod depth;
mod dimensions;
pub mod gauss;
mod horizon;
mod inference;
mod judgement;
mod nosings;
mod propose;
mod readings;
mod refine;
mod support;
mod variants;

#[cfg(test)]
mod tests;

use crate::answer::Answer;
use crate::config::{Config, Plane};
use crate::estimator::{Estimator, MappedScan};
use crate::math;
use crate::model::chart::Chart;
pub use crate::model::cloud::{
    CELL_M, CELLS, Cloud, FIRST_END_M, MIN_LOG_ODDS, PARTICLES, ReportedAnswer,
};
use crate::model::lines::DEPTHS_M;
use crate::model::surfaces::Recursions;
use crate::model::treads::Descending;
use crate::model::{Surfaces, View};
use crate::motion::{Drive, MotionCompensation, Retention, SweepComparison};
use crate::mount::{Calibration, GroundEvidence, online};
use crate::observer::trace::{Candidate, Explanation, Role, Scatterer, Stage};
use crate::observer::{Event, Observer};
pub use crate::params::Params;
use crate::params::fitted_for;
use crate::params::generative::Generative;
use crate::params::measured;
use crate::past::{CarriedOdds, History};
use crate::signal::echoes::{Collector, Echo, Echoes, Lobes};
use crate::signal::grid::{Geometry, PolarMap};
use crate::verdict::{Assessment, Reason, Reasons, Validity};
use bases::Posterior;
use dimensions::Measured;
pub use horizon::HorizonAccumulator;
use horizon::HorizonInput;
use inference::Inferred;
use judgement::AnswerProbabilities;
use propose::ascending::Ascending;
use propose::roles::Roles;
use propose::scene::{Mark, Scene};
use propose::search::{Beam, Search};
use propose::stairs::FlightShape;
pub use readings::{Face, Readings};
pub use refine::refine;
pub use variants::{Hypothesis, Variants, weight};

/// The default estimator. Its memory holds the row collector during a scan, and after the last row, in the same
/// place, the working memory of each further stage.
#[derive(Debug)]
pub struct Likelihood {
    phase: Phase,
    echoes: Echoes,
    sweeps: SweepComparison,
    params: &'static Params,
    posterior: Posterior,
    /// Whether the posterior decides, rather than the search alone.
    particles: bool,
}

#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "the phases follow each other in the same memory"
)]
enum Phase {
    Rows(Collector),
    Ground(Recursions),
    Up(Beam),
    Down(Descending),
}

impl Default for Likelihood {
    fn default() -> Self {
        Self::new()
    }
}

impl Likelihood {
    /// Returns an estimator before the first scan.
    pub const fn new() -> Self {
        Self::with(&Params::DEFAULT)
    }

    /// Returns an estimator with other tuned numbers than the default ones, for experiments.
    pub const fn with(params: &'static Params) -> Self {
        Self {
            phase: Phase::Rows(Collector::new()),
            echoes: Echoes::new(),
            sweeps: SweepComparison::new(),
            params,
            posterior: Posterior::new(&measured::MODEL),
            particles: true,
        }
    }

    /// Replaces the parameters of the measurement model of the depth plane, so that `cargo sim` can fit the numbers
    /// that depend on it.
    pub const fn measuring(mut self, measured: &'static Generative) -> Self {
        self.posterior.measure(measured);
        self
    }

    /// Detects and returns the echoes of a finished scan of a standing chair, the strongest first. It is called in
    /// place of [`Estimator::conclude`], and returns none after that.
    pub fn echoes(&mut self, map: &PolarMap, config: &Config) -> &[Echo] {
        self.echoes.clear();
        if let Phase::Rows(collector) = &mut self.phase {
            let echoes = &mut self.echoes;
            collector.finish(map, config, self.params, &Drive::STANDING, echoes);
        }
        &self.echoes
    }

    /// Switches the posterior off, to measure its contribution. The search's best flight is the answer, all cells
    /// have equal log-odds of an error, and nothing else is reported as possible.
    pub const fn without_particles(mut self) -> Self {
        self.particles = false;
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

    fn conclude(
        &mut self,
        scan: &MappedScan<'_>,
        mut past: Option<&mut History>,
        observer: &mut dyn Observer,
        answer: &mut Answer,
    ) -> Option<Assessment> {
        let Phase::Rows(collector) = &mut self.phase else {
            return None;
        };
        let MappedScan {
            map,
            config,
            number,
            drive,
        } = *scan;
        let p = self.params;
        let echoes = &mut self.echoes;
        let noise = collector.finish(map, config, p, drive, echoes);
        let agreement = self.sweeps.compare(map, config, drive, echoes);
        let instrument = (config.mount, config.radar);
        let moved_m = agreement.moved_m(drive);
        let moved_m = moved_m.filter(|_| drive.memory == Retention::Kept);
        let moved_during_scan_m = drive.known().map_or(0.0, |track| track.end().travel_m);
        if let Some(past) = &mut past {
            past.begin(
                number,
                instrument,
                View::of(map),
                moved_m,
                moved_during_scan_m,
            );
        }
        observer.event(Event::Noise(noise));
        observer.event(Event::Done(Stage::Echoes));
        let geometry = map.geometry();
        let floor = match geometry.plane {
            Plane::Height => None,
            Plane::Depth => Some(GroundEvidence::of(echoes, geometry.bin_m, p)),
        };
        if let Some(floor) = floor {
            observer.event(Event::Floor(floor));
        }
        let level = floor.is_none_or(|floor| floor.in_place(p));
        // The row profiles shift in range while the chair moves.
        let still = moved_during_scan_m.abs() < p.beam_still_m && geometry.plane == Plane::Depth;
        let lobes = still.then(|| Lobes::of(echoes, geometry, p)).flatten();
        if let Some(lobes) = lobes {
            observer.event(Event::Lobes(lobes));
        }
        let assessed = match geometry.plane {
            Plane::Depth => {
                let found = online::calibrate(echoes, geometry, p);
                observer.event(Event::Calibration(found));
                self.posterior.set_echoes(echoes, map);
                let chart = Chart {
                    map,
                    noise,
                    bias_rad: found.bias_rad,
                    height_m: found.height_m,
                    ride: MotionCompensation::of(drive, &config.radar),
                };
                let surfaces = &mut self.posterior.model.surfaces;
                evaluate_ground_line(&chart, &mut self.phase, surfaces);
                self.phase = Phase::Up(Beam::new());
                let Phase::Up(memory) = &mut self.phase else {
                    return None;
                };
                let posterior = (&mut self.posterior, self.particles);
                let off = drive.memory == Retention::Off;
                let past = past.as_deref_mut().filter(|_| !off);
                let parts = (memory, posterior, past);
                let firm = floor.is_some_and(|floor| floor.confirmed(p));
                ascend(
                    echoes,
                    (geometry, found, firm),
                    p,
                    parts,
                    (observer, answer),
                )
            }
            Plane::Height => {
                self.phase = Phase::Down(Descending::new(&self.posterior.model.g.treads));
                let Phase::Down(memory) = &mut self.phase else {
                    return None;
                };
                let posterior = &mut self.posterior;
                posterior.descend(memory, View::of(map), echoes);
                descend(echoes, geometry, p, (memory, posterior), (observer, answer))
            }
        };
        observer.event(Event::Done(Stage::Dimensions));
        let mounting_off = assessed.mounting_off || !level;
        let lobe_width_off = lobes.is_some_and(|lobes| !lobes.fit(p));
        let echo_found = echoes.iter().any(|e| e.snr_db >= p.sure_echo_db);
        let mut weaknesses = assessed.weaknesses;
        if past.as_ref().is_some_and(|past| past.changed()) {
            weaknesses.add(Reason::SceneChanged);
        }
        let agreement =
            agreement.confirmed(past.as_ref().is_some_and(|past| past.confirms_motion()));
        let placed = !mounting_off && !lobe_width_off && agreement.placed();
        let kept = echo_found && placed && geometry.plane == Plane::Depth;
        let forget = !kept || drive.memory == Retention::Off;
        if let Some(past) = past.as_mut().filter(|_| forget) {
            past.clear();
        }
        Some(Assessment {
            echo_found,
            valid: Some(assessed.valid),
            drop_m: answer.drop.map(|drop| drop.nearest_m()),
            mounting_off,
            lobe_width_off,
            agreement,
            weaknesses,
        })
    }
}

/// Validity of an answer, and the reasons that it is uncertain.
struct AnswerQuality {
    /// Horizon and confidence.
    valid: Validity,
    /// Whether the calibration or the first corner contradicts the configured mounting.
    mounting_off: bool,
    /// Reasons that the answer is uncertain; they are reported, and do not prevent `ok`.
    weaknesses: Reasons,
}

/// Evaluates the power along the ground line, in the memory that the search uses next, and writes its log-likelihood
/// ratios to `surfaces`.
#[inline(never)]
fn evaluate_ground_line(chart: &Chart<'_>, phase: &mut Phase, surfaces: &mut Surfaces) {
    *phase = Phase::Ground(Recursions::new());
    if let Phase::Ground(ground) = phase {
        ground.lines.look(chart);
        ground.weigh(surfaces, DEPTHS_M.len());
    }
}

/// Finds the best stairs going up, if they explain the echoes better than any alternative. `floor_confirms_mount` is
/// whether the floor confirms the configured mounting; where it does not, the stairs' first corner must.
#[inline(never)]
fn ascend(
    echoes: &[Echo],
    (geometry, found, floor_confirms_mount): (&Geometry, Calibration, bool),
    p: &Params,
    (memory, (posterior, particles), mut past): (
        &mut Beam,
        (&mut Posterior, bool),
        Option<&mut History>,
    ),
    (observer, answer): (&mut dyn Observer, &mut Answer),
) -> AnswerQuality {
    let mut scene = Scene::new(geometry.mount_height_m, p);
    scene.risers(echoes);
    let scene = &scene;
    let stairs = Ascending::new(scene);
    let mut search = Search::new(&stairs);
    let best = search.best(memory);
    observer.event(Event::Done(Stage::Search));
    let mut inferred = Inferred::default();
    if particles {
        let known = (&mut *posterior, past.as_deref_mut());
        inferred.infer(&search, best, known, found.bias_sigma_rad);
        posterior.report(observer);
    } else {
        inferred.search_alone(&search, best, posterior, found.bias_sigma_rad);
    }
    if let Some(past) = &mut past {
        let steps = inferred.measured.as_mut();
        past.combine(steps.map_or(&mut [], |m| m.answer.steps.as_mut_slice()));
    }
    let roles = match inferred
        .measured
        .as_ref()
        .filter(|m| !m.supports.is_empty())
    {
        Some(measured) => measured.roles.clone(),
        None => bare(&search),
    };
    report_scatterers(echoes, scene, &roles, observer);
    report_flights(&search, &inferred, observer);
    let ended = Conclusion {
        scene,
        roles,
        margins: Margins::of(&search, &inferred),
        open: inferred.flight.as_ref().is_some_and(|b| b.shape.open),
        measured: &inferred.measured,
        geometry,
        probabilities: &inferred.belief,
        calibration_excessive: !found.fits(p),
        floor_confirms_mount,
        surfaces: &posterior.model.surfaces,
    };
    ended.conclude(past.map(|past| &mut past.carried_odds), observer, answer)
}

/// Returns the role of each mark (an echo in the search) on bare ground, in the marks' order.
fn bare(search: &Search<'_, '_>) -> Roles {
    let mut roles = Roles::new();
    for m in &search.stairs.scene().marks {
        // Cannot fail: there is one role for each mark.
        let _ = roles.push(search.stairs.role(m, &[], FlightShape::default()));
    }
    roles
}

/// Finds the likeliest stairs going down, or level ground, and writes the answer.
#[inline(never)]
fn descend(
    echoes: &[Echo],
    geometry: &Geometry,
    p: &Params,
    (model, posterior): (&mut Descending, &mut Posterior),
    (observer, answer): (&mut dyn Observer, &mut Answer),
) -> AnswerQuality {
    let mut scene = Scene::new(geometry.mount_height_m, p);
    scene.treads(echoes);
    observer.event(Event::Done(Stage::Search));
    let mut belief = AnswerProbabilities::default();
    posterior.evaluate(None, None, &mut belief);
    let likeliest = posterior.likeliest(None);
    let found = likeliest.staircase;
    let measured = found
        .as_ref()
        .map(|s| dimensions::descending(model, &scene, s));
    if let Some(reported) = measured.as_ref().zip(found.as_ref()) {
        posterior.evaluate(Some(reported), None, &mut belief);
    }
    posterior.report(observer);
    let roles = match &measured {
        Some(measured) => measured.roles.clone(),
        None => dimensions::ground_roles(&scene, model),
    };
    report_scatterers(echoes, &scene, &roles, observer);
    posterior.report_descents(&likeliest, observer);
    let ended = Conclusion {
        scene: &scene,
        roles,
        margins: Margins {
            search: likeliest.margin,
            posterior: if measured.is_some() {
                likeliest.margin
            } else {
                likeliest.odds
            },
        },
        open: false,
        measured: &measured,
        geometry,
        probabilities: &belief,
        calibration_excessive: false,
        floor_confirms_mount: true,
        surfaces: &Surfaces::NOTHING,
    };
    ended.conclude(None, observer, answer)
}

/// Margins of the answer over its alternatives.
struct Margins {
    /// Margin by the search, nats. With stairs: their score less that of the runner-up. Without stairs: score of the
    /// best flight, where ground without stairs has the score 0.
    search: f32,
    /// Margin by the posterior, nats. With stairs: to the runner-up outline. Without stairs: log-odds of the
    /// likeliest stairs against ground without stairs.
    posterior: f32,
}

impl Margins {
    /// Returns the margins of an answer going up.
    fn of(search: &Search<'_, '_>, inferred: &Inferred) -> Self {
        let measured = inferred.measured.as_ref();
        let stairs = measured.is_some_and(|m| !m.supports.is_empty());
        // A flight that was accepted and then found to be a box or a threshold is not an alternative.
        let flight = inferred
            .flight
            .as_ref()
            .filter(|_| stairs || measured.is_none());
        let Some(rival) = flight else {
            return Self {
                search: f32::NEG_INFINITY,
                posterior: f32::NEG_INFINITY,
            };
        };
        let others = if stairs {
            search.runner_up_score(rival.chain.len())
        } else {
            0.0
        };
        Self {
            search: rival.score - others,
            posterior: if stairs {
                inferred.margin
            } else {
                inferred.odds
            },
        }
    }
}

/// Reports each scatterer's role to the observer.
#[inline(never)]
fn report_scatterers(
    echoes: &[Echo],
    scene: &Scene<'_>,
    roles: &Roles,
    observer: &mut dyn Observer,
) {
    if !observer.listens() {
        return;
    }
    for (k, &echo) in (0..).zip(echoes) {
        let pair = scene.marks.iter().zip(roles).find(|(m, _)| m.echo == k);
        let role = pair.map_or(Role::Stray, |(_, role)| *role);
        observer.event(Event::Scatterer(&Scatterer { echo, role }));
    }
}

/// Reports every flight of the search with its score to the observer.
#[inline(never)]
fn report_flights(search: &Search<'_, '_>, inferred: &Inferred, observer: &mut dyn Observer) {
    if !observer.listens() {
        return;
    }
    let winner = inferred
        .flight
        .as_ref()
        .filter(|_| inferred.measured.is_some());
    observer.event(Event::Candidate(&Candidate {
        explanation: Explanation::NoStairs,
        faces: &[],
        score: 0.0,
        winner: winner.is_none(),
    }));
    for flight in &search.leaders {
        observer.event(Event::Candidate(&Candidate {
            explanation: Explanation::Up {
                rise_m: flight.shape.rise_m,
                open: flight.shape.open,
            },
            faces: &flight.chain,
            score: flight.score,
            winner: winner.is_some_and(|w| w.chain.len() == flight.chain.len()),
        }));
    }
}

/// The results of a finished inference, up or down, from which the answer is written.
struct Conclusion<'s> {
    scene: &'s Scene<'s>,
    /// Role of each mark under the measured stairs, or on bare ground.
    roles: Roles,
    margins: Margins,
    /// Whether the treads are open (no risers).
    open: bool,
    /// The measured steps; none where ground without stairs is likelier.
    measured: &'s Option<Measured>,
    geometry: &'s Geometry,
    probabilities: &'s AnswerProbabilities,
    /// Whether calibration removed a larger error than a correct mounting can have.
    calibration_excessive: bool,
    /// Whether the floor confirms the configured mounting.
    floor_confirms_mount: bool,
    /// Log-likelihood ratios of a drop or a riser to ground that goes on, from the power along the ground's line.
    surfaces: &'s Surfaces,
}

impl Conclusion<'_> {
    /// Writes the answer, of measured stairs or of ground without stairs, and returns its quality.
    #[inline(never)]
    fn conclude(
        self,
        outlook: Option<&mut CarriedOdds>,
        observer: &mut dyn Observer,
        answer: &mut Answer,
    ) -> AnswerQuality {
        let scene = self.scene;
        let p = scene.params;
        let mounting_off =
            self.calibration_excessive || !self.floor_confirms_mount && self.corner_off();
        let mut supports = heapless::Vec::new();
        let mut weaknesses = Reasons::NONE;
        if let Some(measured) = self.measured {
            answer.clone_from(&measured.answer);
            supports.clone_from(&measured.supports);
            if measured.may_be_step {
                weaknesses.add(Reason::CloseRival);
            }
        }
        let margin = self.margins.search;
        if supports.is_empty() {
            let strongest_db = scene.marks.iter().map(|m| m.snr_db).fold(0.0, math::max);
            weaknesses = weaknesses.and(support::reasons_without_steps(
                self.margins.posterior,
                strongest_db,
                p,
            ));
        } else {
            let pairs = scene.marks.iter().zip(&self.roles);
            let against = pairs.filter(|(_, role)| role.contradicts()).map(|(m, _)| m);
            weaknesses = weaknesses.and(support::reasons(
                &answer.steps,
                self.margins.posterior,
                &supports,
                against,
                p,
            ));
        }
        answer.link();
        let ground = HorizonInput {
            scene,
            roles: &self.roles,
            steps: &answer.steps,
            supports: &supports,
            margin,
            open: self.open,
            geometry: self.geometry,
            error_log_odds: self.probabilities.error_log_odds,
            surfaces: self.surfaces,
            drop: self.probabilities.drop,
        };
        let valid = horizon::validity(&ground, outlook, &mut |cell| {
            if observer.listens() {
                observer.event(Event::Cell(cell));
            }
        });
        answer
            .possible_steps
            .clone_from(&self.probabilities.possible_steps);
        let map = fitted_for(self.geometry.plane).maybe_map;
        for maybe in &mut answer.possible_steps {
            if observer.listens() {
                observer.event(Event::PossibleStep(maybe));
            }
            maybe.probability = map.calibrated(maybe.probability);
        }
        answer.drop = self.probabilities.drop;
        AnswerQuality {
            valid,
            mounting_off,
            weaknesses,
        }
    }

    /// Whether the corner of floor and first riser, where a reliable one is found, lies above or below the floor.
    #[inline(never)]
    fn corner_off(&self) -> bool {
        let Some(measured) = self.measured else {
            return false;
        };
        let scene = self.scene;
        let p = scene.params;
        if !p.rules.corner_astray {
            return false;
        }
        let Some(first) = measured.answer.steps.first() else {
            return false;
        };
        let foot = |(m, role): &(&Mark, &Role)| {
            let there = (m.x_m - first.distance_m).abs() < p.foot_reach_m;
            let low = m.y_m < 0.5 * first.height_m;
            let foot = matches!(role, Role::Corner | Role::Inside);
            foot && there && low && m.snr_db > p.corner_astray_db
        };
        let feet = scene.marks.iter().zip(&measured.roles).filter(foot);
        let foot = feet.reduce(|a, b| if b.0.snr_db > a.0.snr_db { b } else { a });
        foot.is_some_and(|(m, _)| m.y_m.abs() > p.corner_astray_rad * m.range_m)
    }
}
