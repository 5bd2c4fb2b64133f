//! Score of guard sweeps: the answers on a recording's sweeps, compared with the first hazard of
//! each.
//!
//! The first two sweeps are not counted, because the guard needs several sweeps to confirm an
//! answer.

use std::fmt::Write as _;

use serde_json::{Value, json};
use stairscan::verdict::{Ending, Status};

use super::ground::reaches;
use super::truth::{Hazard, Truth};
use crate::answer::metres;
use crate::guarded::Guarded;
use crate::score::{Share, upper_bound};

/// Number of sweeps at the beginning of a recording that are not counted.
const FIRST: usize = 2;
/// Tolerance beyond the hazard above which a free distance is wrong, metres: the guard's contract.
const BEYOND_M: f64 = 0.05;
/// Distance that a useful free distance has to reach where no hazard is nearer, metres.
const ENOUGH_M: f64 = 1.2;
/// Tolerance by which a useful free distance may fall short of that or of the hazard, metres.
const SHORT_M: f64 = 0.25;
/// Maximum distance of a hazard that must be named, metres.
pub const NEAR_M: f64 = 1.5;
/// Number of sweeps within which it must be named.
const NAMED_WITHIN: usize = 2;

/// The answer on one sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Word {
    /// Status of the answer.
    pub status: Status,
    /// Free distance, metres; `None` of a fault.
    pub free_m: Option<f64>,
    /// Kind of the hazard that ends it.
    pub ending: Ending,
}

impl Word {
    /// Takes the answer of a sentence.
    pub fn of(guarded: &Guarded) -> Self {
        let line = &guarded.line;
        Self {
            status: line.status,
            free_m: line.free.map(metres),
            ending: line.ending,
        }
    }

    /// Whether the status is `ok`.
    pub fn is_ok(&self) -> bool {
        self.status == Status::Ok
    }

    /// Whether the answer names a hazard by its kind. Rise and obstacle count as the same, because
    /// they differ by height only.
    fn names(&self, hazard: Hazard) -> bool {
        let stands = |ending| matches!(ending, Ending::Rise | Ending::Obstacle);
        self.ending == hazard.kind || stands(self.ending) && stands(hazard.kind)
    }
}

/// One counted sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// The recording.
    pub recording: String,
    /// Number of the sweep in the recording, from 1.
    pub number: usize,
    /// The first hazard.
    pub hazard: Option<Hazard>,
    /// The scanner's answer.
    pub word: Word,
    /// Whether the hazard was not there at the previous sweep.
    pub stepped_in: bool,
    /// Distance up to which the ground's echo shows, metres ([`super::ground`]).
    pub shows_m: f64,
}

impl Sweep {
    /// Whether the answer is `ok`.
    pub fn ok(&self) -> bool {
        self.word.status == Status::Ok
    }

    /// Returns the distance of the first hazard, metres; infinite without one.
    fn hazard_m(&self) -> f64 {
        self.hazard.map_or(f64::INFINITY, |hazard| hazard.at_m)
    }

    /// Whether the answer is `ok` and its free distance ends beyond the hazard. A hazard that has
    /// just stepped in does not count.
    pub fn wrong(&self) -> bool {
        let beyond = |free_m| free_m > self.hazard_m() + BEYOND_M;
        self.ok() && !self.stepped_in && self.word.free_m.is_some_and(beyond)
    }

    /// Whether the ground's echo shows up to the hazard, or as far as a chair needs.
    pub fn shows(&self) -> bool {
        reaches(self.shows_m, self.hazard_m().min(ENOUGH_M))
    }

    /// Whether the answer is `ok`, not wrong, and reaches the hazard, or as far as a chair needs,
    /// less a margin.
    pub fn useful(&self) -> bool {
        let least = self.hazard_m().min(ENOUGH_M) - SHORT_M;
        self.ok() && !self.wrong() && self.word.free_m.is_some_and(|free_m| free_m >= least)
    }

    /// Whether a rise or a drop is reported where there is no hazard.
    pub fn made_up(&self) -> bool {
        self.hazard.is_none() && matches!(self.word.ending, Ending::Rise | Ending::Drop)
    }

    /// Whether a hazard is within [`NEAR_M`].
    fn near(&self) -> bool {
        self.hazard_m() <= NEAR_M
    }

    /// Returns the sweep in one line, lengths in centimetres.
    pub fn text(&self) -> String {
        let cm = |m: Option<f64>| m.map_or("-".into(), |m| format!("{:.1}", 100.0 * m));
        let (hazard, kind) = (self.hazard.map(|h| h.at_m), self.hazard.map(|h| h.kind));
        format!(
            "{} sweep {}: {} free {} cm by {}, hazard {} cm {}",
            self.recording,
            self.number,
            self.word.status.as_str(),
            cm(self.word.free_m),
            self.word.ending.as_str(),
            cm(hazard),
            kind.map_or("none", Ending::as_str)
        )
    }
}

