//! Scores one answer against the ground truth of its scene.

use stairscan::answer::Direction;
use stairscan::report::{DropLine, MaybeLine};
use stairscan::verdict::Status;

use super::reliability::Prediction;
use super::share::Share;
use crate::answer::{Answer, metres};
use crate::recording::{TrueStep, Truth};

/// Maximum distance of a reported step from the true step that it matches, metres.
pub const MATCH_M: f64 = 0.10;
/// Minimum expanded uncertainty of a reported step, metres. Also the tolerance of the horizon: an
/// answer is checked up to this far beyond its horizon.
pub const LIMIT_M: f64 = 0.03;
/// Maximum expanded uncertainty of a reported step, metres.
const MAX_ERROR_M: f64 = 0.08;
/// Distance within which true drops count as near: the share of these that are reported is scored,
/// metres.
pub const NEAR_DROP_M: f64 = 1.6;
/// Limit of the error of a reported drop's depth, metres; errors above it are counted.
pub const DEPTH_M: f64 = 0.02;
/// Minimum probability, 0…1, at which a reported drop counts as reported.
const MIN_DROP_PROBABILITY: f64 = 0.5;
/// Minimum signal-to-noise ratio of a true step that counts as strong, dB; strong steps should not
/// be missed.
const STRONG_DB: f64 = 15.0;
/// Minimum distance from the mirror over which an answer's confidence applies, metres: design
/// contract of the report.
const CONFIDENCE_M: f64 = 1.0;

/// A reported step that matches a true step.
#[derive(Clone, Copy, Debug)]
pub struct Match {
    /// Reported distance of the step from the mirror less the true one, metres.
    pub distance_error: f64,
    /// Reported height of the step's tread above the ground less the true one, metres.
    pub height_error: f64,
    /// The distance's error in units of its reported standard deviation.
    pub distance_z: f64,
    /// The height's error in units of its reported standard deviation.
    pub height_z: f64,
    /// Whether the true step is strong: a signal-to-noise ratio of at least 15 dB.
    pub strong: bool,
}

/// Score of the answer to one scene.
#[derive(Clone, Debug)]
pub struct SceneScore {
    /// Base name of the recording, with the number of the scan if there are several.
    pub recording: String,
    /// Name of the set: the recording's name up to the first `_`.
    pub set: String,
    /// Status of the answer.
    pub status: Status,
    /// Direction of the steps that the answer reports.
    pub direction: Direction,
    /// Reason codes of the answer, as text.
    pub reasons: String,
    /// Horizon of the answer, metres; infinite if it is not reported.
    pub horizon_m: f64,
    /// Reported confidence, and whether the answer is correct up to its horizon or over the first
    /// metre if that is farther; `None` for a `fault` and for an answer without a confidence.
    pub confidence: Option<Prediction>,
    /// Probability of each `MAYBE` (a possible step) of the answer, and whether there is a step;
    /// empty for a `fault`.
    pub maybes: Vec<Prediction>,
    /// Whether the answer reports a drop.
    pub reports_drop: bool,
    /// Whether the answer reports a drop with its depth.
    pub tells_depth: bool,
    /// Reported less true depth of a drop, metres; `None` if no depth is reported, or if the
    /// reported drop covers no true drop of known depth.
    pub depth_error_m: Option<f64>,
    /// Share of true drops nearer than [`NEAR_DROP_M`] that are reported.
    pub near_drops: Share,
    /// Whether the scene has no true drop at any distance.
    pub without_drop: bool,
    /// Whether a drop is reported, with a probability of at least one half, where there is no true
    /// drop.
    pub false_drop: bool,
    /// True steps that must be reported: in sight, range and angles.
    pub truth: Vec<TrueStep>,
    /// Reported steps that match a true step.
    pub matches: Vec<Match>,
    /// True steps that no reported step matches.
    pub missed: Vec<TrueStep>,
    /// Distances of reported steps that match no true step, metres.
    pub false_steps: Vec<f64>,
    /// Whether every true step is matched and nothing else is reported.
    pub exact: bool,
    /// Whether, up to the horizon, a step or a drop is missing, false, or off by more than its expanded
    /// uncertainty; or whether stairs are reported, at any distance, in a scene without any.
    pub wrong: bool,
    /// The errors that make the answer wrong, as text, one each.
    pub flaws: Vec<String>,
    /// Number of true steps within the horizon or reported; 0 for a `fault`.
    pub covered: usize,
    /// Whether steps or a direction were reported in a scene without steps.
    pub false_stair: bool,
    /// Whether the recording contains a fault that, if it is not detected, causes an error of more
    /// than 3 cm or a wrong number of steps.
    pub misleading: bool,
}

