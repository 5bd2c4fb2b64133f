//! Finds the differences of two answers, as rows of a table: status first, then steps, matched by
//! nearest distance, then the rest.

use serde_json::{Value, json};
use stairscan::report::{DropLine, MaybeLine, StepLine, Tenths};

use crate::answer::{Answer, metres};
use crate::score;

/// One difference of two answers, a row of the table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Difference {
    /// Number of the scan, from 1; `None` if each recording contains only one.
    pub scan: Option<usize>,
    /// Name of the length, probability or text that differs.
    pub what: String,
    /// Text for the first answer; a dash if it has none.
    pub first: String,
    /// Text for the second answer; a dash if it has none.
    pub second: String,
    /// Second value less the first, with unit, if both are numbers; else empty.
    pub by: String,
    /// Standard deviations of both values, with unit, if known; else empty.
    pub sigma: String,
}

/// Text in the table for a value that an answer does not have.
const NONE: &str = "–";

impl Difference {
    /// Returns the difference as JSON for the page's table.
    pub fn json(&self) -> Value {
        json!({
            "scan": self.scan,
            "what": self.what,
            "first": self.first,
            "second": self.second,
            "by": self.by,
            "sigma": self.sigma,
        })
    }

    /// Returns the difference as a line of text.
    pub fn text(&self) -> String {
        let scan = self.scan.map_or(String::new(), |k| format!("scan {k}: "));
        let by = match (self.by.as_str(), self.sigma.as_str()) {
            ("", _) => String::new(),
            (by, "") => format!(" ({by})"),
            (by, sigma) => format!(" ({by}, σ {sigma})"),
        };
        format!("{scan}{}: {} | {}{by}", self.what, self.first, self.second)
    }
}

/// Returns the differences of two answers; empty if their JSON is equal.
pub fn between(first: &Answer, second: &Answer) -> Vec<Difference> {
    let mut list = List::default();
    let both = [first, second];
    list.words("status", both.map(|a| a.scan.status.as_str().to_owned()));
    list.words(
        "direction",
        both.map(|a| a.scan.direction.as_str().to_owned()),
    );
    let plane = |a: &Answer| a.scan.plane.map_or(NONE, |plane| plane.as_str()).to_owned();
    list.words("plane", both.map(plane));
    list.words("number of steps", both.map(|a| a.steps.len().to_string()));
    steps(&mut list, both);
    reasons(&mut list, both);
    list.lengths("horizon", both.map(|a| a.horizon_m), None);
    list.lengths("free distance", both.map(Answer::free_m), None);
    list.shares("confidence", both.map(|a| a.scan.confidence));
    drops(&mut list, both.map(|a| a.drop.as_ref()));
    maybes(&mut list, both);
    list.words("lost rows", both.map(|a| a.scan.lost_rows.to_string()));
    list.0
}

/// The differences found so far, in the order of the table.
#[derive(Default)]
struct List(Vec<Difference>);

impl List {
    /// Adds a row named `what` for two texts if they differ.
    fn words(&mut self, what: &str, [first, second]: [String; 2]) {
        if first != second {
            let row = Difference {
                what: what.to_owned(),
                first,
                second,
                ..Difference::default()
            };
            self.0.push(row);
        }
    }

    /// Adds a row named `what` for two lengths and their standard deviations (both metres) if they
    /// differ in the text in centimetres.
    fn lengths(&mut self, what: &str, values: [Option<f64>; 2], sigma: Option<[f64; 2]>) {
        self.words(what, values.map(|v| v.map_or(NONE.to_owned(), cm)));
        let [Some(a), Some(b)] = values else { return };
        if let Some(row) = self.0.last_mut().filter(|row| row.what == what) {
            row.by = format!("{:+.2} cm", 100.0 * (b - a));
            row.sigma = sigma.map_or(String::new(), |[a, b]| {
                format!("{:.2} / {:.2} cm", 100.0 * a, 100.0 * b)
            });
        }
    }

    /// Adds a row named `what` for two probabilities in thousandths if they differ.
    fn shares(&mut self, what: &str, values: [Option<u16>; 2]) {
        self.words(what, values.map(|v| v.map_or(NONE.to_owned(), percent)));
        let [Some(a), Some(b)] = values else { return };
        if let Some(row) = self.0.last_mut().filter(|row| row.what == what) {
            row.by = format!("{:+.1} points", (f64::from(b) - f64::from(a)) / 10.0);
        }
    }
}

