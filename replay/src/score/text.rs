//! Formats scores of sets, and lists of erroneous scenes, as text tables and as JSON.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::judge::{DEPTH_M, NEAR_DROP_M, SceneScore};
use super::set::{SetScore, Spread, quantile};
use super::share::Share;
use crate::counted::counted;

/// Returns a text table of sets, one line each, errors in centimetres; below it the lines on drops,
/// harmful faults and the horizon.
pub fn table(sets: &[SetScore]) -> String {
    let mut out = String::from(
        "                     exact              ok and            missed   of 15 dB+   false   false     \
         distance error cm     height error cm     within 2σ\n\
         set                 scenes      ok      wrong  covered     steps    missed     steps  stairs   \
         mean   med   95 %   mean   med   95 %   dist  height\n",
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
        let percent =
            |share: Share| (share.value()).map_or("-".into(), |v| format!("{:.0} %", 100.0 * v));
        let of = |share: Share| format!("{}/{}", share.hits, share.of);
        let _ = writeln!(
            out,
            "{:<18} {:>7} {:>7} {:>10} {:>8} {:>9} {:>9} {:>9} {:>7}  {}   {}  {:>6} {:>6}",
            set.name,
            of(set.exact),
            set.ok.hits,
            set.ok_and_wrong.hits,
            percent(set.covered),
            of(set.missed),
            of(set.strong_missed),
            set.false_steps,
            of(set.false_stairs),
            spread(set.distance[0]),
            spread(set.height[0]),
            percent(set.distance_sigmas[0]),
            percent(set.height_sigmas[0]),
        );
    }
    for set in sets
        .iter()
        .filter(|set| set.reported_drops.of + set.drops > 0)
    {
        let _ = writeln!(out, "\n{}: {}", set.name, drops(set));
    }
    for set in sets.iter().filter(|set| set.misleading_ok.of > 0) {
        let Share { hits, of } = set.misleading_ok;
        let _ = writeln!(
            out,
            "\n{}: {hits} of {of} harmful disturbances are ok",
            set.name
        );
    }
    if let Some(set) = sets.last() {
        let _ = writeln!(out, "\n{}", promise(set));
    }
    out
}

/// Returns the line that counts reported and false drops, and the errors of their depths.
pub fn drops(set: &SetScore) -> String {
    let Share { hits, of } = set.reported_drops;
    let without = set.false_drops_without;
    let mut out = format!(
        "drops nearer than {NEAR_DROP_M:.1} m reported {hits} of {of}; false drops {}, {} of them \
         on {} without one",
        set.false_drops,
        without.hits,
        counted(without.of, "scene")
    );
    if set.depths.hits > 0 {
        let _ = write!(
            out,
            "; depth reported with {} of {}",
            set.depths.hits, set.depths.of
        );
    }
    if let Some(depth) = set.depth {
        let _ = write!(
            out,
            ", error of {} that cover a true one: median {:.1} cm, 95 % {:.1} cm, more than {:.0} cm {}",
            set.depths_off.of,
            100.0 * depth.median,
            100.0 * depth.p95,
            100.0 * DEPTH_M,
            set.depths_off.hits
        );
    }
    out
}

/// Returns the line with the counts of `ok` answers, right and wrong, and their median horizon.
fn promise(set: &SetScore) -> String {
    let horizon = match set.ok_horizon_m {
        None => "no answer is ok".to_owned(),
        Some(m) if m.is_finite() => format!("median horizon of an ok {m:.2} m"),
        Some(_) => "an ok without a horizon is valid at any distance".to_owned(),
    };
    format!(
        "{}: ok and wrong {} of {} ok; ok of what is not wrong {}; {horizon}",
        set.name,
        set.ok_and_wrong.hits,
        set.ok.hits,
        set.ok_among_correct.percent()
    )
}

