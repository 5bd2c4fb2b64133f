//! Score of guard sweeps: the answers on a recording's sweeps, compared with the first hazard of
//! each.
//!
//! The first two sweeps are not counted, because the guard needs several sweeps to confirm an
//! answer.

use std::fmt::Write as _;

use serde_json::{Value, json};
use stairscan::verdict::{HazardKind, Status};

use super::ground::reaches;
use super::truth::{Hazard, Truth};
use crate::answer::metres;
use crate::guarded::Guarded;
use crate::score::{Share, upper_bound};

/// Number of sweeps at the beginning of a recording that are not counted.
const SKIPPED_SWEEPS: usize = 2;
/// Length by which a free distance may exceed the hazard's distance without being wrong, metres:
/// the guard's contract.
const BEYOND_M: f64 = 0.05;
/// Distance that a free distance must reach to be useful where no hazard is nearer, metres.
const USEFUL_RANGE_M: f64 = 1.2;
/// Length by which a useful free distance may fall short of the hazard or of [`USEFUL_RANGE_M`],
/// metres.
const USEFUL_TOLERANCE_M: f64 = 0.25;
/// Distance of a hazard from which on it must be named (reported with its kind), metres.
pub const NEAR_M: f64 = 1.5;
/// Number of sweeps, from the first with a hazard within [`NEAR_M`] on, in one of which the hazard
/// must be named.
const NAMED_WITHIN: usize = 2;

/// The guard's answer on one sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuardAnswer {
    /// Status of the answer.
    pub status: Status,
    /// Free distance from the mirror, metres; `None` for a fault.
    pub free_m: Option<f64>,
    /// Kind of the hazard at which the free distance ends.
    pub ending: HazardKind,
}

impl GuardAnswer {
    /// Takes the status, free distance and hazard of a `GUARD` sentence.
    pub fn of(guarded: &Guarded) -> Self {
        let line = &guarded.line;
        Self {
            status: line.status,
            free_m: line.free.map(metres),
            ending: line.hazard,
        }
    }

    /// Whether the answer's status is `ok`.
    pub fn is_ok(&self) -> bool {
        self.status == Status::Ok
    }

    /// Whether the answer names a hazard by its kind. Rise and obstacle count as the same, because
    /// they differ by height only.
    fn names(&self, hazard: Hazard) -> bool {
        let stands = |ending| matches!(ending, HazardKind::Rise | HazardKind::Obstacle);
        self.ending == hazard.kind || stands(self.ending) && stands(hazard.kind)
    }
}

/// One counted sweep: the guard's answer and the truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// Name of the recording.
    pub recording: String,
    /// Number of the sweep in the recording, from 1.
    pub number: usize,
    /// The true first hazard, with its distance from the mirror; `None` without one.
    pub hazard: Option<Hazard>,
    /// The guard's answer.
    pub answer: GuardAnswer,
    /// Whether the hazard was not there, or at least 20 cm farther, at the previous sweep.
    pub stepped_in: bool,
    /// Distance from the mirror up to which the ground's echo is detectable, metres
    /// ([`super::ground`]).
    pub ground_echo_range_m: f64,
}

impl Sweep {
    /// Whether the answer's status is `ok`.
    pub fn ok(&self) -> bool {
        self.answer.status == Status::Ok
    }

    /// Returns the true distance of the first hazard from the mirror, metres; infinite without one.
    fn hazard_m(&self) -> f64 {
        self.hazard.map_or(f64::INFINITY, |hazard| hazard.at_m)
    }

    /// Whether the answer is `ok` and its free distance ends beyond the hazard, which is wrong. A
    /// hazard that has just stepped in does not count.
    pub fn free_beyond_hazard(&self) -> bool {
        let beyond = |free_m| free_m > self.hazard_m() + BEYOND_M;
        self.ok() && !self.stepped_in && self.answer.free_m.is_some_and(beyond)
    }

    /// Whether the ground's echo is detectable up to the hazard, or up to `USEFUL_RANGE_M` if
    /// that is nearer.
    pub fn has_ground_echo(&self) -> bool {
        reaches(
            self.ground_echo_range_m,
            self.hazard_m().min(USEFUL_RANGE_M),
        )
    }