fn cm(metres: f64) -> String {
    format!("{:.2} cm", 100.0 * metres)
}

fn percent(permille: u16) -> String {
    format!("{:.1} %", f64::from(permille) / 10.0)
}

/// Matches the items of two lists by nearest distance (metres); returns pairs and unmatched items
/// with their indices, in the order of distance. `[first, second]` has `None` where an item is
/// unmatched.
fn matched<T>(lists: [&[T]; 2], distance: impl Fn(&T) -> f64) -> Vec<[Option<(usize, &T)>; 2]> {
    let at = lists.map(|list| list.iter().map(&distance).collect::<Vec<f64>>());
    let pairs = score::nearest(&at[0], &at[1]);
    let item = |side: usize, k: usize| lists[side].get(k).map(|item| (k, item));
    let mut all: Vec<[Option<(usize, &T)>; 2]> = (pairs.iter())
        .map(|&(i, j)| [item(0, i), item(1, j)])
        .collect();
    for i in (0..at[0].len()).filter(|i| pairs.iter().all(|pair| pair.0 != *i)) {
        all.push([item(0, i), None]);
    }
    for j in (0..at[1].len()).filter(|j| pairs.iter().all(|pair| pair.1 != *j)) {
        all.push([None, item(1, j)]);
    }
    let place = |both: &[Option<(usize, &T)>; 2]| {
        let known = both.iter().flatten().next();
        known.map_or(f64::INFINITY, |(_, item)| distance(item))
    };
    all.sort_by(|a, b| place(a).total_cmp(&place(b)));
    all
}

/// Adds rows for the steps that differ, and for those that only one answer has.
fn steps(list: &mut List, both: [&Answer; 2]) {
    let length = |of: fn(&StepLine) -> Tenths, step: &StepLine| metres(of(step));
    for pair in matched(both.map(|a| &a.steps[..]), |s| metres(s.distance)) {
        let name = match pair {
            [Some((i, _)), Some((j, _))] if i != j => format!("step {} | {}", i + 1, j + 1),
            [Some((k, _)), _] | [None, Some((k, _))] => format!("step {}", k + 1),
            [None, None] => continue,
        };
        let [Some((_, a)), Some((_, b))] = pair else {
            let describe = |step: Option<(usize, &StepLine)>| match step {
                None => NONE.to_owned(),
                Some((_, s)) => {
                    format!("{}, {} high", cm(metres(s.distance)), cm(metres(s.height)))
                }
            };
            list.words(&name, pair.map(describe));
            continue;
        };
        for (word, value, sigma) in [
            (
                "distance",
                (|s| s.distance) as fn(&StepLine) -> Tenths,
                (|s| s.distance_sigma) as fn(&StepLine) -> Tenths,
            ),
            ("height", |s| s.height, |s| s.height_sigma),
        ] {
            let what = format!("{name}, {word}");
            let values = [a, b].map(|step| Some(length(value, step)));
            let sigmas = [a, b].map(|step| length(sigma, step));
            list.lengths(&what, values, Some(sigmas));
            if values[0] == values[1] {
                list.lengths(&format!("{what}, σ"), sigmas.map(Some), None);
            }
        }
        let quality = [a, b].map(|step| format!("{} %", step.quality));
        list.words(&format!("{name}, quality"), quality);
    }
}

/// Adds a row for each reason that only one answer has.
fn reasons(list: &mut List, both: [&Answer; 2]) {
    let sets = both.map(|a| a.scan.reasons);
    for reason in sets[0].and(sets[1]).iter() {
        let describe = |has: bool| if has { "reported" } else { NONE }.to_owned();
        let what = format!("reason {}", reason.as_str());
        list.words(&what, sets.map(|set| describe(set.has(reason))));
    }
}

