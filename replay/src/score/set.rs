//! Sums the scores of single scenes up to scores of sets of scenes.

use super::share::upper_bound;
use serde_json::{Value, json};
use stairscan::answer::Direction;
use stairscan::verdict::Status;

use super::judge::{DEPTH_M, Match, SceneScore, is_strong};
use super::reliability::Reliability;
use super::share::{Share, wilson};
use crate::recording::TrueStep;

/// Distribution of absolute errors, metres. Where there are none, an `Option` of this is `None`.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    /// Mean of the absolute errors, metres.
    pub mean: f64,
    /// Median of the absolute errors, metres.
    pub median: f64,
    /// 95th percentile of the absolute errors, interpolated between ranks, metres.
    pub p95: f64,
    /// 95 % confidence interval of the median: lower and upper bound, metres.
    pub median_interval: (f64, f64),
    /// 95 % confidence interval of the 95th percentile: lower and upper bound, metres.
    pub p95_interval: (f64, f64),
}

impl Spread {
    fn of(errors: impl Iterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = errors.map(f64::abs).collect();
        if sorted.is_empty() {
            return None;
        }
        sorted.sort_by(f64::total_cmp);
        let mean = sorted.iter().sum::<f64>() / sorted.len() as f64;
        Some(Self {
            mean,
            median: quantile(&sorted, 0.5),
            p95: quantile(&sorted, 0.95),
            median_interval: quantile_interval(&sorted, 0.5),
            p95_interval: quantile_interval(&sorted, 0.95),
        })
    }

    fn json(spread: Option<Self>) -> Value {
        spread.map_or(
            Value::Null,
            |s| json!({"mean": s.mean, "median": s.median, "p95": s.p95}),
        )
    }
}

/// Returns quantile `q` (0…1) of values in ascending order, linear between ranks; NaN without
/// values.
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let place = q * last as f64;
    let low = place.floor() as usize;
    let high = (low + 1).min(last);
    sorted[low] + (sorted[high] - sorted[low]) * (place - low as f64)
}

/// Returns lower and upper bound of the distribution-free 95 % interval of quantile `q`: the values
/// at the ranks given by Wilson's interval of a share `q`.
fn quantile_interval(sorted: &[f64], q: f64) -> (f64, f64) {
    let (low, high) = wilson(q, sorted.len() as f64);
    (quantile(sorted, low), quantile(sorted, high))
}

/// Type of an answer by the direction and the drop that it reports. The error limit of `ok` applies
/// to each type separately.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnswerType {
    /// The answer reports neither steps nor a drop.
    NoSteps,
    /// The answer reports steps up.
    Up,
    /// The answer reports steps down.
    Down,
    /// The answer reports no steps, but a drop ahead.
    Drop,
}

impl AnswerType {
    /// All types of answers, in the order of tables.
    pub const ALL: [Self; 4] = [Self::NoSteps, Self::Up, Self::Down, Self::Drop];

    fn of(scene: &SceneScore) -> Self {
        match scene.direction {
            Direction::None if scene.reports_drop => Self::Drop,
            Direction::None => Self::NoSteps,
            Direction::Up => Self::Up,
            Direction::Down => Self::Down,
        }
    }

    /// Returns the type's identifier in JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::NoSteps => "none",
            Self::Up => "up",
            Self::Down => "down",
            Self::Drop => "drop",
        }
    }

    /// Returns the type's name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoSteps => "no steps",
            Self::Up => "steps up",
            Self::Down => "steps down",
            Self::Drop => "a drop ahead",
        }
    }
}

