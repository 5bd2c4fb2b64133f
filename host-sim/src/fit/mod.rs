//! Counts the verdict's hazards from scans with known truth.
//!
//! Each scan gives its cells up to the first one in which its answer goes wrong: what the estimator
//! knew of each, and whether it was that one. Their logistic regression is the hazard; a second one,
//! on other scenes, maps what the hazards add up to onto how often answers were right.

use crate::fit::portable::Portable as _;

pub mod logistic;
pub mod measurement;
pub mod portable;
pub mod sequences;
mod table;

use anyhow::Result;
use stairscan::answer::{DropEdge, Step};
use stairscan::config::Plane;
use stairscan::infer::trace::Cell;
use stairscan::infer::{HorizonAccumulator, Likelihood};
use stairscan::model::View;
use stairscan::observer::{Event, Observer};
use stairscan::params::generative::Generative;
use stairscan::params::hazard::{FEATURES, Weights, share_log_odds};
use stairscan::params::{Params, measured};
use stairscan::report::sentence::write_scan;
use stairscan::signal::echoes::Echo;
use stairscan::verdict::{MIN_FIRST_STEP, Outcome, Reason, ReasonEffect, Reasons};

use crate::answer::Answer;
use crate::inspect;
use crate::recording::{Recording, Truth};
use crate::replay::{self, Options, Scanned};
use crate::score::{self, at_most};
use logistic::LogisticFit;
use measurement::{Build, Sighting};

pub use table::write;

/// How far a feature's weight is taken to lie from 0 before anything is counted: standard deviation,
/// log-odds. Features are of the order of 1, and e³ is a strong effect.
const PRIOR_SIGMA: f64 = 3.0;

/// What one scan teaches.
#[derive(Clone, Debug)]
pub struct Lesson {
    /// The recording's name.
    pub name: String,
    /// What the mirror sweeps.
    pub plane: Plane,
    /// The cells of the way ahead, the nearest first …
    pub cells: Vec<Cell>,
    /// … whether the answer holds steps, …
    pub stairs: bool,
    /// … which of the cells is the first with an error, …
    pub wrong: Option<usize>,
    /// … and how far the horizon of an `ok` must reach, metres.
    pub reach_m: f32,
    /// Its steps.
    pub steps: Vec<Step>,
    /// Where it says that the ground ends.
    pub drop: Option<DropEdge>,
    /// Of each `MAYBE` the particles' share, and whether something stands there.
    pub maybes: Vec<(f32, bool)>,
    /// The answer as it is reported, and what is true.
    pub judged: (Answer, Truth),
}

/// Listens for cells, `MAYBE`s and echoes.
#[derive(Default)]
struct Listener {
    cells: Vec<Cell>,
    /// The particles' share of each `MAYBE`.
    maybes: Vec<f32>,
    echoes: Vec<Echo>,
}

impl Observer for Listener {
    fn event(&mut self, event: Event<'_>) {
        match event {
            Event::Cell(cell) => self.cells.push(*cell),
            Event::PossibleStep(maybe) => self.maybes.push(maybe.probability),
            Event::Scatterer(scatterer) => self.echoes.push(scatterer.echo),
            _ => {}
        }
    }
}

