//! Scores one answer against the ground truth.

use stairscan::answer::Direction;
use stairscan::report::{DropLine, MaybeLine};
use stairscan::verdict::Status;

use super::reliability::Prediction;
use super::share::Share;
use crate::answer::{Answer, metres};
use crate::recording::{TrueStep, Truth};

/// Maximum distance of a reported step from the true step that it matches, metres.
pub const MATCH_M: f64 = 0.10;
/// Minimum expanded uncertainty of a reported step, metres. Also the tolerance of the horizon: the check extends this
/// far beyond it.
pub const LIMIT_M: f64 = 0.03;
/// Maximum expanded uncertainty of a reported step, metres.
const MOST_M: f64 = 0.08;
/// True drops nearer than this must be reported, metres.
pub const NEAR_DROP_M: f64 = 1.6;
/// Maximum error of a reported depth, metres.
pub const DEPTH_M: f64 = 0.02;
/// Minimum probability of a reported drop that is scored.
const SURE_DROP: f64 = 0.5;
/// Minimum signal-to-noise ratio of a strong step, which must not be missed, dB.
const STRONG_DB: f64 = 15.0;
/// Minimum distance that an answer's confidence applies to, metres: design contract of the report.
const CONFIDENCE_M: f64 = 1.0;

/// One matched step.
#[derive(Clone, Copy, Debug)]
pub struct Match {
    /// Reported less true distance, metres.
    pub distance_error: f64,
    /// Reported less true height, metres.
    pub height_error: f64,
    /// The distance's error in units of its reported standard deviation.
    pub distance_z: f64,
    /// The height's error in units of its reported standard deviation.
    pub height_z: f64,
    /// Whether the true step is strong.
    pub strong: bool,
}

/// One scene's score.
#[derive(Clone, Debug)]
pub struct SceneScore {
    /// Base name of the recording, with the number of the scan if there are several.
    pub recording: String,
    /// Name of the set: the recording's name up to the first `_`.
    pub set: String,
    /// Reported status.
    pub status: Status,
    /// Reported direction.
    pub direction: Direction,
    /// Reported reasons.
    pub reasons: String,
    /// Horizon of the answer, metres; infinite if it is not reported.
    pub horizon_m: f64,
    /// Reported confidence, and whether the answer was correct up to its horizon; `None` for a `fault` and without a
    /// confidence.
    pub confidence: Option<Prediction>,
    /// Its `MAYBE`s, and whether there is a step; empty for a `fault`.
    pub maybes: Vec<Prediction>,
    /// Whether the answer reports a drop.
    pub tells_drop: bool,
    /// Whether the reported drop has a depth.
    pub tells_depth: bool,
    /// Reported less true depth of a drop, metres; `None` if no depth is reported or the drop covers none of known
    /// depth.
    pub depth_error_m: Option<f64>,
    /// Share of true drops nearer than [`NEAR_DROP_M`] that are reported.
    pub near_drops: Share,
    /// Whether there is no true drop at any distance.
    pub without_drop: bool,
    /// Whether a reported drop covers no true one.
    pub false_drop: bool,
    /// True steps in the field of view.
    pub truth: Vec<TrueStep>,
    /// Matched steps.
    pub matches: Vec<Match>,
    /// True steps without a reported one.
    pub missed: Vec<TrueStep>,
    /// Distances of reported steps without a true one, metres.
    pub invented: Vec<f64>,
    /// Whether every true step is matched and nothing else is reported.
    pub exact: bool,
    /// Whether something up to the horizon is missing, false, or off by more than its expanded uncertainty.
    pub wrong: bool,
    /// The errors up to the horizon, as text.
    pub flaws: Vec<String>,
    /// Number of true steps within the horizon or reported; 0 for a `fault`.
    pub covered: usize,
    /// Whether stairs were reported in a scene without any.
    pub false_stair: bool,
    /// Whether the recording's fault causes an error of more than 3 cm or in the number of steps, if it is not detected.
    pub harmful: bool,
}

impl SceneScore {
    /// Whether the answer was `ok` and wrong, the outcome to be avoided.
    pub fn ok_and_wrong(&self) -> bool {
        self.status == Status::Ok && self.wrong
    }
}

/// Whether a step is so strong that it must not be missed.
pub(super) fn is_strong(step: &TrueStep) -> bool {
    step.snr_db.is_some_and(|snr| snr >= STRONG_DB)
}

/// A reported step.
#[derive(Clone, Copy, Debug)]
struct Reported {
    distance: f64,
    height: f64,
    distance_sigma: f64,
    height_sigma: f64,
}

/// Returns pairs of indices into two lists of distances (metres): one to one, nearest pairs first, within
/// [`MATCH_M`].
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