/// One recording's score.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scored {
    /// The counted sweeps.
    pub sweeps: Vec<Sweep>,
    /// Whether the hazard was named within two sweeps of coming within 1.5 m; `None` if no hazard
    /// came so near, or if fewer sweeps follow.
    pub named: Option<bool>,
    /// Whether the ground's echo showed up to the hazard then.
    pub named_shows: bool,
}

/// Scores the answers on a recording's sweeps. `words`, `truth` and `shows_m` have one entry per
/// sweep.
pub fn recording(name: &str, words: &[Word], truth: &Truth, shows_m: &[f64]) -> Scored {
    let stepped_in = |k: usize| {
        let before = k.checked_sub(1).and_then(|k| truth[k]);
        // The travel between two sweeps is a few centimetres.
        let jumped = |now: Hazard| before.is_none_or(|before| now.at_m < before.at_m - 0.2);
        k > 0 && truth[k].is_some_and(|now| now.at_m <= NEAR_M && jumped(now))
    };
    let all: Vec<Sweep> = (words.iter().zip(truth).enumerate())
        .map(|(k, (word, hazard))| Sweep {
            recording: name.to_owned(),
            number: k + 1,
            hazard: *hazard,
            word: *word,
            stepped_in: stepped_in(k),
            shows_m: shows_m.get(k).copied().unwrap_or(0.0),
        })
        .collect();
    let named = all.iter().position(Sweep::near).and_then(|first| {
        let within = all.get(first..first + NAMED_WITHIN)?;
        let named = |sweep: &Sweep| sweep.hazard.is_some_and(|h| sweep.word.names(h));
        Some(within.iter().any(named))
    });
    let first_near = all.iter().find(|sweep| sweep.near());
    let named_shows = first_near.is_some_and(|sweep| reaches(sweep.shows_m, sweep.hazard_m()));
    let sweeps = all.into_iter().skip(FIRST).collect();
    Scored {
        sweeps,
        named,
        named_shows,
    }
}

/// Sums over the recordings of one kind.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sums {
    /// Number of recordings.
    pub recordings: usize,
    /// Sweeps with a hazard within [`NEAR_M`], of all counted sweeps.
    pub near: Share,
    /// Sweeps with `ok`, of all counted sweeps.
    pub ok: Share,
    /// Wrong sweeps with `ok`, of those with `ok`.
    pub wrong: Share,
    /// Useful sweeps, of all counted sweeps.
    pub useful: Share,
    /// Useful sweeps, of those in which the ground's echo shows up to the hazard or as far as a
    /// chair needs.
    pub useful_shown: Share,
    /// Recordings whose hazard is named in time, of those in which one comes near.
    pub named: Share,
    /// As `named`, of the recordings in which the ground's echo shows up to the hazard.
    pub named_shown: Share,
    /// Sweeps that report a rise or a drop, of those without a hazard.
    pub made_up: Share,
}

impl Sums {
    /// Sums over recordings, counting the sweeps for which `wanted` holds.
    pub fn of<'a>(
        scored: impl Iterator<Item = &'a Scored>,
        wanted: impl Fn(&Sweep) -> bool,
    ) -> Self {
        let scored: Vec<&Scored> = scored.collect();
        let sweeps: Vec<&Sweep> = (scored.iter().flat_map(|one| &one.sweeps))
            .filter(|sweep| wanted(sweep))
            .collect();
        let all = |so: fn(&Sweep) -> bool| Share::count(&sweeps, |sweep| so(sweep));
        let ok = sweeps.iter().filter(|sweep| sweep.ok());
        let free = sweeps.iter().filter(|sweep| sweep.hazard.is_none());
        Self {
            recordings: scored.len(),
            near: all(Sweep::near),
            ok: all(Sweep::ok),
            wrong: Share::count(ok, |sweep| sweep.wrong()),
            useful: all(Sweep::useful),
            useful_shown: Share::count(sweeps.iter().filter(|s| s.shows()), |s| s.useful()),
            named: Share::count(scored.iter().filter_map(|one| one.named), |named| named),
            named_shown: {
                let shown = scored.iter().filter(|one| one.named_shows);
                Share::count(shown.filter_map(|one| one.named), |named| named)
            },
            made_up: Share::count(free, |sweep| sweep.made_up()),
        }
    }

    /// Returns the upper 95 % bound of the share of `ok` sweeps that are wrong.
    pub fn bound(&self) -> f64 {
        upper_bound(self.wrong.hits, self.wrong.of)
    }

    /// Returns the figures as JSON.
    pub fn json(&self, name: &str) -> Value {
        json!({
            "kind": name,
            "recordings": self.recordings,
            "sweeps": self.near.of,
            "near": self.near.hits,
            "ok": self.ok.json(),
            "ok_and_wrong": self.wrong.json(),
            "ok_and_wrong_bound": self.bound(),
            "useful": self.useful.json(),
            "useful_shown": self.useful_shown.json(),
            "named": self.named.json(),
            "named_shown": self.named_shown.json(),
            "made_up": self.made_up.json(),
        })
    }
}

/// Heading of the table of [`row`]s.
pub const HEADING: &str = "| sweeps of | recordings | sweeps | hazard within 1.5 m | `ok` | `ok`, \
    free beyond the hazard, of `ok` | upper 95 % bound (Clopper-Pearson) | useful | useful, with \
    ground echo | named within two sweeps | named, with ground echo | false rise or drop, without a \
    hazard |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";