/// The first scan of a recording that has a truth and is no `fault`, seen by an estimator with the
/// measurement model `g`.
///
/// # Errors
/// Names what in the recording no scan can be made of.
fn witness<R>(
    recording: &Recording,
    g: &'static Generative,
    look: impl Fn(&Scanned<'_>, Truth, Outcome, Listener) -> Result<R>,
) -> Result<Option<R>> {
    let options = Options {
        scans: Some(1),
        ..Options::default()
    };
    let mut seen = None;
    replay::answers(recording, &options, |scanned| {
        let Some(truth) = scanned.recording().meta.truth else {
            return;
        };
        if scanned.answer.is_fault() {
            return;
        }
        let mut listener = Listener::default();
        let estimator = Likelihood::new().measuring(g);
        let scan = scanned.answer.scan.scan;
        let (map, config) = (scanned.pipeline.map(), scanned.config);
        let mut outcome =
            inspect::repeat_with(estimator, map, config, scan, &scanned.drive, &mut listener);
        outcome.answer.link();
        seen = Some(look(scanned, truth, outcome, listener));
    })?;
    seen.transpose()
}

/// What the first scan of a recording shows of the measurement model; nothing if it is a `fault` or has no truth.
///
/// # Errors
/// Names what in the recording no scan can be made of.
pub fn sighting(recording: &Recording, build: Option<Build>) -> Result<Option<Sighting>> {
    witness(
        recording,
        &measured::MODEL,
        |scanned, truth, _, listener| {
            let map = scanned.pipeline.map();
            let geometry = *map.geometry();
            Ok(Sighting {
                name: recording.name.clone(),
                echoes: listener.echoes,
                geometry,
                view: View::of(map),
                truth,
                build,
            })
        },
    )
}

/// What the first scan of a recording teaches under the measurement model `g`; nothing if it is a
/// `fault` or has no truth.
///
/// # Errors
/// Names what in the recording no scan can be made of.
pub fn lesson(recording: &Recording, g: &'static Generative) -> Result<Option<Lesson>> {
    witness(recording, g, |scanned, truth, outcome, listener| {
        let answer = answer_of(&recording.name, &outcome)?;
        let wrong = first_wrong(&answer, &truth, &listener.cells);
        let stands = score::maybes(&answer, &truth).into_iter().map(|m| m.so);
        Ok(Lesson {
            name: recording.name.clone(),
            plane: scanned.config.mount.plane.first(),
            cells: listener.cells,
            stairs: !answer.steps.is_empty(),
            wrong,
            reach_m: reach_m(outcome.reasons(), outcome.answer.drop),
            steps: outcome.answer.steps.to_vec(),
            drop: outcome.answer.drop,
            maybes: listener.maybes.into_iter().zip(stands).collect(),
            judged: (answer, truth),
        })
    })
}

/// Whether nothing but its horizon decides on an answer: no threshold makes an `ok` of one that no second sweep has
/// confirmed, say. A reason may stand beside an `ok` by its effect in the table; a farther horizon takes away
/// `short-horizon`.
fn may_be_ok(reasons: Reasons) -> bool {
    reasons.iter().all(|reason| {
        let may = |effect| reason.effects().contains(&effect);
        let word = may(ReasonEffect::Info) && !may(ReasonEffect::Degraded);
        word || reason == Reason::ShortHorizon
    })
}

/// How far the horizon of an `ok` must reach, metres: farther than any where something else keeps the answer from it.
fn reach_m(reasons: Reasons, drop: Option<DropEdge>) -> f32 {
    if !may_be_ok(reasons) {
        return f32::INFINITY;
    }
    let edge = drop.map(|drop| drop.nearest_m()).filter(|edge| *edge > 0.0);
    edge.map_or(OK_REACH_M, |edge| edge.min(OK_REACH_M))
}

/// An outcome as it is reported.
fn answer_of(name: &str, outcome: &Outcome) -> Result<Answer> {
    let mut sentences = Vec::new();
    write_scan((1, 0), 0, outcome, |line| {
        sentences.push(line.trim_end().to_owned())
    });
    Answer::parse(name, sentences)
}

/// The first cell in which an answer goes wrong for good. Where a cell ends between a step and its
/// place in the answer, the one counts and the other does not, and that is no error of the answer: no
/// horizon ends there.
fn first_wrong(answer: &Answer, truth: &Truth, cells: &[Cell]) -> Option<usize> {
    let right = |cell: &Cell| !score::wrong_up_to(answer, truth, cell.end_m.into());
    let first = cells.iter().rposition(right).map_or(0, |last| last + 1);
    (first < cells.len()).then_some(first)
}

/// The hazards of one plane, with the standard errors of their weights.
pub fn hazards(lessons: &[&Lesson]) -> LogisticFit {
    let mut rows = Vec::new();
    for lesson in lessons {
        let until = lesson.wrong.map_or(lesson.cells.len(), |k| k + 1);
        for (k, cell) in lesson.cells.iter().take(until).enumerate() {
            let features = cell.features.iter().map(|&f| f64::from(f)).collect();
            rows.push((features, lesson.wrong == Some(k)));
        }
    }
    logistic::fit(&rows, FEATURES, PRIOR_SIGMA)
}

/// Log-odds of being right that the hazards give for each cell of a lesson, and whether the answer
/// was right up to there.
fn odds(lesson: &Lesson, weights: &Weights) -> Vec<(f64, bool)> {
    let mut log_right = 0.0;
    let cells = lesson.cells.iter().enumerate().map(|(k, cell)| {
        log_right += f64::from(weights.log_survival(&cell.features));
        let log_wrong = (-log_right.exp_m1_portable())
            .max(f64::from(f32::EPSILON))
            .ln_portable();
        (log_right - log_wrong, lesson.wrong.is_none_or(|w| w > k))
    });
    cells.collect()
}

/// An `ok` reaches at least this far, metres: design contract; and what rounding leaves of it.
const OK_REACH_M: f32 = 0.999;

/// What a threshold of probability does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    /// The probability.
    pub from: f32,
    /// Answers that it makes `ok`.
    pub ok: usize,
    /// Of these, those that are wrong up to their horizon.
    pub wrong: usize,
}

