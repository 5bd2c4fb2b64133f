//! Fits the parameters of combining the evidence of several scans: the correlation of the errors of two scans, and
//! the hazards of way cells that earlier scans have observed.

use crate::fit::portable::Portable as _;
use std::fmt::Write as _;

use anyhow::Result;
use stairscan::answer::{DropEdge, Step};
use stairscan::estimator::Estimator;
use stairscan::infer::Likelihood;
use stairscan::observer::trace::Cell;
use stairscan::observer::{Event, Observer};
use stairscan::params::carried::{Carried, Correlation, PAST_FEATURES, PastFeatures};
use stairscan::params::hazard::{PlattMap, log_survival, probability};
use stairscan::past::History;
use stairscan::verdict::Outcome;

use super::{
    PRIOR_SIGMA, ScoredAnswer, answer_of, cumulative_probabilities, first_wrong,
    lowest_valid_threshold, reach_m,
};
use crate::fit::logistic;
use host_sim::answer::Answer;
use host_sim::recording::{Recording, Truth};
use host_sim::replay::{self, Options};

/// A way cell (10 cm of the way ahead) with its features by the current and earlier scans.
#[derive(Clone, Copy, Debug)]
struct PastCell {
    end_m: f32,
    features: PastFeatures,
}

/// Training sample of one scan of a sequence, whose evidence is combined with that of earlier scans.
#[derive(Clone, Debug)]
pub struct SequenceSample {
    /// Name of the recording and number of the scan.
    pub name: String,
    cells: Vec<PastCell>,
    stairs: bool,
    wrong: Option<usize>,
    /// Horizon that the answer needs to be `ok`, metres; infinite if another reason prevents `ok`.
    reach_m: f32,
    steps: Vec<Step>,
    drop: Option<DropEdge>,
    judged: (Answer, Truth),
}

/// Errors of one step's distance and of its height above the ground in two independent scans, in standard deviations,
/// and the displacement of the chair between the scans.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    moved_m: f64,
    place: [f64; 2],
    level: [f64; 2],
}

/// Training samples of one sequence of scans.
#[derive(Clone, Debug, Default)]
pub struct SequenceSamples {
    /// Training samples, one for each scan whose evidence was combined with that of an earlier one.
    pub samples: Vec<SequenceSample>,
    /// Pairs of errors, one for each step and two scans that reported it.
    pub pairs: Vec<Pair>,
}

#[derive(Default)]
struct Listener {
    cells: Vec<Cell>,
}

impl Observer for Listener {
    fn event(&mut self, event: Event<'_>) {
        if let Event::Cell(cell) = event {
            self.cells.push(*cell);
        }
    }
}

/// A reported step: the height of its true step above the ground, the chair's travel, and the errors of the reported
/// distance and height in standard deviations.
struct StepErrors {
    height_mm: i64,
    travel_m: f64,
    place: f64,
    level: f64,
}

/// Limit to which errors of steps are clamped, standard deviations: with a larger error the step was matched to the
/// wrong true step.
const MAX_SIGMAS: f64 = 3.0;

fn step_errors(step: &Step, truth: &Truth, travel_m: f64) -> Option<StepErrors> {
    let off = |d: f64| (d - f64::from(step.distance_m)).abs();
    let near = truth
        .steps
        .iter()
        .min_by(|a, b| off(a.distance_m).total_cmp(&off(b.distance_m)))?;
    if off(near.distance_m) > 0.1 {
        return None;
    }
    let z = |reported: f32, sigma: f32, true_m: f64| {
        ((f64::from(reported) - true_m) / f64::from(sigma)).clamp(-MAX_SIGMAS, MAX_SIGMAS)
    };
    Some(StepErrors {
        height_mm: (1e3 * near.height_m).round() as i64,
        travel_m,
        place: z(step.distance_m, step.distance_sigma_m, near.distance_m),
        level: z(step.height_m, step.height_sigma_m, near.height_m),
    })
}