/// Adds the rows for the edges of drops if they differ.
fn drops(list: &mut List, both: [Option<&DropLine>; 2]) {
    let length =
        |of: fn(&DropLine) -> Option<Tenths>| both.map(|drop| drop.and_then(of).map(metres));
    let sigma = match both {
        [Some(a), Some(b)] => Some([a, b].map(|drop| metres(drop.distance_sigma))),
        _ => None,
    };
    list.lengths("drop", length(|d| Some(d.distance)), sigma);
    list.lengths("depth of the drop", length(|d| d.depth), None);
    let probability = both.map(|drop| drop.map(|d| d.probability));
    list.shares("probability of the drop", probability);
}

/// Adds the rows for the `MAYBE`s (possible steps) that differ, matched by distance.
fn maybes(list: &mut List, both: [&Answer; 2]) {
    for pair in matched(both.map(|a| &a.maybes[..]), |m| metres(m.distance)) {
        let Some((_, known)) = pair.iter().flatten().next() else {
            continue;
        };
        let describe = |maybe: Option<(usize, &MaybeLine)>| match maybe {
            None => NONE.to_owned(),
            Some((_, m)) => format!(
                "{}, {} high, {}",
                cm(metres(m.distance)),
                cm(metres(m.height)),
                percent(m.probability)
            ),
        };
        let what = format!("MAYBE at {:.0} cm", 100.0 * metres(known.distance));
        list.words(&what, pair.map(describe));
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use stairscan::config::{Config, EstimatorKind};
    use stairscan::verdict::Status;

    use super::*;
    use crate::recording::Recording;
    use crate::replay::{self, Options};

    fn answer(name: &str, estimator: EstimatorKind) -> Answer {
        let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
        let recording = Recording::read(&dir.join(name)).unwrap();
        let config = Config {
            estimator,
            seed: replay::SEED,
            ..Config::default()
        };
        let options = Options {
            config,
            ..Options::default()
        };
        replay::answer(&recording, &options).unwrap()
    }

    fn row<'a>(rows: &'a [Difference], what: &str) -> &'a Difference {
        rows.iter()
            .find(|row| row.what == what)
            .unwrap_or_else(|| panic!("{what}: {rows:?}"))
    }

    #[test]
    fn an_answer_differs_in_nothing_from_itself() {
        for name in ["stair_a", "descending", "empty"] {
            let one = answer(name, EstimatorKind::Likelihood);
            assert_eq!(between(&one, &one), []);
        }
    }

    #[test]
    fn steps_are_matched_by_distance_and_differ_beside_their_sigma() {
        let a = answer("stair_a", EstimatorKind::Likelihood);
        let mut b = a.clone();
        // One millimetre farther, and the last step gone.
        b.steps[0].distance.0 += 10;
        b.steps.pop();
        let rows = between(&a, &b);
        let distance = row(&rows, "step 1, distance");
        assert_eq!(distance.by, "+0.10 cm");
        assert!(distance.sigma.contains(" / "), "{distance:?}");
        assert_eq!(row(&rows, "number of steps").second, "2");
        assert_eq!(row(&rows, "step 3").second, NONE);
        assert!(!rows.iter().any(|row| row.what.starts_with("step 2")));
    }

    #[test]
    fn a_step_that_only_the_second_has_shifts_no_other() {
        let b = answer("stair_a", EstimatorKind::Likelihood);
        let mut a = b.clone();
        a.steps.remove(0);
        let rows = between(&a, &b);
        assert_eq!(row(&rows, "step 1").first, NONE);
        let steps = rows.iter().filter(|row| row.what.starts_with("step "));
        assert_eq!(steps.count(), 1, "{rows:?}");
    }

    #[test]
    fn the_estimators_differ_in_what_they_promise() {
        let a = answer("stair_a", EstimatorKind::Likelihood);
        let b = answer("stair_a", EstimatorKind::Paper);
        let rows = between(&a, &b);
        assert_eq!(
            (a.scan.status, b.scan.status),
            (Status::Ok, Status::Degraded)
        );
        assert_eq!(row(&rows, "status").second, "degraded");
        assert_eq!(row(&rows, "reason no-promise").first, NONE);
        assert!(b.text().contains("degraded (no-promise): ") && !b.text().contains("valid up to"));
        assert_eq!(row(&rows, "horizon").second, NONE);
        assert_eq!(row(&rows, "confidence").second, NONE);
        assert_eq!(row(&rows, "reason inferred-step").second, NONE);
        assert!(row(&rows, "step 3, height").by.ends_with(" cm"));
    }
}