/// The score of a set of scenes.
#[derive(Clone, Debug)]
pub struct SetScore {
    /// Name of the set.
    pub name: String,
    /// Number of scenes.
    pub scenes: usize,
    /// Share of scenes that are exact: every true step matched and nothing else reported.
    pub exact: Share,
    /// Share of true steps that no reported step matches.
    pub missed: Share,
    /// Share of strong true steps (a signal-to-noise ratio of at least 15 dB) that were missed.
    pub strong_missed: Share,
    /// Number of reported steps that match no true step.
    pub false_steps: usize,
    /// Share of scenes without steps in which steps or a direction were reported.
    pub false_stairs: Share,
    /// Numbers of scenes whose answer is `ok`, `degraded` and `fault`, in this order.
    pub status: [usize; 3],
    /// Share of scenes whose answer is `ok`.
    pub ok: Share,
    /// Share of `ok` answers that are wrong.
    pub ok_and_wrong: Share,
    /// Share of `ok` answers that are wrong, for each type of answer.
    pub ok_and_wrong_by_type: [(AnswerType, Share); 4],
    /// Share of `ok` among the answers that are neither wrong nor a `fault`.
    pub ok_among_correct: Share,
    /// Share of true steps that lie within the horizon or are reported.
    pub covered: Share,
    /// Median horizon of the `ok` answers, metres; infinite if they do not report it.
    pub ok_horizon_m: Option<f64>,
    /// Reliability of the answers' confidence.
    pub confidence: Reliability,
    /// Share of true drops nearer than [`NEAR_DROP_M`](super::NEAR_DROP_M) that are reported.
    pub reported_drops: Share,
    /// Share of scenes without a true drop in which one is reported.
    pub false_drops_without: Share,
    /// Number of scenes with a reported drop that covers no true one; true drops may be elsewhere
    /// in the scene.
    pub false_drops: usize,
    /// Number of answers that report a drop.
    pub drops: usize,
    /// Share of reported drops with a depth.
    pub depths: Share,
    /// Absolute errors of reported depths of drops, where the true depth is known.
    pub depth: Option<Spread>,
    /// Share of reported depths that are off by more than [`DEPTH_M`](super::DEPTH_M), of those
    /// whose true depth is known.
    pub depths_off: Share,
    /// Reliability of the probabilities of `MAYBE`s, the possible steps.
    pub maybes: Reliability,
    /// Share of answers that are `ok`, of the recordings with a fault that may cause a wrong
    /// answer.
    pub misleading_ok: Share,
    /// Absolute distance errors of matched steps: `[0]` of all, `[1]` of the strong ones (at least
    /// 15 dB).
    pub distance: [Option<Spread>; 2],
    /// Absolute height errors of matched steps: `[0]` of all, `[1]` of the strong ones (at least 15
    /// dB).
    pub height: [Option<Spread>; 2],
    /// Shares of matched steps by their distance error: `[0]` at most two of the step's reported standard deviations,
    /// `[1]` more than three.
    pub distance_sigmas: [Share; 2],
    /// Shares of matched steps by their height error: `[0]` at most two of the step's reported standard deviations,
    /// `[1]` more than three.
    pub height_sigmas: [Share; 2],
}

