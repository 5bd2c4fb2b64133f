//! How good answers are, measured against the truth that simulated recordings carry.
//!
//! The rule: a reported step matches the nearest true step by horizontal distance, one to one,
//! nearest pairs first, within 10 cm. A scene is exact when every true step is matched and nothing
//! else is reported; a reported step that matches an uncounted one is ignored. `ok` and `degraded`
//! count as reported, `fault` as nothing. A scene without steps is a false stair when steps or a
//! direction are reported.

use std::fmt::Write as _;

use serde_json::{Value, json};
use stairscan::answer::{Direction, Status};

use crate::answer::{Answer, metres};
use crate::recording::{TrueStep, Truth};

/// Farthest that a reported step may lie from the true step that it matches, metres.
pub const MATCH_M: f64 = 0.10;
/// Steps of this signal-to-noise ratio and more must not be missed, decibels.
const STRONG_DB: f64 = 15.0;

/// One matched step.
#[derive(Clone, Copy, Debug)]
pub struct Match {
    /// Reported less true distance, metres.
    pub distance_error: f64,
    /// Reported less true height, metres.
    pub height_error: f64,
    /// Whether the distance lies within two of its own standard deviations.
    pub distance_within: bool,
    /// Whether the height does.
    pub height_within: bool,
    /// Whether the true step is a strong one.
    pub strong: bool,
}

/// One scene's score.
#[derive(Clone, Debug)]
pub struct SceneScore {
    /// Base name of the recording.
    pub recording: String,
    /// Status that was reported.
    pub status: Status,
    /// Reasons that were reported.
    pub reasons: String,
    /// True steps in sight.
    pub truth: Vec<TrueStep>,
    /// Matched steps.
    pub matches: Vec<Match>,
    /// True steps that nothing was reported for.
    pub missed: Vec<TrueStep>,
    /// Distances of reported steps that match nothing, metres.
    pub invented: Vec<f64>,
    /// Whether every true step is matched and nothing else reported.
    pub exact: bool,
    /// Whether stairs were reported where there are none.
    pub false_stair: bool,
}

fn is_strong(step: &TrueStep) -> bool {
    step.snr_db.is_some_and(|snr| snr >= STRONG_DB)
}

/// Pairs of (reported, true) indices, nearest first, one to one, within [`MATCH_M`].
fn pair(reported: &[f64], truth: &[TrueStep]) -> Vec<(usize, usize)> {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (r, distance) in reported.iter().enumerate() {
        for (t, step) in truth.iter().enumerate() {
            let apart = (distance - step.distance_m).abs();
            if apart <= MATCH_M {
                pairs.push((apart, r, t));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut taken: Vec<(usize, usize)> = Vec::new();
    for (_, r, t) in pairs {
        if taken.iter().all(|&(a, b)| a != r && b != t) {
            taken.push((r, t));
        }
    }
    taken
}

/// Scores one answer.
pub fn scene(answer: &Answer, truth: &Truth) -> SceneScore {
    let steps = if answer.is_fault() {
        &[][..]
    } else {
        &answer.steps[..]
    };
    let reported: Vec<f64> = steps.iter().map(|s| metres(s.distance)).collect();
    let pairs = pair(&reported, &truth.steps);
    let matches = pairs.iter().map(|&(r, t)| {
        let (step, real) = (&steps[r], &truth.steps[t]);
        let distance_error = metres(step.distance) - real.distance_m;
        let height_error = metres(step.height) - real.height_m;
        Match {
            distance_error,
            height_error,
            distance_within: distance_error.abs() <= 2.0 * metres(step.distance_sigma),
            height_within: height_error.abs() <= 2.0 * metres(step.height_sigma),
            strong: is_strong(real),
        }
    });
    let matches: Vec<Match> = matches.collect();
    let missed: Vec<TrueStep> = (0..truth.steps.len())
        .filter(|t| pairs.iter().all(|p| p.1 != *t))
        .map(|t| truth.steps[t].clone())
        .collect();
    let left: Vec<f64> = (0..reported.len())
        .filter(|r| pairs.iter().all(|p| p.0 != *r))
        .map(|r| reported[r])
        .collect();
    let ignored = pair(&left, &truth.uncounted);
    let invented: Vec<f64> = (0..left.len())
        .filter(|r| ignored.iter().all(|p| p.0 != *r))
        .map(|r| left[r])
        .collect();
    let says_stairs = !answer.is_fault() && answer.scan.direction != Direction::None;
    let false_stair = truth.steps.is_empty()
        && truth.uncounted.is_empty()
        && (!reported.is_empty() || says_stairs);
    SceneScore {
        recording: answer.recording.clone(),
        status: answer.scan.status,
        reasons: answer.scan.reasons.to_string(),
        truth: truth.steps.clone(),
        exact: missed.is_empty() && invented.is_empty() && !false_stair,
        matches,
        missed,
        invented,
        false_stair,
    }
}

/// Mean, median and 95th percentile of absolute errors, metres; `None` without any.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Median.
    pub median: f64,
    /// 95th percentile, interpolated between ranks.
    pub p95: f64,
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
        })
    }

    fn json(spread: Option<Self>) -> Value {
        spread.map_or(
            Value::Null,
            |s| json!({"mean": s.mean, "median": s.median, "p95": s.p95}),
        )
    }
}

