//! Fits the weights of the hazards and the thresholds of `ok` to scans with ground truth.
//!
//! Each scan contributes its way cells (10 cm of the way ahead each) up to and including the first one in which its
//! answer is wrong: the estimator's features of each cell, and whether it is that first wrong one. Their logistic
//! regression is the hazard. A second logistic regression, on other scenes, calibrates the accumulated hazards
//! against the observed share of correct answers.

use crate::fit::portable::Portable as _;

pub mod logistic;
pub mod measurement;
pub mod portable;
pub mod sequences;
mod table;

use anyhow::Result;
use stairscan::answer::{DropEdge, Step};
use stairscan::config::Plane;
use stairscan::infer::{HorizonAccumulator, Likelihood};
use stairscan::model::View;
use stairscan::observer::trace::Cell;
use stairscan::observer::{Event, Observer};
use stairscan::params::generative::Generative;
use stairscan::params::hazard::{FEATURES, Weights, share_log_odds};
use stairscan::params::{Params, measured};
use stairscan::report::sentence::{ScanId, write_scan};
use stairscan::signal::echoes::Echo;
use stairscan::verdict::{MIN_FIRST_STEP, Outcome, Reason, ReasonEffect, Reasons};

use host_sim::answer::Answer;
use host_sim::inspect;
use host_sim::recording::{Recording, Truth};
use host_sim::replay::{self, Options, Scanned};
use host_sim::score::{self, at_most};
use logistic::LogisticFit;
use measurement::{Build, MeasurementSample};

pub use table::write;

/// Standard deviation of the Gaussian prior of a feature's weight around 0, log-odds. Features are of the order of 1,
/// and e³ is a strong effect.
const PRIOR_SIGMA: f64 = 3.0;

/// Training sample of one scan for hazards, calibration and thresholds.
#[derive(Clone, Debug)]
pub struct TrainingSample {
    /// Name of the scan's recording.
    pub name: String,
    /// Plane that the mirror sweeps.
    pub plane: Plane,
    /// Way cells (10 cm of the way ahead each), nearest first.
    pub cells: Vec<Cell>,
    /// Whether the answer reports steps.
    pub stairs: bool,
    /// Index of the first way cell from which on the answer stays wrong; `None` if it is correct at the end.
    pub wrong: Option<usize>,
    /// Horizon that the answer needs to be `ok`, metres; infinite if another reason prevents `ok`.
    pub reach_m: f32,
    /// Reported steps.
    pub steps: Vec<Step>,
    /// Reported drop edge.
    pub drop: Option<DropEdge>,
    /// For each `MAYBE` (possible step): its share of the particles' weight, and whether there is a true step.
    pub maybes: Vec<(f32, bool)>,
    /// The reported answer and the ground truth.
    pub judged: (Answer, Truth),
}

/// Observer that collects a scan's way cells, `MAYBE`s and echoes.
#[derive(Default)]
struct Listener {
    cells: Vec<Cell>,
    /// Share of the particles' weight that each `MAYBE` (possible step) has, in the order of the events.
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

/// Evaluates the first scan of a recording with the measurement model `g` and returns the result of `look` for scan,
/// ground truth, outcome and observed data; `None` if the recording has no ground truth or the status is `fault`.
///
/// # Errors
/// The recording cannot be scanned; the message names the cause.
fn first_scan_with<R>(
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
        let mut outcome = inspect::repeat_with(estimator, scanned, &mut listener);
        outcome.answer.link();
        seen = Some(look(scanned, truth, outcome, listener));
    })?;
    seen.transpose()
}