/// Returns the samples of a recording of several scans; empty if it has no ground truth.
///
/// # Errors
/// The recording cannot be scanned; the message names the cause.
pub fn sequence_samples(recording: &Recording) -> Result<SequenceSamples> {
    let mut sequence_samples = SequenceSamples::default();
    let mut carrying = Box::new(Likelihood::new());
    let mut past = History::default();
    let mut trouble = None;
    let mut before: Vec<Vec<StepErrors>> = Vec::new();
    let mut scans = 0;
    replay::answers(recording, &Options::default(), |scanned| {
        let scan = scans;
        scans += 1;
        let run = |estimator: &mut Likelihood, past: Option<&mut History>| -> (Outcome, Listener) {
            let mut listener = Listener::default();
            let mut outcome = estimator.outcome(&scanned.mapped(), past, &mut listener);
            outcome.answer.link();
            (outcome, listener)
        };
        let (outcome, listener) = run(&mut carrying, Some(&mut past));
        let Some(truth) = recording.meta.sequence.truth.get(scan) else {
            return;
        };
        let travel_m = recording.meta.sequence.truth_travel_m.get(scan);
        if let Some(&travel_m) = travel_m {
            let (alone, _) = run(&mut Likelihood::new(), None);
            let now: Vec<StepErrors> = (alone.answer.steps.iter())
                .filter_map(|s| step_errors(s, truth, travel_m))
                .collect();
            for a in before.iter().flatten() {
                for b in now.iter().filter(|b| b.height_mm == a.height_mm) {
                    sequence_samples.pairs.push(Pair {
                        moved_m: (b.travel_m - a.travel_m).abs(),
                        place: [a.place, b.place],
                        level: [a.level, b.level],
                    });
                }
            }
            before.push(now);
        }
        if scanned.answer.is_fault() {
            return;
        }
        let cells: Vec<PastCell> = listener
            .cells
            .iter()
            .filter_map(|c| {
                let end_m = c.end_m;
                c.past.map(|features| PastCell { end_m, features })
            })
            .collect();
        if cells.is_empty() {
            return;
        }
        match answer_of(&recording.name, &outcome) {
            Ok(answer) => sequence_samples.samples.push(SequenceSample {
                name: format!("{} scan {}", recording.name, scan + 1),
                wrong: first_wrong(&answer, truth, &listener.cells),
                stairs: !answer.steps.is_empty(),
                reach_m: reach_m(outcome.reasons(), outcome.answer.drop),
                steps: outcome.answer.steps.to_vec(),
                drop: outcome.answer.drop,
                judged: (answer, truth.clone()),
                cells,
            }),
            Err(error) => trouble = Some(error),
        }
    })?;
    trouble.map_or(Ok(sequence_samples), Err)
}

/// Number of grid steps for each of a correlation's two parameters (value at displacement 0, length), which are
/// searched exhaustively.
const GRID: u32 = 40;
/// Maximum correlation length that is tried, metres. At that displacement a correlation has fallen to 1/e.
const LONGEST_M: f64 = 1.0;

/// Fits a correlation, as a function of the displacement, to the products of two scans' errors by least squares. `of`
/// selects from a pair the two scans' errors of distance or of height.
fn correlation(pairs: &[Pair], of: impl Fn(&Pair) -> [f64; 2]) -> Correlation {
    let power = pairs
        .iter()
        .map(|p| of(p).map(|z| z * z).iter().sum::<f64>() / 2.0);
    let power = power.sum::<f64>() / pairs.len().max(1) as f64;
    let left = |standing: f64, way_m: f64| -> f64 {
        let off = pairs.iter().map(|p| {
            let [a, b] = of(p);
            a * b - power * standing * (-p.moved_m / way_m).exp_portable()
        });
        off.map(|x| x * x).sum()
    };
    let mut best = (f64::INFINITY, 0.0, LONGEST_M);
    for i in 0..=GRID {
        for j in 1..=GRID {
            let standing = f64::from(i) / f64::from(GRID);
            let way_m = LONGEST_M * f64::from(j) / f64::from(GRID);
            let left = left(standing, way_m);
            if left < best.0 {
                best = (left, standing, way_m);
            }
        }
    }
    Correlation {
        at_rest: best.1 as f32,
        length_m: best.2 as f32,
    }
}

/// Returns the fitted correlations of two scans' errors, as functions of the displacement: of the steps' distances,
/// then of their heights.
pub fn correlations(pairs: &[Pair]) -> [Correlation; 2] {
    [
        correlation(pairs, |p| p.place),
        correlation(pairs, |p| p.level),
    ]
}

/// Standard deviation of the Gaussian prior around 0 of a feature's weight. Features are log-odds of an error, or
/// terms whose effect is one or two nats.
const PAST_SIGMA: f64 = 1.0;