/// Returns a text table that has the median of each count and error over several runs of the same
/// sets, errors in centimetres. `runs[i][k]` is set `k` in run `i`.
pub fn median_table(runs: &[Vec<SetScore>]) -> String {
    let mut out = String::from(
        "set                 exact    ok  ok and wrong  missed  of 15 dB+   false steps  false stairs   \
         distance med cm   height med cm\n",
    );
    for (k, set) in runs.first().into_iter().flatten().enumerate() {
        let sets = || runs.iter().filter_map(|run| run.get(k));
        let median = |f: &dyn Fn(&SetScore) -> Option<f64>| {
            let mut values: Vec<f64> = sets().filter_map(f).collect();
            values.sort_by(f64::total_cmp);
            quantile(&values, 0.5)
        };
        let middle = |f: fn(&SetScore) -> usize| median(&|s| Some(f(s) as f64));
        let _ = writeln!(
            out,
            "{:<18} {:>4}/{:<4} {:>4} {:>6}    {:>4}/{:<4} {:>4}/{:<4}  {:>12} {:>8}/{:<4} {:>17.2} {:>15.2}",
            set.name,
            middle(|s| s.exact.hits),
            set.scenes,
            middle(|s| s.ok.hits),
            middle(|s| s.ok_and_wrong.hits),
            middle(|s| s.missed.hits),
            set.missed.of,
            middle(|s| s.strong_missed.hits),
            set.strong_missed.of,
            middle(|s| s.false_steps),
            middle(|s| s.false_stairs.hits),
            set.false_stairs.of,
            100.0 * median(&|s| s.distance[0].map(|d| d.median)),
            100.0 * median(&|s| s.height[0].map(|h| h.median)),
        );
    }
    out
}

/// Returns a text line for each scene whose answer is not exact or is wrong.
pub fn confusions(scenes: &[SceneScore]) -> String {
    let mut out = String::new();
    for scene in scenes.iter().filter(|s| !s.exact || s.wrong) {
        let missed = scene.missed.iter().map(|s| {
            let snr = s
                .snr_db
                .map_or(String::new(), |snr| format!(" ({snr:.0} dB)"));
            format!("{:.2} m{snr}", s.distance_m)
        });
        let missed: Vec<String> = missed.collect();
        let false_steps: Vec<String> = scene
            .false_steps
            .iter()
            .map(|d| format!("{d:.2} m"))
            .collect();
        let list = |what: &str, items: &[String]| match items {
            [] => String::new(),
            items => format!("  {what} {}", items.join(", ")),
        };
        let reasons = match scene.reasons.as_str() {
            "" => String::new(),
            reasons => format!(" ({reasons})"),
        };
        // An exact answer has every step and no other, but a step may be off.
        let (wrong, why) = match scene.wrong {
            true => (" WRONG", format!(": {}", scene.flaws.join(", "))),
            false => ("", String::new()),
        };
        let _ = writeln!(
            out,
            "  {:<24} {}{wrong}{reasons}, {} of {} steps{}{}{why}",
            scene.recording,
            scene.status.as_str(),
            scene.matches.len(),
            scene.truth.len(),
            list("missed", &missed),
            list("false", &false_steps),
        );
    }
    out
}

/// Returns a JSON array with an object for each scene whose answer is not exact or is wrong.
pub fn confusions_json(scenes: &[SceneScore]) -> Value {
    let list = scenes.iter().filter(|s| !s.exact || s.wrong).map(|s| {
        json!({
            "recording": s.recording,
            "status": s.status.as_str(),
            "reasons": s.reasons,
            "exact": s.exact,
            "wrong": s.wrong,
            "wrong_because": s.flaws,
            "steps": s.truth.len(),
            "matched": s.matches.len(),
            "missed_m": s.missed.iter().map(|t| t.distance_m).collect::<Vec<_>>(),
            "false_m": s.false_steps,
            "false_stair": s.false_stair,
            "false_drop": s.false_drop,
        })
    });
    list.collect()
}