    /// Whether the answer is `ok`, not wrong, and its free distance reaches the hazard, or
    /// `USEFUL_RANGE_M` if that is nearer, less a tolerance.
    pub fn useful(&self) -> bool {
        let least = self.hazard_m().min(USEFUL_RANGE_M) - USEFUL_TOLERANCE_M;
        self.ok()
            && !self.free_beyond_hazard()
            && self.answer.free_m.is_some_and(|free_m| free_m >= least)
    }

    /// Whether the answer reports a rise or a drop where there is no hazard.
    pub fn false_detection(&self) -> bool {
        self.hazard.is_none() && matches!(self.answer.ending, HazardKind::Rise | HazardKind::Drop)
    }

    /// Whether the true first hazard is within [`NEAR_M`] of the mirror.
    fn near(&self) -> bool {
        self.hazard_m() <= NEAR_M
    }

    /// Returns answer and truth of the sweep in one line of text, lengths in centimetres.
    pub fn text(&self) -> String {
        let cm = |m: Option<f64>| m.map_or("-".into(), |m| format!("{:.1}", 100.0 * m));
        let (hazard, kind) = (self.hazard.map(|h| h.at_m), self.hazard.map(|h| h.kind));
        format!(
            "{} sweep {}: {} free {} cm by {}, hazard {} cm {}",
            self.recording,
            self.number,
            self.answer.status.as_str(),
            cm(self.answer.free_m),
            self.answer.ending.as_str(),
            cm(hazard),
            kind.map_or("none", HazardKind::as_str)
        )
    }
}

/// The score of one recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scored {
    /// The counted sweeps, in order of time.
    pub sweeps: Vec<Sweep>,
    /// Whether the answers named the hazard (reported it with its kind) within two sweeps of its
    /// coming within 1.5 m; `None` if no hazard came so near, or if fewer sweeps follow.
    pub named: Option<bool>,
    /// Whether the ground's echo was detectable up to the hazard at the first sweep with the hazard
    /// within 1.5 m.
    pub named_with_ground_echo: bool,
}

/// Scores the answers on a recording's sweeps. `answers`, `truth` and `ground_echo_range_m`
/// (metres) have one entry per sweep.
pub fn recording(
    name: &str,
    answers: &[GuardAnswer],
    truth: &Truth,
    ground_echo_range_m: &[f64],
) -> Scored {
    let stepped_in = |k: usize| {
        let before = k.checked_sub(1).and_then(|k| truth[k]);
        // The travel between two sweeps is a few centimetres.
        let jumped = |now: Hazard| before.is_none_or(|before| now.at_m < before.at_m - 0.2);
        k > 0 && truth[k].is_some_and(|now| now.at_m <= NEAR_M && jumped(now))
    };
    let all: Vec<Sweep> = (answers.iter().zip(truth).enumerate())
        .map(|(k, (answer, hazard))| Sweep {
            recording: name.to_owned(),
            number: k + 1,
            hazard: *hazard,
            answer: *answer,
            stepped_in: stepped_in(k),
            ground_echo_range_m: ground_echo_range_m.get(k).copied().unwrap_or(0.0),
        })
        .collect();
    let named = all.iter().position(Sweep::near).and_then(|first| {
        let within = all.get(first..first + NAMED_WITHIN)?;
        let named = |sweep: &Sweep| sweep.hazard.is_some_and(|h| sweep.answer.names(h));
        Some(within.iter().any(named))
    });
    let first_near = all.iter().find(|sweep| sweep.near());
    let named_with_ground_echo =
        first_near.is_some_and(|sweep| reaches(sweep.ground_echo_range_m, sweep.hazard_m()));
    let sweeps = all.into_iter().skip(SKIPPED_SWEEPS).collect();
    Scored {
        sweeps,
        named,
        named_with_ground_echo,
    }
}

