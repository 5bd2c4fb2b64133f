//! Counts of a cell with their confidence bounds, and a test of these bounds by a second draw.

use serde_json::{Value, json};

use host_sim::score::{Share, at_most, upper_bound};

use super::measure::SceneOutcome;

/// Significance level: the second draw contradicts a bound of the first if its count had a lower probability than this
/// with the bound as the true probability.
const UNLIKELY: f64 = 0.05;

/// Returns the lower 95 % confidence bound of the probability behind a share (Clopper and Pearson).
pub fn lower(share: Share) -> f64 {
    1.0 - upper_bound(share.of - share.hits, share.of)
}

/// Returns the upper 95 % confidence bound of the probability behind a share (Clopper and Pearson).
pub fn upper(share: Share) -> f64 {
    upper_bound(share.hits, share.of)
}

/// Whether the counts of the second draw are consistent with a true probability of at least `bound`, the lower bound
/// that the first draw gave.
fn keeps_lower(bound: f64, second: Share) -> bool {
    at_most(second.hits, second.of, bound) >= UNLIKELY
}

/// Whether the counts of the second draw are consistent with a true probability of at most `bound`, the upper bound
/// that the first draw gave.
fn keeps_upper(bound: f64, second: Share) -> bool {
    at_most(second.of - second.hits, second.of, 1.0 - bound) >= UNLIKELY
}

/// Counts of scenes by the answer of the full scan, or by the answers of the guard sweeps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counts {
    /// Number of scenes in which the body is detected, of all.
    pub detected: Share,
    /// Number of scenes, of all, in which an answer is `ok` and its free distance ends more than 5 cm beyond the body.
    pub free_beyond_body: Share,
    /// Number of scenes, of all, in which the answer is `ok`; of guard sweeps, the last one.
    pub ok: Share,
    /// Number of scenes, of all, in which a step, drop, rise or obstacle is reported, wherever it is.
    pub alarm: Share,
    /// Number of scenes, of all, whose free distance (of guard sweeps the last one's) ends no farther than it would at
    /// a body at the reference distance of 1 m: counted on level ground, these are chance detections.
    pub short: Share,
}

impl Counts {
    fn add(&mut self, other: &Self) {
        let pairs = [
            (&mut self.detected, other.detected),
            (&mut self.free_beyond_body, other.free_beyond_body),
            (&mut self.ok, other.ok),
            (&mut self.alarm, other.alarm),
            (&mut self.short, other.short),
        ];
        for (sum, share) in pairs {
            *sum = Share::new(sum.hits + share.hits, sum.of + share.of);
        }
    }

    fn json(&self) -> Value {
        json!({
            "detected": self.detected.hits,
            "of": self.detected.of,
            "detected_lower_95": lower(self.detected),
            "free_beyond": self.free_beyond_body.hits,
            "free_beyond_upper_95": upper(self.free_beyond_body),
            "ok": self.ok.hits,
            "alarms": self.alarm.hits,
        })
    }
}

/// Counts of the scenes of one cell, or of several cells together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Counts of full scans; empty for drives.
    pub scan: Counts,
    /// Counts of scenes with guard sweeps, or of drives.
    pub guard: Counts,
    /// Number (from 1) of the sweep at which the guard first named the body, in ascending order, without the scenes in
    /// which it never did.
    named_at: Vec<usize>,
    /// Distances of the body from the mirror at which the guard first named it, centimetres, nearest first.
    named_cm: Vec<u32>,
}

/// Maximum free distance that counts as ending at a body at the reference distance, metres: 5 cm beyond it.
const SHORT_M: f64 = super::condition::REFERENCE_M + 0.05;

impl Tally {
    /// Returns the counts over the outcomes of scenes.
    pub fn of(outcomes: &[SceneOutcome]) -> Self {
        let scans: Vec<_> = outcomes.iter().filter_map(|s| s.scan).collect();
        let short = |free_m: Option<f64>| free_m.is_some_and(|m| m <= SHORT_M);
        let scan = Counts {
            detected: Share::count(&scans, |s| s.detected),
            free_beyond_body: Share::count(&scans, |s| s.free_beyond_body),
            ok: Share::count(&scans, |s| s.ok),
            alarm: Share::count(&scans, |s| s.alarm),
            short: Share::count(&scans, |s| short(s.free_m)),
        };
        let guards = || outcomes.iter().map(|s| &s.guard);
        let guard = Counts {
            detected: Share::count(guards(), |g| g.named_at.is_some()),
            free_beyond_body: Share::count(guards(), |g| g.free_beyond_body),
            ok: Share::count(guards(), |g| g.ok),
            alarm: Share::count(guards(), |g| g.alarm),
            short: Share::count(guards(), |g| short(g.free_m)),
        };
        let mut named_at: Vec<usize> = guards().filter_map(|g| g.named_at).collect();
        named_at.sort_unstable();
        let named = guards().filter_map(|g| g.named_m);
        let mut named_cm: Vec<u32> = named.map(|m| (100.0 * m).round() as u32).collect();
        named_cm.sort_unstable();
        Self {
            scan,
            guard,
            named_at,
            named_cm,
        }
    }