/// Largest share of `ok` answers that may be wrong up to their horizon: the promise.
const RISK: f64 = 0.01;
/// Probability with which a threshold that does not keep the promise may be taken for one that does.
const ERROR: f64 = 0.05;
/// Answers that the first threshold of each sequence of tests makes `ok`, chosen by number alone: with more of them one
/// unlucky answer decides less, with fewer a type that is seldom `ok` has a test at all. Each sequence has its share of
/// [`ERROR`].
const FIRST_TESTED: [usize; 3] = [800, 1600, 3200];
/// By how many `ok` answers the thresholds of a sequence differ: closer ones add hardly any evidence, but each of them may
/// end the sequence.
const MORE_TESTED: usize = 200;

/// An answer that a threshold makes `ok` or not.
struct Course<'a> {
    /// How far the horizon of an `ok` must reach, metres.
    reach_m: f32,
    /// Its steps.
    steps: &'a [Step],
    /// Where it says that the ground ends.
    drop: Option<DropEdge>,
    /// Of each cell: where it ends, metres, and the probability that the answer is right up to there.
    cells: Vec<(f32, f32)>,
    /// The answer as it is reported, and what is true.
    judged: &'a (Answer, Truth),
}

impl Course<'_> {
    /// The horizon with a threshold, metres; `None` if the answer is not `ok`.
    fn horizon_m(&self, ok_from: f32) -> Option<f32> {
        let mut reach = HorizonAccumulator::new(self.steps, self.drop);
        for &(end_m, right) in &self.cells {
            reach.add_cell(end_m, right, ok_from);
        }
        let horizon_m = reach.horizon_m(&Params::DEFAULT);
        let long = horizon_m >= self.reach_m && reach.first_step() >= MIN_FIRST_STEP;
        long.then_some(horizon_m)
    }

    /// Whether something up to a horizon, metres, is wrong, or stairs are told where there are none.
    fn is_wrong(&self, horizon_m: f32) -> bool {
        let (answer, truth) = self.judged;
        score::wrong_up_to(answer, truth, horizon_m.into()) || score::false_stairs(answer, truth)
    }
}

/// Ends of cells, each with the probability that all of them are right up to there, from the logarithms of the
/// probabilities that nothing goes wrong in each, and `probability` of what these add up to.
fn rights(
    cells: impl Iterator<Item = (f32, f32)>,
    probability: impl Fn(f32) -> f32,
) -> Vec<(f32, f32)> {
    let mut log_right = 0.0;
    cells
        .map(|(end_m, log_survival)| {
            log_right += log_survival;
            (end_m, probability(log_right))
        })
        .collect()
}