/// Counts over the recordings of one kind of scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sums {
    /// Number of recordings.
    pub recordings: usize,
    /// Sweeps with a hazard within [`NEAR_M`], of all counted sweeps.
    pub near: Share,
    /// Sweeps with the status `ok`, of all counted sweeps.
    pub ok: Share,
    /// Sweeps whose free distance ends beyond the hazard, which is wrong, of those with the status
    /// `ok`.
    pub free_beyond_hazard: Share,
    /// Sweeps with a useful answer, of all counted sweeps.
    pub useful: Share,
    /// Sweeps with a useful answer, of those in which the ground's echo is detectable up to the
    /// hazard or up to 1.2 m.
    pub useful_with_echo: Share,
    /// Recordings whose hazard is named within two sweeps, of those in which a hazard comes within
    /// [`NEAR_M`].
    pub named: Share,
    /// Recordings whose hazard is named within two sweeps, of those in which the ground's echo is
    /// detectable up to the hazard when it comes within [`NEAR_M`].
    pub named_with_echo: Share,
    /// Sweeps that report a rise or a drop, of those without a true hazard.
    pub false_detection: Share,
}

impl Sums {
    /// Counts over the recordings. Counts of sweeps are over those for which `wanted` holds.
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
            free_beyond_hazard: Share::count(ok, |sweep| sweep.free_beyond_hazard()),
            useful: all(Sweep::useful),
            useful_with_echo: Share::count(sweeps.iter().filter(|s| s.has_ground_echo()), |s| {
                s.useful()
            }),
            named: Share::count(scored.iter().filter_map(|one| one.named), |named| named),
            named_with_echo: {
                let shown = scored.iter().filter(|one| one.named_with_ground_echo);
                Share::count(shown.filter_map(|one| one.named), |named| named)
            },
            false_detection: Share::count(free, |sweep| sweep.false_detection()),
        }
    }

    /// Returns the upper 95 % confidence bound of the share of `ok` sweeps whose free distance ends
    /// beyond the hazard.
    pub fn bound(&self) -> f64 {
        upper_bound(self.free_beyond_hazard.hits, self.free_beyond_hazard.of)
    }

    /// Returns the counts and shares as JSON.
    pub fn json(&self, name: &str) -> Value {
        json!({
            "kind": name,
            "recordings": self.recordings,
            "sweeps": self.near.of,
            "near": self.near.hits,
            "ok": self.ok.json(),
            "ok_and_wrong": self.free_beyond_hazard.json(),
            "ok_and_wrong_bound": self.bound(),
            "useful": self.useful.json(),
            "useful_shown": self.useful_with_echo.json(),
            "named": self.named.json(),
            "named_shown": self.named_with_echo.json(),
            "made_up": self.false_detection.json(),
        })
    }
}

/// Heading, in Markdown, of the table of [`row`]s.
pub const HEADING: &str = "| sweeps of | recordings | sweeps | hazard within 1.5 m | `ok` | `ok`, \
    free beyond the hazard, of `ok` | upper 95 % bound (Clopper-Pearson) | useful | useful, with \
    ground echo | named within two sweeps | named, with ground echo | false rise or drop, without a \
    hazard |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";