/// Quantile `q` of sorted values, linear between ranks.
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let place = q * last as f64;
    let low = place.floor() as usize;
    let high = (low + 1).min(last);
    sorted[low] + (sorted[high] - sorted[low]) * (place - low as f64)
}

/// The score of a set of scenes.
#[derive(Clone, Debug)]
pub struct SetScore {
    /// Name of the set.
    pub name: String,
    /// Scenes.
    pub scenes: usize,
    /// Scenes that are exact.
    pub exact: usize,
    /// True steps, and how many of them were missed.
    pub steps: (usize, usize),
    /// The same for strong steps.
    pub strong: (usize, usize),
    /// Reported steps that match nothing.
    pub invented: usize,
    /// Scenes without steps, and how many of them were given some.
    pub empty: (usize, usize),
    /// Scenes reported `ok`, `degraded`, `fault`.
    pub status: [usize; 3],
    /// Absolute distance errors: all matched steps, then the strong ones.
    pub distance: [Option<Spread>; 2],
    /// Absolute height errors, likewise.
    pub height: [Option<Spread>; 2],
    /// Share of distances and heights within two standard deviations.
    pub within: Option<(f64, f64)>,
}

impl SetScore {
    /// Sums up `scenes`.
    pub fn new<'a>(name: &str, scenes: impl Iterator<Item = &'a SceneScore> + Clone) -> Self {
        let count = |f: &dyn Fn(&SceneScore) -> usize| scenes.clone().map(f).sum::<usize>();
        let matches = || scenes.clone().flat_map(|s| s.matches.iter());
        let spread = |f: fn(&Match) -> f64| {
            [
                Spread::of(matches().map(f)),
                Spread::of(matches().filter(|m| m.strong).map(f)),
            ]
        };
        let matched = matches().count();
        let share = |f: fn(&&Match) -> bool| matches().filter(f).count() as f64 / matched as f64;
        let strong = |steps: &[TrueStep]| steps.iter().filter(|s| is_strong(s)).count();
        let with = |status| count(&|s: &SceneScore| usize::from(s.status == status));
        Self {
            name: name.to_owned(),
            scenes: scenes.clone().count(),
            exact: count(&|s| usize::from(s.exact)),
            steps: (count(&|s| s.truth.len()), count(&|s| s.missed.len())),
            strong: (count(&|s| strong(&s.truth)), count(&|s| strong(&s.missed))),
            invented: count(&|s| s.invented.len()),
            empty: (
                count(&|s| usize::from(s.truth.is_empty())),
                count(&|s| usize::from(s.false_stair)),
            ),
            status: [
                with(Status::Ok),
                with(Status::Degraded),
                with(Status::Fault),
            ],
            distance: spread(|m| m.distance_error),
            height: spread(|m| m.height_error),
            within: (matched > 0)
                .then(|| (share(|m| m.distance_within), share(|m| m.height_within))),
        }
    }

    /// The figures as JSON, lengths in metres.
    pub fn json(&self) -> Value {
        json!({
            "set": self.name,
            "scenes": self.scenes,
            "exact": self.exact,
            "exact_rate": self.exact as f64 / self.scenes.max(1) as f64,
            "steps": self.steps.0,
            "missed": self.steps.1,
            "strong_steps": self.strong.0,
            "strong_missed": self.strong.1,
            "false_steps": self.invented,
            "scenes_without_steps": self.empty.0,
            "false_stairs": self.empty.1,
            "status": {"ok": self.status[0], "degraded": self.status[1], "fault": self.status[2]},
            "distance_error_m": Spread::json(self.distance[0]),
            "height_error_m": Spread::json(self.height[0]),
            "strong_distance_error_m": Spread::json(self.distance[1]),
            "strong_height_error_m": Spread::json(self.height[1]),
            "distance_within_2_sigma": self.within.map(|w| w.0),
            "height_within_2_sigma": self.within.map(|w| w.1),
        })
    }
}