/// Returns [`nearest`] of reported and true steps.
fn pair(reported: &[Reported], truth: &[TrueStep]) -> Vec<(usize, usize)> {
    let reported: Vec<f64> = reported.iter().map(|told| told.distance).collect();
    let truth: Vec<f64> = truth.iter().map(|step| step.distance_m).collect();
    nearest(&reported, &truth)
}

/// Reported steps, classified by the ground truth.
struct Sorted {
    /// Pairs of (reported, true) indices.
    pairs: Vec<(usize, usize)>,
    /// Indices of true steps without a reported one.
    missed: Vec<usize>,
    /// Distances of reported steps that match neither a true nor an uncounted one, metres.
    invented: Vec<f64>,
}

impl Sorted {
    fn new(reported: &[Reported], truth: &[TrueStep], uncounted: &[TrueStep]) -> Self {
        let pairs = pair(reported, truth);
        let missed = (0..truth.len()).filter(|t| pairs.iter().all(|p| p.1 != *t));
        let missed = missed.collect();
        let left = (0..reported.len()).filter(|r| pairs.iter().all(|p| p.0 != *r));
        let left: Vec<Reported> = left.map(|r| reported[r]).collect();
        let ignored = pair(&left, uncounted);
        let invented = (0..left.len()).filter(|r| ignored.iter().all(|p| p.0 != *r));
        Self {
            pairs,
            missed,
            invented: invented.map(|r| left[r].distance).collect(),
        }
    }

    /// Whether every true step is matched and nothing else is reported.
    fn exact(&self) -> bool {
        self.missed.is_empty() && self.invented.is_empty()
    }
}

/// Returns distance and height of a reported step less those of a true one, metres.
fn errors(told: &Reported, real: &TrueStep) -> (f64, f64) {
    (told.distance - real.distance_m, told.height - real.height_m)
}

/// The scored part of an answer: its steps and its drop; empty for a `fault`.
struct Told {
    steps: Vec<Reported>,
    drop: Option<DropLine>,
}

impl Told {
    fn of(answer: &Answer) -> Self {
        Self {
            steps: reported(answer),
            drop: answer.drop.filter(|_| !answer.is_fault()),
        }
    }

    /// Returns the reported drop if its probability is at least [`SURE_DROP`].
    fn sure_drop(&self) -> Option<&DropLine> {
        let sure = |drop: &&DropLine| f64::from(drop.probability) >= 1000.0 * SURE_DROP;
        self.drop.as_ref().filter(sure)
    }
}

/// Returns the tolerance of a reported drop, metres: max([`MATCH_M`], 3σ).
fn reach(drop: &DropLine) -> f64 {
    MATCH_M.max(3.0 * metres(drop.distance_sigma))
}

/// Whether a reported drop covers a true one at `at` metres.
fn covers(drop: Option<&DropLine>, at: f64) -> bool {
    drop.is_some_and(|drop| (metres(drop.distance) - at).abs() <= reach(drop))
}

/// Returns the depth of the true drop nearest to a reported one that covers it, metres; `None` if it is unknown or
/// none is covered.
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

/// Whether a reported drop covers no true one.
fn is_made_up(drop: &DropLine, truth: &Truth) -> bool {
    !truth.falls_near(metres(drop.distance), reach(drop))
}

/// Returns the errors up to `end` (metres) as text: missing, false, or off.
fn flaws(answer: &Told, truth: &Truth, end: f64) -> Vec<String> {
    let near = |step: &&TrueStep| step.distance_m <= end;
    let told: Vec<Reported> = (answer.steps.iter().copied())
        .filter(|r| r.distance <= end)
        .collect();
    let real: Vec<TrueStep> = truth.steps.iter().filter(near).cloned().collect();
    // A step reported just before the end may be the true one just behind it.
    let beyond = truth.steps.iter().filter(|step| !near(step));
    let uncounted: Vec<TrueStep> = truth.uncounted.iter().chain(beyond).cloned().collect();
    let sorted = Sorted::new(&told, &real, &uncounted);
    let off = sorted.pairs.iter().flat_map(|&(r, t)| {
        let (told, (distance, height)) = (&told[r], errors(&told[r], &real[t]));
        let off = |what: &str, error: f64, sigma: f64| {
            let most = (3.0 * sigma).clamp(LIMIT_M, MOST_M);
            let [at, error_cm, most_cm] = [told.distance, 100.0 * error, 100.0 * most];
            (error.abs() > most).then(|| {
                format!("{what} of the step at {at:.2} m off by {error_cm:+.1} cm (more than {most_cm:.1})")
            })
        };
        let errors = [
            off("distance", distance, told.distance_sigma),
            off("height", height, told.height_sigma),
        ];
        errors.into_iter().flatten()
    });
    let missed = sorted.missed.iter().map(|&t| real[t].distance_m);
    let missed = missed.map(|at| format!("the step at {at:.2} m is missing"));
    let invented = sorted.invented.iter();
    let invented = invented.map(|at| format!("there is no step at {at:.2} m"));
    let missed_drop = |at: &f64| *at <= end && !covers(answer.drop.as_ref(), *at);
    let drops = truth.ground_ends().into_iter().filter(missed_drop);
    let drops = drops.map(|at| format!("the ground ends at {at:.2} m"));
    let false_drop = |drop: &&DropLine| metres(drop.distance) <= end && is_made_up(drop, truth);
    let false_drop = answer.drop.iter().filter(false_drop);
    let false_drop =
        false_drop.map(|drop| format!("the ground does not end at {:.2} m", metres(drop.distance)));
    let steps = off.chain(missed).chain(invented);
    steps.chain(drops).chain(false_drop).collect()
}