/// Returns the table's line, in Markdown, for one kind of scene.
pub fn row(name: &str, sums: &Sums) -> String {
    let mut out = format!(
        "| {name} | {} | {} | {} ",
        sums.recordings, sums.near.of, sums.near.hits
    );
    let bound = match sums.free_beyond_hazard.of {
        0 => "–".into(),
        _ => format!("{:.2} %", 100.0 * sums.bound()),
    };
    let _ = writeln!(
        out,
        "| {} | {} | {bound} | {} | {} of {} | {} | {} | {} |",
        sums.ok.percent(),
        counted(sums.free_beyond_hazard),
        sums.useful.percent(),
        sums.useful_with_echo.percent(),
        sums.useful_with_echo.of,
        counted(sums.named),
        counted(sums.named_with_echo),
        counted(sums.false_detection)
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

    fn answer(free_m: f64, ending: HazardKind) -> GuardAnswer {
        GuardAnswer {
            status: Status::Ok,
            free_m: Some(free_m),
            ending,
        }
    }

    fn rise(at_m: f64) -> Option<Hazard> {
        let kind = HazardKind::Rise;
        Some(Hazard { at_m, kind })
    }

    fn scored(answers: &[GuardAnswer], truth: &[Option<Hazard>]) -> Scored {
        recording("made", answers, &truth.to_vec(), &vec![1.7; truth.len()])
    }

    #[test]
    fn beyond_the_hazard_is_wrong_and_short_of_it_useless() {
        let truth = [rise(1.0); 7];
        let degraded = GuardAnswer {
            status: Status::Degraded,
            ..answer(1.5, HazardKind::None)
        };
        let answers = [
            answer(2.0, HazardKind::None),
            answer(2.0, HazardKind::None),
            answer(1.04, HazardKind::Rise),
            answer(1.06, HazardKind::Rise),
            answer(0.76, HazardKind::Rise),
            answer(0.74, HazardKind::Rise),
            degraded,
        ];
        let found = scored(&answers, &truth);
        // The first two sweeps do not count.
        let free_beyond_hazard: Vec<bool> =
            found.sweeps.iter().map(Sweep::free_beyond_hazard).collect();
        assert_eq!(free_beyond_hazard, [false, true, false, false, false]);
        let useful: Vec<bool> = found.sweeps.iter().map(Sweep::useful).collect();
        assert_eq!(useful, [true, false, true, false, false]);
        assert_eq!(found.named, Some(false));
    }

    #[test]
    fn without_a_hazard_95_cm_are_useful_and_a_rise_is_made_up() {
        let answers = [
            answer(0.96, HazardKind::None),
            answer(0.94, HazardKind::Rise),
        ];
        let answers = [answers[0], answers[0], answers[0], answers[1]];
        let sweeps = scored(&answers, &[None; 4]).sweeps;
        assert!(sweeps[0].useful() && !sweeps[0].false_detection());
        assert!(
            !sweeps[1].useful() && sweeps[1].false_detection() && !sweeps[1].free_beyond_hazard()
        );
    }

    #[test]
    fn who_steps_in_counts_from_the_second_sweep_on() {
        let truth = [None, None, None, rise(0.9), rise(0.88), rise(0.86)];
        let free = answer(1.6, HazardKind::None);
        let seen = answer(0.8, HazardKind::Obstacle);
        let found = scored(&[free, free, free, free, seen, seen], &truth);
        assert!(found.sweeps.iter().all(|sweep| !sweep.free_beyond_hazard()));
        assert_eq!(found.named, Some(true));
        let late = scored(&[free, free, free, free, free, seen], &truth);
        assert_eq!(
            late.sweeps
                .iter()
                .filter(|sweep| sweep.free_beyond_hazard())
                .count(),
            1
        );
        assert_eq!(late.named, Some(false));
    }

    #[test]
    fn a_hazard_that_comes_nearer_with_the_chair_has_not_stepped_in() {
        let truth = [rise(1.56), rise(1.52), rise(1.48), rise(1.44)];
        let sweeps = scored(&[answer(1.7, HazardKind::None); 4], &truth).sweeps;
        assert!(sweeps.iter().all(Sweep::free_beyond_hazard));
    }

    #[test]
    fn sums_count_sweeps_and_recordings() {
        let good = scored(&[answer(0.9, HazardKind::Obstacle); 4], &[rise(1.0); 4]);
        let free = scored(&[answer(1.5, HazardKind::Drop); 3], &[None; 3]);
        let all = Sums::of([good, free].iter(), |_| true);
        assert_eq!((all.recordings, all.near), (2, Share::new(2, 3)));
        assert_eq!(
            (all.ok, all.free_beyond_hazard),
            (Share::new(3, 3), Share::new(0, 3))
        );
        assert_eq!(
            (all.named, all.false_detection),
            (Share::new(1, 1), Share::new(1, 1))
        );
        assert!((all.bound() - 0.632).abs() < 1e-3, "{}", all.bound());
        let row = row("all", &all);
        assert_eq!(row.matches('|').count(), 13);
        assert!(row.contains("| 0/3 | 63.16 % |"), "{row}");
        assert_eq!(all.json("all")["near"], 2);
    }
}