impl SceneScore {
    /// Whether the status was `ok` although the answer is wrong, the outcome to be avoided.
    pub fn ok_and_wrong(&self) -> bool {
        self.status == Status::Ok && self.wrong
    }
}

/// Whether a true step has a signal-to-noise ratio of at least [`STRONG_DB`].
pub(super) fn is_strong(step: &TrueStep) -> bool {
    step.snr_db.is_some_and(|snr| snr >= STRONG_DB)
}

/// A reported step: distance from the mirror, height of its tread, and their standard deviations,
/// metres.
#[derive(Clone, Copy, Debug)]
struct Reported {
    distance: f64,
    height: f64,
    distance_sigma: f64,
    height_sigma: f64,
}

/// Matches two lists of distances (metres) and returns the pairs of indices into the first and the
/// second list: one to one, nearest pairs first, at most [`MATCH_M`] apart.
pub fn nearest(first: &[f64], second: &[f64]) -> Vec<(usize, usize)> {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (i, a) in first.iter().enumerate() {
        for (j, b) in second.iter().enumerate() {
            let apart = (a - b).abs();
            if apart <= MATCH_M {
                pairs.push((apart, i, j));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut taken: Vec<(usize, usize)> = Vec::new();
    for (_, i, j) in pairs {
        if taken.iter().all(|&(a, b)| a != i && b != j) {
            taken.push((i, j));
        }
    }
    taken
}

/// Matches reported with true steps by [`nearest`], and returns the pairs of (reported, true)
/// indices.
fn pair(reported: &[Reported], truth: &[TrueStep]) -> Vec<(usize, usize)> {
    let reported: Vec<f64> = reported.iter().map(|step| step.distance).collect();
    let truth: Vec<f64> = truth.iter().map(|step| step.distance_m).collect();
    nearest(&reported, &truth)
}

/// Reported steps, each matched with a true step, false or ignored; and the true steps that were
/// missed.
struct Sorted {
    /// Indices of matched steps: reported, true.
    pairs: Vec<(usize, usize)>,
    /// Indices of true steps that no reported step matches.
    missed: Vec<usize>,
    /// Distances of reported steps that match neither a true step nor an uncounted one (out of
    /// sight, range or angles), metres.
    false_steps: Vec<f64>,
}

impl Sorted {
    fn new(reported: &[Reported], truth: &[TrueStep], uncounted: &[TrueStep]) -> Self {
        let pairs = pair(reported, truth);
        let missed = (0..truth.len()).filter(|t| pairs.iter().all(|p| p.1 != *t));
        let missed = missed.collect();
        let left = (0..reported.len()).filter(|r| pairs.iter().all(|p| p.0 != *r));
        let left: Vec<Reported> = left.map(|r| reported[r]).collect();
        let ignored = pair(&left, uncounted);
        let false_steps = (0..left.len()).filter(|r| ignored.iter().all(|p| p.0 != *r));
        Self {
            pairs,
            missed,
            false_steps: false_steps.map(|r| left[r].distance).collect(),
        }
    }

    /// Whether every true step is matched and nothing else is reported.
    fn exact(&self) -> bool {
        self.missed.is_empty() && self.false_steps.is_empty()
    }
}

/// Returns the errors of distance and height, metres: those of the reported step less those of the
/// true one.
fn errors(step: &Reported, real: &TrueStep) -> (f64, f64) {
    (step.distance - real.distance_m, step.height - real.height_m)
}

/// The scored part of an answer: its steps and its drop; empty for a `fault`.
struct ReportedAnswer {
    steps: Vec<Reported>,
    drop: Option<DropLine>,
}

impl ReportedAnswer {
    fn of(answer: &Answer) -> Self {
        Self {
            steps: reported(answer),
            drop: answer.drop.filter(|_| !answer.is_fault()),
        }
    }

    /// Returns the reported drop if its probability is at least [`MIN_DROP_PROBABILITY`].
    fn probable_drop(&self) -> Option<&DropLine> {
        let sure = |drop: &&DropLine| f64::from(drop.probability) >= 1000.0 * MIN_DROP_PROBABILITY;
        self.drop.as_ref().filter(sure)
    }
}

/// Returns the maximum distance between a reported drop and a true one that it covers, metres:
/// max([`MATCH_M`], 3σ).
fn reach(drop: &DropLine) -> f64 {
    MATCH_M.max(3.0 * metres(drop.distance_sigma))
}

/// Whether a reported drop covers a true one at `at` metres from the mirror.
fn covers(drop: Option<&DropLine>, at: f64) -> bool {
    drop.is_some_and(|drop| (metres(drop.distance) - at).abs() <= reach(drop))
}

/// Returns the depth of the true drop that the reported one covers, the nearest if there are
/// several, metres; `None` if it covers none, or one of unknown depth.
fn true_depth(drop: &DropLine, truth: &Truth) -> Option<f64> {
    let apart = |at: f64| (at - metres(drop.distance)).abs();
    let ends = truth.ground_ends().into_iter();
    let ends = ends.filter(|at| covers(Some(drop), *at));
    let end = ends.min_by(|a, b| apart(*a).total_cmp(&apart(*b)))?;
    match &truth.drops {
        Some(drops) => drops.iter().find(|d| d.distance_m == end)?.depth_m,
        None => {
            let mut edges = truth.uncounted.iter();
            let edge = edges.find(|e| e.distance_m == end && e.height_m < 0.0)?;
            Some(-edge.height_m)
        }
    }
}

/// Whether a reported drop covers no true drop.
fn is_false_drop(drop: &DropLine, truth: &Truth) -> bool {
    !truth.falls_near(metres(drop.distance), reach(drop))
}

/// Returns a text for each error of an answer up to `end` (metres from the mirror): a step or drop
/// that is missing or false, or a step that is off by more than its expanded uncertainty.
fn errors_before(answer: &ReportedAnswer, truth: &Truth, end: f64) -> Vec<String> {
    let near = |step: &&TrueStep| step.distance_m <= end;
    let steps: Vec<Reported> = (answer.steps.iter().copied())
        .filter(|r| r.distance <= end)
        .collect();
    let real: Vec<TrueStep> = truth.steps.iter().filter(near).cloned().collect();
    // A step reported just before the end may be the true one just behind it.
    let beyond = truth.steps.iter().filter(|step| !near(step));
    let uncounted: Vec<TrueStep> = truth.uncounted.iter().chain(beyond).cloned().collect();
    let sorted = Sorted::new(&steps, &real, &uncounted);
    let off = sorted.pairs.iter().flat_map(|&(r, t)| {
        let (step, (distance, height)) = (&steps[r], errors(&steps[r], &real[t]));
        let off = |what: &str, error: f64, sigma: f64| {
            let most = (3.0 * sigma).clamp(LIMIT_M, MAX_ERROR_M);
            let [at, error_cm, most_cm] = [step.distance, 100.0 * error, 100.0 * most];
            (error.abs() > most).then(|| {
                format!("{what} of the step at {at:.2} m off by {error_cm:+.1} cm (more than {most_cm:.1})")
            })
        };
        let errors = [
            off("distance", distance, step.distance_sigma),
            off("height", height, step.height_sigma),
        ];
        errors.into_iter().flatten()
    });
    let missed = sorted.missed.iter().map(|&t| real[t].distance_m);
    let missed = missed.map(|at| format!("the step at {at:.2} m is missing"));
    let false_steps = sorted.false_steps.iter();
    let false_steps = false_steps.map(|at| format!("there is no step at {at:.2} m"));
    let missed_drop = |at: &f64| *at <= end && !covers(answer.drop.as_ref(), *at);
    let drops = truth.ground_ends().into_iter().filter(missed_drop);
    let drops = drops.map(|at| format!("the ground ends at {at:.2} m"));
    let false_drop = |drop: &&DropLine| metres(drop.distance) <= end && is_false_drop(drop, truth);
    let false_drop = answer.drop.iter().filter(false_drop);
    let false_drop =
        false_drop.map(|drop| format!("the ground does not end at {:.2} m", metres(drop.distance)));
    let steps = off.chain(missed).chain(false_steps);
    steps.chain(drops).chain(false_drop).collect()
}

/// Whether an answer is wrong up to `horizon`, metres from the mirror, plus [`LIMIT_M`].
pub fn wrong_up_to(answer: &Answer, truth: &Truth, horizon: f64) -> bool {
    !errors_before(&ReportedAnswer::of(answer), truth, horizon + LIMIT_M).is_empty()
}

/// Returns an answer's confidence, and whether the answer is correct up to its horizon or over the
/// first metre if that is farther; `None` for a `fault` and without a confidence.
fn confidence(answer: &Answer, truth: &Truth) -> Option<Prediction> {
    let permille = answer.scan.confidence.filter(|_| !answer.is_fault())?;
    let end = answer.horizon_m.unwrap_or(f64::INFINITY).max(CONFIDENCE_M);
    Some(Prediction {
        predicted: f64::from(permille) / 1000.0,
        outcome: !wrong_up_to(answer, truth, end),
    })
}

/// Returns the probability of each `MAYBE` (a possible step) of an answer, and whether there is a
/// true step, up or down as reported, within 10 cm; none for a `fault`.
pub fn maybes(answer: &Answer, truth: &Truth) -> Vec<Prediction> {
    let reported = answer.maybes.iter().filter(|_| !answer.is_fault());
    let prediction = |maybe: &MaybeLine| {
        let down = maybe.height.0 < 0;
        let mut real = truth.steps.iter().chain(&truth.uncounted);
        Prediction {
            predicted: f64::from(maybe.probability) / 1000.0,
            outcome: real.any(|step| {
                let apart = (step.distance_m - metres(maybe.distance)).abs();
                apart <= MATCH_M && (step.height_m < 0.0) == down
            }),
        }
    };
    reported.map(prediction).collect()
}

/// Returns the steps of an answer; none for a `fault`.
fn reported(answer: &Answer) -> Vec<Reported> {
    let reported = answer.steps.iter().filter(|_| !answer.is_fault());
    reported
        .map(|s| Reported {
            distance: metres(s.distance),
            height: metres(s.height),
            distance_sigma: metres(s.distance_sigma),
            height_sigma: metres(s.height_sigma),
        })
        .collect()
}

/// Whether an answer reports steps or a direction in a scene without steps.
pub fn false_stairs(answer: &Answer, truth: &Truth) -> bool {
    let none = truth.steps.is_empty() && truth.uncounted.is_empty();
    let has_stairs = !answer.steps.is_empty() || answer.scan.direction != Direction::None;
    none && has_stairs && !answer.is_fault()
}

/// Scores one answer against the truth. [`SceneScore::misleading`] is left false.
pub fn scene(answer: &Answer, truth: &Truth) -> SceneScore {
    let parsed = ReportedAnswer::of(answer);
    let reported = &parsed.steps;
    let sorted = Sorted::new(reported, &truth.steps, &truth.uncounted);
    let matches = sorted.pairs.iter().map(|&(r, t)| {
        let (step, real) = (&reported[r], &truth.steps[t]);
        let (distance_error, height_error) = errors(step, real);
        Match {
            distance_error,
            height_error,
            distance_z: distance_error / step.distance_sigma,
            height_z: height_error / step.height_sigma,
            strong: is_strong(real),
        }
    });
    let false_stair = false_stairs(answer, truth);
    let horizon_m = answer.horizon_m.unwrap_or(f64::INFINITY);
    let end = horizon_m + LIMIT_M;
    let covered = truth.steps.iter().enumerate().filter(|(t, step)| {
        !answer.is_fault() && (step.distance_m <= end || !sorted.missed.contains(t))
    });
    let mut flaws = errors_before(&parsed, truth, end);
    let ends = truth.ground_ends();
    let near_drops = ends.iter().filter(|at| **at < NEAR_DROP_M);
    let depth = parsed.drop.as_ref();
    let depth = depth.and_then(|drop| Some((drop, metres(drop.depth?))));
    if false_stair && flaws.is_empty() {
        flaws.push("there are no steps".to_owned());
    }
    SceneScore {
        recording: answer.name(),
        set: answer
            .recording
            .split('_')
            .next()
            .unwrap_or_default()
            .to_owned(),
        status: answer.scan.status,
        direction: answer.scan.direction,
        reasons: answer.scan.reasons.to_string(),
        horizon_m,
        confidence: confidence(answer, truth),
        maybes: maybes(answer, truth),
        reports_drop: parsed.drop.is_some(),
        tells_depth: depth.is_some(),
        depth_error_m: depth.and_then(|(drop, depth)| Some(depth - true_depth(drop, truth)?)),
        near_drops: Share::count(near_drops, |at| covers(parsed.probable_drop(), *at)),
        without_drop: ends.is_empty(),
        false_drop: (parsed.probable_drop()).is_some_and(|drop| is_false_drop(drop, truth)),
        truth: truth.steps.clone(),
        exact: sorted.exact() && !false_stair,
        wrong: !flaws.is_empty(),
        flaws,
        covered: covered.count(),
        matches: matches.collect(),
        missed: sorted
            .missed
            .iter()
            .map(|&t| truth.steps[t].clone())
            .collect(),
        false_steps: sorted.false_steps,
        false_stair,
        misleading: false,
    }
}