impl SetScore {
    /// Sums up the scores of `scenes` under the set's name.
    pub fn new<'a>(name: &str, scenes: impl Iterator<Item = &'a SceneScore> + Clone) -> Self {
        let count = |f: &dyn Fn(&SceneScore) -> usize| scenes.clone().map(f).sum::<usize>();
        let matches = || scenes.clone().flat_map(|s| s.matches.iter());
        let spread = |f: fn(&Match) -> f64| {
            [
                Spread::of(matches().map(f)),
                Spread::of(matches().filter(|m| m.strong).map(f)),
            ]
        };
        let sigmas = |z: fn(&Match) -> f64| {
            [
                Share::count(matches(), |m| z(m).abs() <= 2.0),
                Share::count(matches(), |m| z(m).abs() > 3.0),
            ]
        };
        let strong = |steps: &[TrueStep]| steps.iter().filter(|s| is_strong(s)).count();
        let of = |status: Status| scenes.clone().filter(move |s| s.status == status);
        let empty = |s: &&SceneScore| s.truth.is_empty();
        let right = |s: &&SceneScore| !s.wrong && s.status != Status::Fault;
        let mut horizons: Vec<f64> = of(Status::Ok).map(|s| s.horizon_m).collect();
        horizons.sort_by(f64::total_cmp);
        let steps = count(&|s| s.truth.len());
        Self {
            name: name.to_owned(),
            scenes: scenes.clone().count(),
            exact: Share::count(scenes.clone(), |s| s.exact),
            missed: Share::new(count(&|s| s.missed.len()), steps),
            strong_missed: Share::new(count(&|s| strong(&s.missed)), count(&|s| strong(&s.truth))),
            false_steps: count(&|s| s.false_steps.len()),
            false_stairs: Share::count(scenes.clone().filter(empty), |s| s.false_stair),
            status: [Status::Ok, Status::Degraded, Status::Fault].map(|s| of(s).count()),
            ok: Share::count(scenes.clone(), |s| s.status == Status::Ok),
            ok_and_wrong: Share::count(of(Status::Ok), SceneScore::ok_and_wrong),
            ok_and_wrong_by_type: AnswerType::ALL.map(|kind| {
                let of_type = of(Status::Ok).filter(|s| AnswerType::of(s) == kind);
                (kind, Share::count(of_type, SceneScore::ok_and_wrong))
            }),
            ok_among_correct: Share::count(scenes.clone().filter(right), |s| {
                s.status == Status::Ok
            }),
            covered: Share::new(count(&|s| s.covered), steps),
            ok_horizon_m: horizons.get(horizons.len() / 2).copied(),
            confidence: Reliability::of_confidence(
                scenes.clone().filter_map(|s| s.confidence.as_ref()),
            ),
            reported_drops: Share::new(count(&|s| s.near_drops.hits), count(&|s| s.near_drops.of)),
            false_drops_without: Share::count(scenes.clone().filter(|s| s.without_drop), |s| {
                s.false_drop
            }),
            false_drops: count(&|s| usize::from(s.false_drop)),
            drops: count(&|s| usize::from(s.reports_drop)),
            depths: Share::count(scenes.clone().filter(|s| s.reports_drop), |s| s.tells_depth),
            depth: Spread::of(scenes.clone().filter_map(|s| s.depth_error_m)),
            depths_off: Share::count(scenes.clone().filter_map(|s| s.depth_error_m), |error| {
                error.abs() > DEPTH_M
            }),
            maybes: Reliability::of_maybes(scenes.clone().flat_map(|s| &s.maybes)),
            misleading_ok: Share::count(scenes.clone().filter(|s| s.misleading), |s| {
                s.status == Status::Ok
            }),
            distance: spread(|m| m.distance_error),
            height: spread(|m| m.height_error),
            distance_sigmas: sigmas(|m| m.distance_z),
            height_sigmas: sigmas(|m| m.height_z),
        }
    }

    /// Returns the shares, counts, errors and reliability as JSON, lengths in metres.
    pub fn json(&self) -> Value {
        let finite = |v: Option<f64>| v.filter(|v| v.is_finite());
        json!({
            "set": self.name,
            "scenes": self.scenes,
            "exact": self.exact.hits,
            "exact_rate": self.exact.value(),
            "steps": self.missed.of,
            "missed": self.missed.hits,
            "strong_steps": self.strong_missed.of,
            "strong_missed": self.strong_missed.hits,
            "false_steps": self.false_steps,
            "scenes_without_steps": self.false_stairs.of,
            "false_stairs": self.false_stairs.hits,
            "status": {"ok": self.status[0], "degraded": self.status[1], "fault": self.status[2]},
            "ok": self.ok.json(),
            "ok_and_wrong": self.ok_and_wrong.json(),
            "ok_and_wrong_by_type": self.ok_and_wrong_by_type.map(|(kind, share)| json!({
                "direction": kind.as_str(),
                "count": share.hits,
                "of": share.of,
                "upper_bound_95": upper_bound(share.hits, share.of),
            })),
            "ok_of_right": self.ok_among_correct.json(),
            "covered": self.covered.json(),
            "ok_horizon_m": finite(self.ok_horizon_m),
            "confidence": self.confidence.json(),
            "told_drops": self.reported_drops.json(),
            "false_drops": self.false_drops,
            "false_drops_without": self.false_drops_without.json(),
            "depths": self.depths.json(),
            "depth_error_m": Spread::json(self.depth),
            "depths_off": self.depths_off.json(),
            "maybes": self.maybes.json(),
            "harmful_ok": self.misleading_ok.json(),
            "distance_error_m": Spread::json(self.distance[0]),
            "height_error_m": Spread::json(self.height[0]),
            "strong_distance_error_m": Spread::json(self.distance[1]),
            "strong_height_error_m": Spread::json(self.height[1]),
            "distance_within_2_sigma": self.distance_sigmas[0].value(),
            "height_within_2_sigma": self.height_sigmas[0].value(),
            "distance_beyond_3_sigma": self.distance_sigmas[1].value(),
            "height_beyond_3_sigma": self.height_sigmas[1].value(),
        })
    }
}

/// Returns the score of each set, in the order of their names, followed by that of all scenes if
/// there are several sets.
pub fn by_set(scenes: &[SceneScore]) -> Vec<SetScore> {
    let mut names: Vec<&str> = scenes.iter().map(|s| s.set.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let mut sets: Vec<SetScore> = names
        .iter()
        .map(|name| SetScore::new(name, scenes.iter().filter(|s| s.set == *name)))
        .collect();
    if sets.len() > 1 {
        sets.push(SetScore::new("all", scenes.iter()));
    }
    sets
}