/// The threshold of `ok` by learn-then-test with fixed sequences from several starts (Angelopoulos, Bates, Candès, Jordan,
/// Lei 2021): from the strictest threshold, in thousandths, that leaves as many answers as [`FIRST_TESTED`] says downwards,
/// by [`MORE_TESTED`] answers at a time, each is tested against the hypothesis that more than [`RISK`] of its `ok` answers
/// are wrong, up to the first that is not rejected. The threshold is the lowest rejected one of all sequences; 2, which no
/// answer has, where there is none.
fn least(courses: &[Course<'_>]) -> Threshold {
    let judge = |from: f32| {
        let ok = courses
            .iter()
            .filter_map(|course| Some((course, course.horizon_m(from)?)));
        Threshold {
            from,
            ok: ok.clone().count(),
            wrong: ok.filter(|(course, end)| course.is_wrong(*end)).count(),
        }
    };
    let strictest_first = (800..1000_u16).rev();
    let judged: Vec<_> = strictest_first
        .map(|thousandths| judge(f32::from(thousandths) / 1000.0))
        .collect();
    let error = ERROR / FIRST_TESTED.len() as f64;
    let lowest = |first: usize| {
        let numbers = (first..=courses.len()).step_by(MORE_TESTED);
        let tested = numbers.map_while(|least| judged.iter().find(|t| t.ok >= least));
        let kept = tested.take_while(|t| at_most(t.wrong, t.ok, RISK) <= error);
        kept.last().copied()
    };
    let kept = FIRST_TESTED.into_iter().filter_map(lowest);
    kept.min_by(|a, b| a.from.total_cmp(&b.from))
        .unwrap_or(Threshold {
            from: 2.0,
            ok: 0,
            wrong: 0,
        })
}

/// The threshold of `ok` for answers without steps, or with steps, from scans that the weights were not counted from.
pub fn threshold(lessons: &[&Lesson], weights: &Weights, stairs: bool) -> Threshold {
    let of_type = lessons.iter().filter(|lesson| lesson.stairs == stairs);
    let courses: Vec<_> = of_type.map(|lesson| course(lesson, weights)).collect();
    least(&courses)
}

fn course<'a>(lesson: &'a Lesson, weights: &Weights) -> Course<'a> {
    let cells = lesson.cells.iter();
    let cells = cells.map(|cell| (cell.end_m, weights.log_survival(&cell.features)));
    Course {
        reach_m: lesson.reach_m,
        steps: &lesson.steps,
        drop: lesson.drop,
        cells: rights(cells, |log_right| {
            weights.probability(log_right, lesson.stairs)
        }),
        judged: &lesson.judged,
    }
}

/// Slope and offset that take the hazards' log-odds to how often answers were right.
pub fn calibration(lessons: &[&Lesson], weights: &Weights) -> LogisticFit {
    let pairs = lessons.iter().flat_map(|lesson| odds(lesson, weights));
    let rows: Vec<(Vec<f64>, bool)> = pairs.map(|(x, right)| (vec![x, 1.0], right)).collect();
    logistic::fit(&rows, 2, PRIOR_SIGMA)
}

/// Slope and offset that take the particles' share of a `MAYBE` to how often something stands there.
pub fn maybes(lessons: &[&Lesson]) -> LogisticFit {
    let all = lessons.iter().flat_map(|lesson| &lesson.maybes);
    let rows: Vec<(Vec<f64>, bool)> = all
        .map(|&(share, stands)| (vec![share_log_odds(share).into(), 1.0], stands))
        .collect();
    logistic::fit(&rows, 2, PRIOR_SIGMA)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_sequence_of_tests_begins_where_wrong_answers_may_pass() {
        let error = ERROR / FIRST_TESTED.len() as f64;
        for (first, pass) in FIRST_TESTED.into_iter().zip([2, 7, 20]) {
            assert!(at_most(pass, first, RISK) <= error, "{first}");
            assert!(at_most(pass + 1, first, RISK) > error, "{first}");
        }
    }

    #[test]
    fn hints_stand_beside_an_ok_and_what_a_doubt_takes_it_from_is_not_counted() {
        let hints = Reasons::NONE
            .with(Reason::CloseRival)
            .with(Reason::ShortHorizon);
        assert!(reach_m(Reasons::NONE, None) < 1.0 && reach_m(hints, None) < 1.0);
        let words = [
            Reason::InferredStep,
            Reason::WeakEchoes,
            Reason::BlockedView,
            Reason::IrregularStep,
            Reason::SceneChanged,
        ];
        for word in words {
            assert!(reach_m(hints.with(word), None) < 1.0, "{}", word.as_str());
        }
        for doubt in [
            Reason::Unconfirmed,
            Reason::Moving,
            Reason::Mount,
            Reason::MotionInput,
        ] {
            assert!(
                reach_m(hints.with(doubt), None) > 100.0,
                "{}",
                doubt.as_str()
            );
        }
    }
}
