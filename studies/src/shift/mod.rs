//! Scenes drawn alike with one property moved, and the table of their answers beside those as drawn.

mod properties;

use std::fmt::Write as _;

use host_sim::score::{Change, SceneScore};
use stairscan::verdict::Status;

pub use properties::{NOISE, PROPERTIES, Property, Shift};

/// Greatest probability of losses without a cause at which fewer exact or `ok` answers with less noise are an error.
const CHANCE: f64 = 0.05;

/// First rows of the table.
pub const HEADING: &str = "| property | moved to | scenes | exact | p | `ok` | p | `ok` and wrong |\n\
                           |---|---|---|---|---|---|---|---|\n";

/// The two properties of an answer that are compared: exact, and `ok`.
const COMPARED: [fn(&SceneScore) -> bool; 2] = [|s| s.exact, |s| s.status == Status::Ok];

fn change(before: &[SceneScore], after: &[SceneScore], has: fn(&SceneScore) -> bool) -> Change {
    Change::of(before.iter().zip(after).map(|(a, b)| (has(a), has(b))))
}

/// Adds a row of the table: counts, and their changes against the scenes as drawn.
pub fn row(
    out: &mut String,
    names: [&str; 2],
    scores: &[SceneScore],
    drawn: Option<&[SceneScore]>,
) {
    let cells = COMPARED.map(|has| {
        let count = scores.iter().filter(|s| has(s)).count();
        match drawn.map(|drawn| change(drawn, scores, has)) {
            Some(c) => format!("{count} (+{} −{}) | {:.2}", c.gained, c.lost, c.p()),
            None => format!("{count} | "),
        }
    });
    let wrong = scores.iter().filter(|s| s.ok_and_wrong()).count();
    let _ = writeln!(
        out,
        "| {} | {} | {} | {} | {} | {wrong} |",
        names[0],
        names[1],
        scores.len(),
        cells[0],
        cells[1]
    );
}

/// Returns a line for each scene whose answer is no longer exact or no longer `ok`, with its reasons.
pub fn lost<'a>(
    drawn: &'a [SceneScore],
    moved: &'a [SceneScore],
) -> impl Iterator<Item = String> + 'a {
    let pairs = drawn.iter().zip(moved);
    pairs.filter_map(|(before, after)| {
        let lost = COMPARED.map(|has| has(before) && !has(after));
        let what = match lost {
            [true, _] => "not exact",
            [_, true] => "not ok",
            _ => return None,
        };
        let SceneScore {
            recording,
            reasons,
            horizon_m,
            ..
        } = after;
        Some(format!(
            "{recording}: {what}, {} ({reasons}) up to {horizon_m:.1} m",
            after.status.as_str()
        ))
    })
}

/// Returns what falls from one level of noise, dB, to the next lower one by more than chance.
pub fn falls(levels: &[(f64, Vec<SceneScore>)]) -> Vec<String> {
    let mut falls = Vec::new();
    for pair in levels.windows(2) {
        let [(from, before), (to, after)] = pair else {
            continue;
        };
        for (what, has) in ["exact", "ok"].into_iter().zip(COMPARED) {
            let c = change(before, after, has);
            if c.lost > c.gained && c.p() < CHANCE {
                falls.push(format!(
                    "noise {from} → {to} dB: {what} answers lost {}, gained {} (p = {:.3})",
                    c.lost,
                    c.gained,
                    c.p()
                ));
            }
        }
    }
    falls
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::harness::{Drawn, scored};
    use host_sim::random::Kind;
    use host_sim::replay::Options;

    #[test]
    fn fewer_exact_answers_with_less_noise_are_an_error() {
        let drawn = Drawn {
            kind: Kind::Ascending,
            seed: 1,
        };
        let exact = scored(&drawn.scan().unwrap(), &Options::default()).unwrap();
        assert!(exact.exact);
        let lost = SceneScore {
            exact: false,
            ..exact.clone()
        };
        let levels = |lost_scenes: usize| {
            let after = (0..8).map(|k| if k < lost_scenes { &lost } else { &exact });
            [
                (0.0, vec![exact.clone(); 8]),
                (-12.0, after.cloned().collect()),
            ]
        };
        assert!(falls(&levels(5)).is_empty());
        assert_eq!(falls(&levels(6)).len(), 1);
    }
}