/// Returns one line of the table.
pub fn row(name: &str, sums: &Sums) -> String {
    let mut out = format!(
        "| {name} | {} | {} | {} ",
        sums.recordings, sums.near.of, sums.near.hits
    );
    let bound = match sums.wrong.of {
        0 => "–".into(),
        _ => format!("{:.2} %", 100.0 * sums.bound()),
    };
    let _ = writeln!(
        out,
        "| {} | {} | {bound} | {} | {} of {} | {} | {} | {} |",
        sums.ok.percent(),
        counted(sums.wrong),
        sums.useful.percent(),
        sums.useful_shown.percent(),
        sums.useful_shown.of,
        counted(sums.named),
        counted(sums.named_shown),
        counted(sums.made_up)
    );
    out
}

/// Formats a share as `3/120`, or as a dash if it counts nothing.
fn counted(share: Share) -> String {
    match share.of {
        0 => "–".into(),
        _ => format!("{}/{}", share.hits, share.of),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn word(free_m: f64, ending: Ending) -> Word {
        Word {
            status: Status::Ok,
            free_m: Some(free_m),
            ending,
        }
    }

    fn rise(at_m: f64) -> Option<Hazard> {
        let kind = Ending::Rise;
        Some(Hazard { at_m, kind })
    }

    fn scored(words: &[Word], truth: &[Option<Hazard>]) -> Scored {
        recording("made", words, &truth.to_vec(), &vec![1.7; truth.len()])
    }

    #[test]
    fn beyond_the_hazard_is_wrong_and_short_of_it_useless() {
        let truth = [rise(1.0); 7];
        let degraded = Word {
            status: Status::Degraded,
            ..word(1.5, Ending::None)
        };
        let words = [
            word(2.0, Ending::None),
            word(2.0, Ending::None),
            word(1.04, Ending::Rise),
            word(1.06, Ending::Rise),
            word(0.76, Ending::Rise),
            word(0.74, Ending::Rise),
            degraded,
        ];
        let found = scored(&words, &truth);
        // The first two sweeps do not count.
        let wrong: Vec<bool> = found.sweeps.iter().map(Sweep::wrong).collect();
        assert_eq!(wrong, [false, true, false, false, false]);
        let useful: Vec<bool> = found.sweeps.iter().map(Sweep::useful).collect();
        assert_eq!(useful, [true, false, true, false, false]);
        assert_eq!(found.named, Some(false));
    }

    #[test]
    fn without_a_hazard_95_cm_are_useful_and_a_rise_is_made_up() {
        let words = [word(0.96, Ending::None), word(0.94, Ending::Rise)];
        let words = [words[0], words[0], words[0], words[1]];
        let sweeps = scored(&words, &[None; 4]).sweeps;
        assert!(sweeps[0].useful() && !sweeps[0].made_up());
        assert!(!sweeps[1].useful() && sweeps[1].made_up() && !sweeps[1].wrong());
    }

    #[test]
    fn who_steps_in_counts_from_the_second_sweep_on() {
        let truth = [None, None, None, rise(0.9), rise(0.88), rise(0.86)];
        let free = word(1.6, Ending::None);
        let seen = word(0.8, Ending::Obstacle);
        let found = scored(&[free, free, free, free, seen, seen], &truth);
        assert!(found.sweeps.iter().all(|sweep| !sweep.wrong()));
        assert_eq!(found.named, Some(true));
        let late = scored(&[free, free, free, free, free, seen], &truth);
        assert_eq!(late.sweeps.iter().filter(|sweep| sweep.wrong()).count(), 1);
        assert_eq!(late.named, Some(false));
    }

    #[test]
    fn a_hazard_that_comes_nearer_with_the_chair_has_not_stepped_in() {
        let truth = [rise(1.56), rise(1.52), rise(1.48), rise(1.44)];
        let sweeps = scored(&[word(1.7, Ending::None); 4], &truth).sweeps;
        assert!(sweeps.iter().all(Sweep::wrong));
    }

    #[test]
    fn sums_count_sweeps_and_recordings() {
        let good = scored(&[word(0.9, Ending::Obstacle); 4], &[rise(1.0); 4]);
        let free = scored(&[word(1.5, Ending::Drop); 3], &[None; 3]);
        let all = Sums::of([good, free].iter(), |_| true);
        assert_eq!((all.recordings, all.near), (2, Share::new(2, 3)));
        assert_eq!((all.ok, all.wrong), (Share::new(3, 3), Share::new(0, 3)));
        assert_eq!(
            (all.named, all.made_up),
            (Share::new(1, 1), Share::new(1, 1))
        );
        assert!((all.bound() - 0.632).abs() < 1e-3, "{}", all.bound());
        let row = row("all", &all);
        assert_eq!(row.matches('|').count(), 13);
        assert!(row.contains("| 0/3 | 63.16 % |"), "{row}");
        assert_eq!(all.json("all")["near"], 2);
    }
}