/// Whether an answer is wrong up to `horizon` (metres from the mirror).
pub fn wrong_up_to(answer: &Answer, truth: &Truth, horizon: f64) -> bool {
    !flaws(&Told::of(answer), truth, horizon + LIMIT_M).is_empty()
}

/// Returns an answer's confidence, and whether the answer is correct over the distance that it applies to.
fn confidence(answer: &Answer, truth: &Truth) -> Option<Prediction> {
    let permille = answer.scan.confidence.filter(|_| !answer.is_fault())?;
    let end = answer.horizon_m.unwrap_or(f64::INFINITY).max(CONFIDENCE_M);
    Some(Prediction {
        told: f64::from(permille) / 1000.0,
        so: !wrong_up_to(answer, truth, end),
    })
}

/// Returns the `MAYBE`s of an answer, and whether there is a step.
pub fn maybes(answer: &Answer, truth: &Truth) -> Vec<Prediction> {
    let told = answer.maybes.iter().filter(|_| !answer.is_fault());
    let prediction = |maybe: &MaybeLine| {
        let down = maybe.height.0 < 0;
        let mut real = truth.steps.iter().chain(&truth.uncounted);
        Prediction {
            told: f64::from(maybe.probability) / 1000.0,
            so: real.any(|step| {
                let apart = (step.distance_m - metres(maybe.distance)).abs();
                apart <= MATCH_M && (step.height_m < 0.0) == down
            }),
        }
    };
    told.map(prediction).collect()
}

/// Returns the steps of an answer; none for a `fault`.
fn reported(answer: &Answer) -> Vec<Reported> {
    let told = answer.steps.iter().filter(|_| !answer.is_fault());
    told.map(|s| Reported {
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
    let told = !answer.steps.is_empty() || answer.scan.direction != Direction::None;
    none && told && !answer.is_fault()
}

/// Scores one answer.
pub fn scene(answer: &Answer, truth: &Truth) -> SceneScore {
    let told = Told::of(answer);
    let reported = &told.steps;
    let sorted = Sorted::new(reported, &truth.steps, &truth.uncounted);
    let matches = sorted.pairs.iter().map(|&(r, t)| {
        let (told, real) = (&reported[r], &truth.steps[t]);
        let (distance_error, height_error) = errors(told, real);
        Match {
            distance_error,
            height_error,
            distance_z: distance_error / told.distance_sigma,
            height_z: height_error / told.height_sigma,
            strong: is_strong(real),
        }
    });
    let false_stair = false_stairs(answer, truth);
    let horizon_m = answer.horizon_m.unwrap_or(f64::INFINITY);
    let end = horizon_m + LIMIT_M;
    let covered = truth.steps.iter().enumerate().filter(|(t, step)| {
        !answer.is_fault() && (step.distance_m <= end || !sorted.missed.contains(t))
    });
    let mut flaws = flaws(&told, truth, end);
    let ends = truth.ground_ends();
    let near_drops = ends.iter().filter(|at| **at < NEAR_DROP_M);
    let depth = told.drop.as_ref();
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
        tells_drop: told.drop.is_some(),
        tells_depth: depth.is_some(),
        depth_error_m: depth.and_then(|(drop, told)| Some(told - true_depth(drop, truth)?)),
        near_drops: Share::count(near_drops, |at| covers(told.sure_drop(), *at)),
        without_drop: ends.is_empty(),
        false_drop: (told.sure_drop()).is_some_and(|drop| is_made_up(drop, truth)),
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
        invented: sorted.invented,
        false_stair,
        harmful: false,
    }
}