/// Returns the first scan of a recording as a sample for the measurement model; `None` if it is a `fault` or has no
/// ground truth.
///
/// # Errors
/// The recording cannot be scanned; the message names the cause.
pub fn measurement_sample(
    recording: &Recording,
    build: Option<Build>,
) -> Result<Option<MeasurementSample>> {
    first_scan_with(
        recording,
        &measured::MODEL,
        |scanned, truth, _, listener| {
            let map = scanned.pipeline.map();
            let geometry = *map.geometry();
            Ok(MeasurementSample {
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

/// Returns the training sample of a recording's first scan under the measurement model `g`; `None` if it is a `fault`
/// or has no ground truth.
///
/// # Errors
/// The recording cannot be scanned; the message names the cause.
pub fn sample(recording: &Recording, g: &'static Generative) -> Result<Option<TrainingSample>> {
    first_scan_with(recording, g, |scanned, truth, outcome, listener| {
        let answer = answer_of(&recording.name, &outcome)?;
        let wrong = first_wrong(&answer, &truth, &listener.cells);
        let stands = score::maybes(&answer, &truth)
            .into_iter()
            .map(|m| m.outcome);
        Ok(TrainingSample {
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

/// Whether the horizon alone decides if the answer is `ok`. False, for example, if no second sweep has confirmed the
/// answer: no threshold makes that one `ok`. A reason is compatible with `ok` if its effects in the table allow it.
/// `short-horizon` is allowed because a farther horizon removes it.
fn may_be_ok(reasons: Reasons) -> bool {
    reasons.iter().all(|reason| {
        let may = |effect| reason.effects().contains(&effect);
        let word = may(ReasonEffect::Info) && !may(ReasonEffect::Degraded);
        word || reason == Reason::ShortHorizon
    })
}

/// Returns the minimum horizon of an `ok` answer, metres; infinite if another reason prevents `ok`.
fn reach_m(reasons: Reasons, drop: Option<DropEdge>) -> f32 {
    if !may_be_ok(reasons) {
        return f32::INFINITY;
    }
    let edge = drop.map(|drop| drop.nearest_m()).filter(|edge| *edge > 0.0);
    edge.map_or(OK_REACH_M, |edge| edge.min(OK_REACH_M))
}

/// Converts an outcome to the answer that is reported.
fn answer_of(name: &str, outcome: &Outcome) -> Result<Answer> {
    let mut sentences = Vec::new();
    write_scan(ScanId::FIRST, 0, outcome, |line| {
        sentences.push(line.trim_end().to_owned())
    });
    Answer::parse(name, sentences)
}

/// Returns the index of the first way cell from which on the answer stays wrong; `None` if it ends correct. If a cell
/// ends between a step and its reported place, only one of the two is counted. That is not an error of the answer,
/// since no horizon ends there.
fn first_wrong(answer: &Answer, truth: &Truth, cells: &[Cell]) -> Option<usize> {
    let right = |cell: &Cell| !score::wrong_up_to(answer, truth, cell.end_m.into());
    let first = cells.iter().rposition(right).map_or(0, |last| last + 1);
    (first < cells.len()).then_some(first)
}

/// Fits the hazards of one plane: weights of the way cells' features, with standard errors.
pub fn hazards(samples: &[&TrainingSample]) -> LogisticFit {
    let mut rows = Vec::new();
    for sample in samples {
        let until = sample.wrong.map_or(sample.cells.len(), |k| k + 1);
        for (k, cell) in sample.cells.iter().take(until).enumerate() {
            let features = cell.features.iter().map(|&f| f64::from(f)).collect();
            rows.push((features, sample.wrong == Some(k)));
        }
    }
    logistic::fit(&rows, FEATURES, PRIOR_SIGMA)
}

/// Returns for each way cell of a sample the log-odds, from the hazards, that the answer is correct from the mirror to
/// the cell's far end, and whether it is correct there.
fn odds(sample: &TrainingSample, weights: &Weights) -> Vec<(f64, bool)> {
    let mut log_right = 0.0;
    let cells = sample.cells.iter().enumerate().map(|(k, cell)| {
        log_right += f64::from(weights.log_survival(&cell.features));
        let log_wrong = (-log_right.exp_m1_portable())
            .max(f64::from(f32::EPSILON))
            .ln_portable();
        (log_right - log_wrong, sample.wrong.is_none_or(|w| w > k))
    });
    cells.collect()
}

/// Minimum horizon of an `ok` answer, metres: the 1 m of the design contract less a margin for rounding.
const OK_REACH_M: f32 = 0.999;

/// A threshold of `ok` on the probability that an answer is correct, and its effect on a set of answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    /// Threshold: minimum probability that an `ok` answer is correct up to its horizon.
    pub from: f32,
    /// Number of answers that are `ok` with this threshold.
    pub ok: usize,
    /// Number of these `ok` answers that are wrong before their horizon.
    pub wrong: usize,
}

/// Maximum share of `ok` answers that may be wrong before their horizon: the specification.
const MAX_WRONG_SHARE: f64 = 0.01;
/// Probability of accepting a threshold that does not meet the specification (type I error).
const TYPE_I_ERROR: f64 = 0.05;
/// Number of `ok` answers at the first threshold of the test sequence, fixed beforehand: with it the first test passes with
/// a probability of 0.94 where half of [`MAX_WRONG_SHARE`] are wrong (0.7 with 1,600 answers). A type that has not as many
/// is not `ok`.
const FIRST_TESTED: usize = 3200;
/// Difference between the numbers of `ok` answers of consecutive thresholds of a sequence. Closer thresholds add
/// little evidence, but each of them can end the sequence.
const MORE_TESTED: usize = 200;

/// An answer that is `ok` or not depending on the threshold, with all that is needed to decide and judge it.
struct ScoredAnswer<'a> {
    /// Horizon that the answer needs to be `ok`, metres; infinite if another reason prevents `ok`.
    reach_m: f32,
    /// Reported steps.
    steps: &'a [Step],
    /// Reported drop edge.
    drop: Option<DropEdge>,
    /// For each way cell: its far end, metres, and the probability that the answer is correct up to there.
    cells: Vec<(f32, f32)>,
    /// The reported answer and the ground truth.
    judged: &'a (Answer, Truth),
}

impl ScoredAnswer<'_> {
    /// Returns the horizon, metres, up to which the answer is correct with at least the probability `ok_from`; `None`
    /// if the answer is then not `ok`.
    fn horizon_m(&self, ok_from: f32) -> Option<f32> {
        let mut reach = HorizonAccumulator::new(self.steps, self.drop);
        for &(end_m, right) in &self.cells {
            reach.add_cell(end_m, right, ok_from);
        }
        let horizon_m = reach.horizon_m(&Params::DEFAULT);
        let long = horizon_m >= self.reach_m && reach.first_step() >= MIN_FIRST_STEP;
        long.then_some(horizon_m)
    }

    /// Whether the answer is wrong before the horizon `horizon_m`, metres, or reports stairs where there are none.
    fn is_wrong(&self, horizon_m: f32) -> bool {
        let (answer, truth) = self.judged;
        score::wrong_up_to(answer, truth, horizon_m.into()) || score::false_stairs(answer, truth)
    }
}

/// Returns the far end of each way cell, metres, with the probability that the answer is correct up to there. `cells`
/// holds far ends and log-survivals; `probability` maps a cumulative sum of these to a probability.
fn cumulative_probabilities(
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

/// Determines the threshold of `ok` by learn-then-test with a fixed sequence (Angelopoulos, Bates, Candès, Jordan, Lei
/// 2021). It starts at the strictest threshold, in thousandths, that leaves [`FIRST_TESTED`] `ok` answers, and goes
/// downwards by [`MORE_TESTED`] answers at a time. Each threshold is tested against the hypothesis that more than
/// [`MAX_WRONG_SHARE`] of its `ok` answers are wrong; the sequence ends at the first hypothesis that is not rejected.
/// Returns the lowest accepted threshold, or 2, which no answer reaches, if there is none.
fn lowest_valid_threshold(scored_answers: &[ScoredAnswer<'_>]) -> Threshold {
    let judge = |from: f32| {
        let ok = scored_answers
            .iter()
            .filter_map(|scored_answer| Some((scored_answer, scored_answer.horizon_m(from)?)));
        Threshold {
            from,
            ok: ok.clone().count(),
            wrong: ok
                .filter(|(scored_answer, end)| scored_answer.is_wrong(*end))
                .count(),
        }
    };
    let strictest_first = (800..1000_u16).rev();
    let judged: Vec<_> = strictest_first
        .map(|thousandths| judge(f32::from(thousandths) / 1000.0))
        .collect();
    let numbers = (FIRST_TESTED..=scored_answers.len()).step_by(MORE_TESTED);
    let tested = numbers.map_while(|least| judged.iter().find(|t| t.ok >= least));
    let kept = tested.take_while(|t| at_most(t.wrong, t.ok, MAX_WRONG_SHARE) <= TYPE_I_ERROR);
    kept.last().copied().unwrap_or(Threshold {
        from: 2.0,
        ok: 0,
        wrong: 0,
    })
}

/// Returns the threshold of `ok` for answers with steps (`stairs`), or for those without. The scans must not be those
/// that the weights were fitted to.
pub fn threshold(samples: &[&TrainingSample], weights: &Weights, stairs: bool) -> Threshold {
    let of_type = samples.iter().filter(|sample| sample.stairs == stairs);
    let scored_answers: Vec<_> = of_type
        .map(|sample| scored_answer(sample, weights))
        .collect();
    lowest_valid_threshold(&scored_answers)
}

fn scored_answer<'a>(sample: &'a TrainingSample, weights: &Weights) -> ScoredAnswer<'a> {
    let cells = sample.cells.iter();
    let cells = cells.map(|cell| (cell.end_m, weights.log_survival(&cell.features)));
    ScoredAnswer {
        reach_m: sample.reach_m,
        steps: &sample.steps,
        drop: sample.drop,
        cells: cumulative_probabilities(cells, |log_right| {
            weights.probability(log_right, sample.stairs)
        }),
        judged: &sample.judged,
    }
}

/// Fits slope and offset of the calibration: from the hazards' log-odds to the observed share of correct answers.
pub fn calibration(samples: &[&TrainingSample], weights: &Weights) -> LogisticFit {
    let pairs = samples.iter().flat_map(|sample| odds(sample, weights));
    let rows: Vec<(Vec<f64>, bool)> = pairs.map(|(x, right)| (vec![x, 1.0], right)).collect();
    logistic::fit(&rows, 2, PRIOR_SIGMA)
}

/// Fits slope and offset of the calibration of a `MAYBE` (possible step): from the particles' share to the observed
/// share with a true step.
pub fn maybes(samples: &[&TrainingSample]) -> LogisticFit {
    let all = samples.iter().flat_map(|sample| &sample.maybes);
    let rows: Vec<(Vec<f64>, bool)> = all
        .map(|&(share, stands)| (vec![share_log_odds(share).into(), 1.0], stands))
        .collect();
    logistic::fit(&rows, 2, PRIOR_SIGMA)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_of_tests_begins_where_wrong_answers_may_pass() {
        assert!(at_most(22, FIRST_TESTED, MAX_WRONG_SHARE) <= TYPE_I_ERROR);
        assert!(at_most(23, FIRST_TESTED, MAX_WRONG_SHARE) > TYPE_I_ERROR);
        assert!(at_most(22, FIRST_TESTED, 0.5 * MAX_WRONG_SHARE) > 0.93);
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
