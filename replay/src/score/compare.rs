//! Compares two sets of answers to the same scenes, scene by scene.

use stairscan::verdict::Status;

use super::judge::{Match, SceneScore};
use super::set::quantile;
use super::share::at_most;

/// Numbers of scenes in which a property of the answer differs between two sets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Change {
    /// Number of scenes whose answer has the property only in the second set.
    pub gained: usize,
    /// Number of scenes whose answer has the property only in the first set.
    pub lost: usize,
}

impl Change {
    /// Counts gains and losses over pairs of one scene each: whether the answer of the first set,
    /// and that of the second, has the property.
    pub fn of(pairs: impl Iterator<Item = (bool, bool)>) -> Self {
        let mut change = Self::default();
        for (before, after) in pairs {
            change.gained += usize::from(after && !before);
            change.lost += usize::from(before && !after);
        }
        change
    }

    /// Returns the two-sided p-value of the hypothesis that gains and losses are equally likely: McNemar's
    /// exact test (binomial, both tails).
    pub fn p(self) -> f64 {
        let fewer = self.gained.min(self.lost);
        (2.0 * at_most(fewer, self.gained + self.lost, 0.5)).min(1.0)
    }
}

/// Differences between two sets of answers to the same scenes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Change in exact answers: all visible steps reported within 10 cm, and no other.
    pub exact: Change,
    /// Change in answers with the status `ok`.
    pub ok: Change,
    /// Change in answers that are `ok` and not wrong.
    pub ok_right: Change,
    /// Change in answers that are `ok` and wrong.
    pub ok_wrong: Change,
    /// 95th percentiles of absolute errors, metres: `[set][k]`, first set before, then after; `k` =
    /// 0 for distances, 1 for heights.
    pub errors_m: [[f64; 2]; 2],
}

impl Comparison {
    /// Compares the answers of `after` with those of `before`, scene by scene in the same order.
    pub fn new(before: &[SceneScore], after: &[SceneScore]) -> Self {
        let change = |has: &dyn Fn(&SceneScore) -> bool| {
            Change::of(before.iter().zip(after).map(|(a, b)| (has(a), has(b))))
        };
        let ok = |s: &SceneScore| s.status == Status::Ok;
        Self {
            exact: change(&|s| s.exact),
            ok: change(&ok),
            ok_right: change(&|s| ok(s) && !s.wrong),
            ok_wrong: change(&SceneScore::ok_and_wrong),
            errors_m: [before, after].map(errors),
        }
    }
}

/// Returns the 95th percentiles of the absolute errors of matched steps, metres: distance, height.
fn errors(scores: &[SceneScore]) -> [f64; 2] {
    let of = |error: fn(&Match) -> f64| {
        let matches = scores.iter().flat_map(|s| &s.matches);
        let mut errors: Vec<f64> = matches.map(|m| error(m).abs()).collect();
        errors.sort_by(f64::total_cmp);
        quantile(&errors, 0.95)
    };
    [of(|m| m.distance_error), of(|m| m.height_error)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mcnemar_s_test_is_the_binomial_one() {
        let p = |gained, lost| Change { gained, lost }.p();
        assert_eq!(p(0, 0), 1.0);
        assert!((p(0, 5) - 2.0 / 32.0).abs() < 1e-12 && (p(5, 0) - p(0, 5)).abs() < 1e-15);
        // 10 pairs, 2 against 8: 2 (1 + 10 + 45) / 1024.
        assert!((p(2, 8) - 112.0 / 1024.0).abs() < 1e-12);
        assert_eq!(p(7, 7), 1.0);
        assert!(p(0, 2000) < 1e-300 && p(990, 1010) > 0.6);
    }

    #[test]
    fn scenes_are_counted_that_change() {
        let pairs = [
            (true, false),
            (false, true),
            (true, true),
            (false, false),
            (true, false),
        ];
        assert_eq!(Change::of(pairs.into_iter()), Change { gained: 1, lost: 2 });
    }
}