/// Result of the fit to sequences of scans.
pub struct Counted {
    /// Fitted hazard weights, calibration maps and thresholds of `ok`.
    pub table: Carried,
    /// Report as text: weights with standard errors, calibration, most confident errors, thresholds.
    pub log: String,
}

/// Fits the hazard weights to `training`, and their calibration and the threshold of `ok` to `calibration`.
pub fn count(training: &[SequenceSample], calibration: &[SequenceSample]) -> Counted {
    let mut rows = Vec::new();
    for sample in training {
        let until = sample.wrong.map_or(sample.cells.len(), |k| k + 1);
        for (k, cell) in sample.cells.iter().take(until).enumerate() {
            let features = cell.features.iter().map(|&f| f64::from(f)).collect();
            rows.push((features, sample.wrong == Some(k)));
        }
    }
    let hazards = logistic::fit(&rows, PAST_FEATURES, PAST_SIGMA);
    let mut table = Carried {
        hazard: [0.0; PAST_FEATURES],
        maps: [PlattMap::IDENTITY; 2],
        ok_from: [2.0; 2],
    };
    for (weight, &fitted) in table.hazard.iter_mut().zip(&hazards.weights) {
        *weight = fitted as f32;
    }
    let mut log = format!(
        "hazard: {} scans, {} cells, {} of them wrong\n",
        training.len(),
        hazards.samples,
        hazards.positives
    );
    for (k, (weight, error)) in hazards.weights.iter().zip(&hazards.errors).enumerate() {
        let _ = writeln!(log, "  {k:>3} {weight:>9.3} ± {error:.3}");
    }
    for (stairs, k) in [(false, 0), (true, 1)] {
        let samples = calibration.iter().filter(|l| l.stairs == stairs);
        let rows: Vec<_> = samples.flat_map(|l| odds(l, &table)).collect();
        let fit = logistic::fit(&rows, 2, PRIOR_SIGMA);
        if let [slope, offset] = fit.weights[..] {
            table.maps[k] = PlattMap {
                slope: slope as f32,
                offset: offset as f32,
            };
            let _ = writeln!(log, "calibration, steps {stairs}: {slope:.3} {offset:.3}");
        }
    }
    for (p, name) in most_confident_errors(calibration, &table) {
        let _ = writeln!(log, "  wrong with {p:.4}: {name}");
    }
    for (stairs, name) in [(false, "without steps"), (true, "with steps")] {
        let of_type = || calibration.iter().filter(|l| l.stairs == stairs);
        let least = lowest_valid_threshold(
            &of_type()
                .map(|l| scored_answer(l, &table))
                .collect::<Vec<_>>(),
        );
        table.ok_from[usize::from(stairs)] = least.from;
        let able = of_type().filter(|l| l.reach_m.is_finite());
        let _ = writeln!(
            log,
            "{name}: ok from {:.3} on: {} of {} scans without another reason against it, {} of them wrong",
            least.from,
            least.ok,
            able.count(),
            least.wrong
        );
    }
    Counted { table, log }
}

/// Returns for each way cell the inputs of the calibration (log-odds that the answer is correct up to the cell's far
/// end, and 1), and whether it is correct.
fn odds(sample: &SequenceSample, table: &Carried) -> Vec<(Vec<f64>, bool)> {
    let mut log_right = 0.0;
    let cells = sample.cells.iter().enumerate().map(|(k, cell)| {
        log_right += f64::from(log_survival(table.log_odds(&cell.features)));
        let log_wrong = (-log_right.exp_m1_portable())
            .max(f64::from(f32::EPSILON))
            .ln_portable();
        let right = sample.wrong.is_none_or(|w| w > k);
        (vec![log_right - log_wrong, 1.0], right)
    });
    cells.collect()
}

/// Maximum number of wrong answers that are listed, those with the highest probability of being correct.
const LISTED: usize = 12;

/// Returns the names of the wrong answers with the highest probability of being correct up to their
/// first error, with that probability.
fn most_confident_errors<'a>(
    samples: &'a [SequenceSample],
    table: &Carried,
) -> Vec<(f32, &'a str)> {
    let mut wrong: Vec<(f32, &str)> = samples
        .iter()
        .filter(|sample| sample.reach_m.is_finite())
        .filter_map(|sample| {
            let cells = sample.cells.get(..=sample.wrong?)?.iter();
            let log_right = cells
                .map(|c| log_survival(table.log_odds(&c.features)))
                .sum();
            let p = probability(&table.maps, log_right, sample.stairs);
            Some((p, sample.name.as_str()))
        })
        .collect();
    wrong.sort_by(|a, b| b.0.total_cmp(&a.0));
    wrong.truncate(LISTED);
    wrong
}