/// The set that a recording belongs to: what stands before the first `_` of its name.
fn set_name(recording: &str) -> &str {
    recording.split('_').next().unwrap_or(recording)
}

/// Scores by set, in the order of their names, and the whole last (when there are several).
pub fn by_set(scenes: &[SceneScore]) -> Vec<SetScore> {
    let mut names: Vec<&str> = scenes.iter().map(|s| set_name(&s.recording)).collect();
    names.sort_unstable();
    names.dedup();
    let mut sets: Vec<SetScore> = names
        .iter()
        .map(|name| {
            SetScore::new(
                name,
                scenes.iter().filter(|s| set_name(&s.recording) == *name),
            )
        })
        .collect();
    if sets.len() > 1 {
        sets.push(SetScore::new("all", scenes.iter()));
    }
    sets
}

/// The table for people, errors in centimetres.
pub fn table(sets: &[SetScore]) -> String {
    let mut out = String::from(
        "                     exact    missed   of 15 dB+   false   false     distance error cm     \
         height error cm     within 2σ\n\
         set                 scenes     steps    missed     steps  stairs   mean   med   95 %   \
         mean   med   95 %   dist  height\n",
    );
    for set in sets {
        let spread = |s: Option<Spread>| match s {
            Some(s) => format!(
                "{:5.2} {:5.2} {:6.2}",
                100.0 * s.mean,
                100.0 * s.median,
                100.0 * s.p95
            ),
            None => format!("{:>5} {:>5} {:>6}", "-", "-", "-"),
        };
        let within = match set.within {
            Some((d, h)) => format!("{:4.0} % {:4.0} %", 100.0 * d, 100.0 * h),
            None => format!("{:>6} {:>6}", "-", "-"),
        };
        let of = |(all, some): (usize, usize)| format!("{some}/{all}");
        let _ = writeln!(
            out,
            "{:<18} {:>7} {:>9} {:>9} {:>9} {:>7}  {}   {}  {within}",
            set.name,
            format!("{}/{}", set.exact, set.scenes),
            of(set.steps),
            of(set.strong),
            set.invented,
            of(set.empty),
            spread(set.distance[0]),
            spread(set.height[0]),
        );
    }
    out
}

/// The median of each figure over several runs of the same sets, errors in centimetres.
pub fn median_table(runs: &[Vec<SetScore>]) -> String {
    let mut out = String::from(
        "set                 exact    missed  of 15 dB+   false steps  false stairs   \
         distance med cm   height med cm\n",
    );
    for (k, set) in runs.first().into_iter().flatten().enumerate() {
        let sets = || runs.iter().filter_map(|run| run.get(k));
        let median = |f: &dyn Fn(&SetScore) -> Option<f64>| {
            let mut values: Vec<f64> = sets().filter_map(f).collect();
            values.sort_by(f64::total_cmp);
            quantile(&values, 0.5)
        };
        let _ = writeln!(
            out,
            "{:<18} {:>4}/{:<4} {:>4}/{:<4} {:>4}/{:<4}  {:>12} {:>8}/{:<4} {:>17.2} {:>15.2}",
            set.name,
            median(&|s| Some(s.exact as f64)),
            set.scenes,
            median(&|s| Some(s.steps.1 as f64)),
            set.steps.0,
            median(&|s| Some(s.strong.1 as f64)),
            set.strong.0,
            median(&|s| Some(s.invented as f64)),
            median(&|s| Some(s.empty.1 as f64)),
            set.empty.0,
            100.0 * median(&|s| s.distance[0].map(|d| d.median)),
            100.0 * median(&|s| s.height[0].map(|h| h.median)),
        );
    }
    out
}

/// The scenes that are not exact, one line each.
pub fn confusions(scenes: &[SceneScore]) -> String {
    let mut out = String::new();
    for scene in scenes.iter().filter(|s| !s.exact) {
        let missed = scene.missed.iter().map(|s| {
            let snr = s
                .snr_db
                .map_or(String::new(), |snr| format!(" ({snr:.0} dB)"));
            format!("{:.2} m{snr}", s.distance_m)
        });
        let missed: Vec<String> = missed.collect();
        let invented: Vec<String> = scene.invented.iter().map(|d| format!("{d:.2} m")).collect();
        let list = |what: &str, items: &[String]| match items {
            [] => String::new(),
            items => format!("  {what} {}", items.join(", ")),
        };
        let reasons = match scene.reasons.as_str() {
            "" => String::new(),
            reasons => format!(" ({reasons})"),
        };
        let _ = writeln!(
            out,
            "  {:<24} {}{reasons}, {} of {} steps{}{}",
            scene.recording,
            scene.status.as_str(),
            scene.matches.len(),
            scene.truth.len(),
            list("missed", &missed),
            list("false", &invented),
        );
    }
    out
}