    /// Returns the counts of several tallies together.
    pub fn sum<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut all = Self::default();
        for part in parts {
            all.scan.add(&part.scan);
            all.guard.add(&part.guard);
            all.named_at.extend(&part.named_at);
            all.named_cm.extend(&part.named_cm);
        }
        all.named_at.sort_unstable();
        all.named_cm.sort_unstable();
        all
    }

    /// Returns the number of sweeps within which the guard names the body in a fraction `q` (0…1) of the scenes; `None`
    /// if more than were simulated.
    pub fn sweeps(&self, q: f64) -> Option<usize> {
        let rank = (q * self.guard.detected.of as f64).ceil() as usize;
        self.named_at.get(rank.max(1) - 1).copied()
    }

    /// Returns the distance from the mirror, centimetres, by which the guard has named the body in a fraction `q` (0…1)
    /// of the drives; `None` if that was not reached before the last sweep.
    pub fn named_cm(&self, q: f64) -> Option<u32> {
        let rank = (q * self.guard.detected.of as f64).ceil() as usize;
        let place = self.named_cm.len().checked_sub(rank.max(1))?;
        self.named_cm.get(place).copied()
    }

    /// Returns the tally as JSON.
    pub fn json(&self) -> Value {
        json!({
            "scan": self.scan.json(),
            "guard": self.guard.json(),
            "guard_sweeps_median": self.sweeps(0.5),
            "guard_sweeps_95": self.sweeps(0.95),
        })
    }

    /// Returns the bounds of this tally that the tally `second` of another draw contradicts, as text, and the number of
    /// bounds tested.
    pub fn contradicted(&self, second: &Self) -> (Vec<String>, usize) {
        let parts = [
            ("scan", &self.scan, &second.scan),
            ("guard", &self.guard, &second.guard),
        ];
        let (mut broken, mut bounds) = (Vec::new(), 0);
        for (name, first, second) in parts {
            if first.detected.of == 0 || second.detected.of == 0 {
                continue;
            }
            bounds += 2;
            let describe = |what: &str, was: Share, is: Share| {
                format!(
                    "{name}, {what}: {}/{}, then {}/{}",
                    was.hits, was.of, is.hits, is.of
                )
            };
            if !keeps_lower(lower(first.detected), second.detected) {
                broken.push(describe("detected", first.detected, second.detected));
            }
            if !keeps_upper(upper(first.free_beyond_body), second.free_beyond_body) {
                broken.push(describe(
                    "free beyond",
                    first.free_beyond_body,
                    second.free_beyond_body,
                ));
            }
        }
        (broken, bounds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capability::outcome::{GuardOutcome, ScanOutcome};

    fn seen(detected: bool, named_at: Option<usize>) -> SceneOutcome {
        SceneOutcome {
            scan: Some(ScanOutcome {
                detected,
                ..ScanOutcome::default()
            }),
            guard: GuardOutcome {
                named_at,
                named_m: named_at.map(|k| 1.0 + 0.1 * k as f64),
                ..GuardOutcome::default()
            },
        }
    }

    /// 300 of 300 show 99 %, 299 of 300 do not; 0 of 299 show at most 1 % (Clopper and Pearson's
    /// table).
    #[test]
    fn bounds_are_those_of_clopper_and_pearson() {
        assert!(lower(Share::new(300, 300)) >= 0.99 && lower(Share::new(299, 300)) < 0.985);
        let none_of_299 = 1.0 - 0.05f64.powf(1.0 / 299.0);
        assert!((upper(Share::new(0, 299)) - none_of_299).abs() < 1e-6);
        assert!((lower(Share::new(18, 20)) - 0.7174).abs() < 1e-3);
        assert_eq!(
            (lower(Share::new(0, 0)), upper(Share::new(0, 0))),
            (0.0, 1.0)
        );
    }

    #[test]
    fn what_was_not_named_is_later_than_every_quantile() {
        let all = [Some(2), Some(3), Some(5), None].map(|named_at| seen(true, named_at));
        let tally = Tally::of(&all);
        assert_eq!((tally.sweeps(0.5), tally.sweeps(0.95)), (Some(3), None));
        assert_eq!(
            (tally.named_cm(0.5), tally.named_cm(0.95)),
            (Some(130), None)
        );
        let twice = Tally::sum([&tally, &tally]);
        assert_eq!(
            (twice.scan.detected, twice.sweeps(0.5)),
            (Share::new(8, 8), Some(3))
        );
    }

    #[test]
    fn a_second_draw_contradicts_what_it_makes_unlikely() {
        let of = |hits: usize, all: usize| {
            let seen: Vec<SceneOutcome> = (0..all).map(|k| seen(k < hits, Some(1))).collect();
            Tally::of(&seen)
        };
        let first = of(40, 40);
        // A lower bound of 92.8 %: 35 of 40 are possible, 30 of 40 are not.
        let (kept, bounds) = first.contradicted(&of(35, 40));
        assert!(kept.is_empty() && bounds == 4, "{kept:?}");
        let (broken, _) = first.contradicted(&of(30, 40));
        assert_eq!(broken, ["scan, detected: 40/40, then 30/40"]);
        assert_eq!(Tally::default().contradicted(&first).1, 0);
    }
}