fn scored_answer<'a>(sample: &'a SequenceSample, table: &Carried) -> ScoredAnswer<'a> {
    let cells = sample.cells.iter();
    let cells = cells.map(|cell| (cell.end_m, log_survival(table.log_odds(&cell.features))));
    ScoredAnswer {
        reach_m: sample.reach_m,
        steps: &sample.steps,
        drop: sample.drop,
        cells: cumulative_probabilities(cells, |log_right| {
            probability(&table.maps, log_right, sample.stairs)
        }),
        judged: &sample.judged,
    }
}

/// Returns the Rust source file of the weights, and of the correlations of the errors of steps' distances (`places`)
/// and heights (`levels`).
pub fn write(table: &Carried, [places, levels]: &[Correlation; 2]) -> String {
    let mut out = String::from(
        "//! Weights of earlier scans' evidence, counted from simulated sequences: written by\n\
         //! `cargo study sequences --fit`.\n\n\
         use super::carried::{Carried, Correlation};\nuse super::hazard::PlattMap;\n",
    );
    for (name, of, c) in [
        ("PLACES", "distances", places),
        ("LEVELS", "heights", levels),
    ] {
        let _ = write!(
            out,
            "\n/// Correlation of the errors of steps' {of}.\npub const {name}: Correlation = Correlation {{\n    \
             at_rest: {:?},\n    length_m: {:?},\n}};\n",
            c.at_rest, c.length_m
        );
    }
    out.push_str(
        "\n/// Weights of the depth plane.\npub static UP: Carried = Carried {\n    hazard: [\n",
    );
    for weight in table.hazard {
        let _ = writeln!(out, "        {weight:?},");
    }
    out.push_str("    ],\n    maps: [\n");
    for map in table.maps {
        let _ = write!(
            out,
            "        PlattMap {{\n            slope: {:?},\n            offset: {:?},\n        }},\n",
            map.slope, map.offset
        );
    }
    let _ = write!(out, "    ],\n    ok_from: {:?},\n}};\n", table.ok_from);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use host_sim::recording::TrueStep;

    /// A sample of a scan whose log-odds of an error are -`sure` in each way cell; if `wrong`, it misses a step
    /// within the first metre.
    fn sample(sure: f32, wrong: bool, reach_m: f32) -> SequenceSample {
        let mut features = [0.0; PAST_FEATURES];
        features[0] = 1.0;
        features[1] = -sure;
        let cell = |k: usize| PastCell {
            end_m: 0.5 + 0.1 * k as f32,
            features,
        };
        let missed = TrueStep {
            distance_m: 0.95,
            height_m: 0.17,
            snr_db: None,
        };
        let truth = Truth {
            steps: wrong.then_some(missed).into_iter().collect(),
            ..Truth::default()
        };
        SequenceSample {
            name: "scan".into(),
            cells: (0..10).map(cell).collect(),
            stairs: true,
            wrong: wrong.then_some(5),
            reach_m,
            steps: Vec::new(),
            drop: None,
            judged: (answer_of("scan", &Outcome::silent()).unwrap(), truth),
        }
    }

    #[test]
    fn answers_that_nothing_makes_ok_do_not_move_the_threshold() {
        let right = (0..6000).map(|k| sample(0.005 * (k % 1000) as f32, k % 1000 < 40, 1.0));
        let mut samples: Vec<SequenceSample> = right.collect();
        let before = count(&samples, &samples).table;
        assert!(before.ok_from[1] < 1.0, "{before:?}");
        // Additional samples with the same log-odds that are wrong, but unconfirmed.
        samples.extend((0..30).map(|_| sample(5.0, true, f32::INFINITY)));
        let counted = count(&samples, &samples);
        assert!(counted.table.ok_from[1] < 1.0, "{}", counted.log);
        assert!(counted.log.contains("of 6000 scans"), "{}", counted.log);
        for sample in &mut samples {
            sample.reach_m = 1.0;
        }
        let all = count(&samples, &samples);
        assert!(all.table.ok_from[1] > 1.0, "{}", all.log);
    }
}