/// The scenes that are not exact, as JSON.
pub fn confusions_json(scenes: &[SceneScore]) -> Value {
    let list = scenes.iter().filter(|s| !s.exact).map(|s| {
        json!({
            "recording": s.recording,
            "status": s.status.as_str(),
            "reasons": s.reasons,
            "steps": s.truth.len(),
            "matched": s.matches.len(),
            "missed_m": s.missed.iter().map(|t| t.distance_m).collect::<Vec<_>>(),
            "false_m": s.invented,
            "false_stair": s.false_stair,
        })
    });
    list.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use stairscan::answer::Reasons;
    use stairscan::report::{ScanLine, StepLine, Tenths};

    fn answer(status: Status, steps: &[(f64, f64)]) -> Answer {
        let tenths = |m: f64| Tenths((m * 10_000.0).round() as i32);
        let steps: Vec<StepLine> = steps
            .iter()
            .map(|&(d, h)| StepLine {
                distance: tenths(d),
                height: tenths(h),
                distance_sigma: Tenths(50),
                height_sigma: Tenths(50),
                ..StepLine::default()
            })
            .collect();
        Answer {
            recording: "set_1".into(),
            sentences: Vec::new(),
            scan: ScanLine {
                scan: 1,
                status,
                direction: if steps.is_empty() {
                    Direction::None
                } else {
                    Direction::Up
                },
                steps: steps.len() as u8,
                lost_rows: 0,
                reasons: Reasons::NONE,
            },
            steps,
        }
    }

    fn truth(steps: &[(f64, f64)], uncounted: &[(f64, f64)]) -> Truth {
        let list = |steps: &[(f64, f64)]| {
            let step = |&(distance_m, height_m)| TrueStep {
                distance_m,
                height_m,
                snr_db: Some(20.0),
            };
            steps.iter().map(step).collect()
        };
        Truth {
            direction: "up".into(),
            steps: list(steps),
            uncounted: list(uncounted),
        }
    }

    #[test]
    fn nearest_pairs_come_first() {
        let score = scene(
            &answer(Status::Ok, &[(0.56, 0.1), (0.61, 0.1)]),
            &truth(&[(0.60, 0.1), (0.50, 0.1)], &[]),
        );
        assert!(score.exact);
        assert!((score.matches[0].distance_error - 0.01).abs() < 1e-9);
        assert!((score.matches[1].distance_error - 0.06).abs() < 1e-9);
        // Of two reported steps the farther one matches nothing, however near it lies.
        let score = scene(
            &answer(Status::Ok, &[(0.55, 0.1), (0.62, 0.1)]),
            &truth(&[(0.60, 0.1)], &[]),
        );
        assert_eq!(score.invented, [0.55]);
    }

    #[test]
    fn a_fault_reports_nothing() {
        let score = scene(
            &answer(Status::Fault, &[(0.6, 0.1)]),
            &truth(&[(0.6, 0.1)], &[]),
        );
        assert_eq!(
            (score.matches.len(), score.missed.len(), score.exact),
            (0, 1, false)
        );
        assert!(scene(&answer(Status::Fault, &[(0.6, 0.1)]), &truth(&[], &[])).exact);
    }

    #[test]
    fn uncounted_steps_are_neither_right_nor_wrong() {
        let score = scene(
            &answer(Status::Ok, &[(0.6, 0.1), (0.9, 0.2)]),
            &truth(&[(0.6, 0.1)], &[(0.9, 0.2)]),
        );
        assert!(score.exact);
        assert_eq!(score.matches.len(), 1);
    }

    #[test]
    fn stairs_where_there_are_none() {
        let score = scene(&answer(Status::Ok, &[(0.6, 0.1)]), &truth(&[], &[]));
        assert!(score.false_stair && !score.exact);
    }

    #[test]
    fn two_sigma_and_quantiles() {
        let score = scene(
            &answer(Status::Ok, &[(0.6, 0.1)]),
            &truth(&[(0.609, 0.111)], &[]),
        );
        assert!(score.matches[0].distance_within && !score.matches[0].height_within);
        assert_eq!(quantile(&[1.0, 2.0, 3.0, 4.0], 0.5), 2.5);
        assert!(quantile(&[], 0.5).is_nan());
    }
}
