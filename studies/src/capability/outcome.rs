//! Rules of counting: when an answer has detected a body, and when it wrongly reports free ground
//! beyond it.

use stairscan::answer::Direction;
use stairscan::verdict::HazardKind;

use host_sim::answer::{Answer, metres};
use host_sim::sweeps::score::GuardAnswer;

use super::body::Body;

/// Maximum distance between a reported step or drop and the body's place for a detection, metres:
/// as in the score.
const AT_PLACE_M: f64 = 0.10;
/// Tolerance by which the free distance may end beyond a body and still count as ending at it, metres: that of the
/// guard's contract.
const BEYOND_M: f64 = 0.05;
/// Number of guard sweeps at the beginning of a recording whose free distance is not counted: as in `cargo study guard`.
const FIRST_SWEEPS: usize = 2;

/// Whether an answer is `ok` and its free distance `free_m` ends more than [`BEYOND_M`] beyond a body, `at_m` metres
/// from the mirror.
fn is_beyond(is_ok: bool, free_m: Option<f64>, at_m: f64) -> bool {
    is_ok && free_m.is_some_and(|free_m| free_m > at_m + BEYOND_M)
}

/// The outcome of one full scan.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScanOutcome {
    /// Whether the answer is `ok`.
    pub ok: bool,
    /// Whether the body is detected: by a step or drop reported at its place, or, where the body needs no name, by a
    /// free distance that ends at or before it.
    pub detected: bool,
    /// Whether the answer is `ok` and its free distance ends more than 5 cm beyond the body.
    pub free_beyond_body: bool,
    /// Whether the scan reports a step or a drop, at any place.
    pub alarm: bool,
    /// Free distance that the scan reports, metres from the mirror; `None` if none is reported.
    pub free_m: Option<f64>,
}

impl ScanOutcome {
    /// Classifies the answer to a scene with `body` at a distance of `at_m` from the mirror, metres.
    pub fn of(answer: &Answer, body: Body, at_m: f64) -> Self {
        let answered = !answer.is_fault();
        let near = |m: f64| (m - at_m).abs() <= AT_PLACE_M;
        let step = answer.steps.iter().any(|step| near(metres(step.distance)));
        let drop = answer
            .drop
            .as_ref()
            .is_some_and(|d| near(metres(d.distance)));
        let falls = answer.scan.direction == Direction::Down;
        let named = match body.ending() {
            None => false,
            Some(HazardKind::Drop) => drop || step && falls,
            Some(_) => step && !falls,
        };
        let free_m = answer.free_m();
        let ends = free_m.is_some_and(|free_m| free_m <= at_m + BEYOND_M);
        let ok = answer.scan.status == stairscan::verdict::Status::Ok;
        Self {
            ok,
            detected: answered && (named || !body.needs_named_detection() && ends),
            free_beyond_body: is_beyond(ok, free_m, at_m),
            alarm: answered && (!answer.steps.is_empty() || answer.drop.is_some()),
            free_m,
        }
    }
}

/// The outcome of consecutive guard sweeps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GuardOutcome {
    /// Whether the answer to the last sweep is `ok`.
    pub ok: bool,
    /// Number (from 1) of the first sweep that names the body and whose free distance ends at or before it, 5 cm
    /// allowed; `None` if no sweep does.
    pub named_at: Option<usize>,
    /// Distance of the body from the mirror at the sweep `named_at`, metres; `None` if no sweep names the body.
    pub named_m: Option<f64>,
    /// Whether any sweep from the third on is `ok` and its free distance ends more than 5 cm beyond the body.
    pub free_beyond_body: bool,
    /// Whether any sweep names a rise, a drop or an obstacle.
    pub alarm: bool,
    /// Free distance that the last sweep reports, metres from the mirror; `None` if it reports none.
    pub free_m: Option<f64>,
}

impl GuardOutcome {
    /// Classifies the answers to consecutive guard sweeps. `at_m` is the distance of `body` at each sweep, metres.
    pub fn of(answers: &[GuardAnswer], body: Body, at_m: &[f64]) -> Self {
        let detects = |(answer, at_m): (&GuardAnswer, &f64)| {
            let ends = answer
                .free_m
                .is_some_and(|free_m| free_m <= at_m + BEYOND_M);
            ends && body.ending().is_some_and(|e| same_hazard(e, answer.ending))
        };
        let mut sweeps = answers.iter().zip(at_m);
        let first = sweeps.clone().position(detects);
        let last = answers.last();
        let beyond =
            |(answer, at_m): (&GuardAnswer, &f64)| is_beyond(is_ok(answer), answer.free_m, *at_m);
        Self {
            ok: last.is_some_and(is_ok),
            named_at: first.map(|k| k + 1),
            named_m: first.and_then(|k| at_m.get(k).copied()),
            free_beyond_body: sweeps.by_ref().skip(FIRST_SWEEPS).any(beyond),
            alarm: answers.iter().any(|answer| names(answer.ending)),
            free_m: last.and_then(|answer| answer.free_m),
        }
    }
}

fn is_ok(answer: &GuardAnswer) -> bool {
    answer.status == stairscan::verdict::Status::Ok
}

/// Whether the end of a free distance is a hazard: a rise, a drop or an obstacle.
fn names(ending: HazardKind) -> bool {
    matches!(
        ending,
        HazardKind::Rise | HazardKind::Drop | HazardKind::Obstacle
    )
}

/// Whether two kinds of hazard count as the same. Rise and obstacle do, because they differ by height only.
fn same_hazard(a: HazardKind, b: HazardKind) -> bool {
    let stands = |e| matches!(e, HazardKind::Rise | HazardKind::Obstacle);
    a == b || stands(a) && stands(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use stairscan::report::Sentence;
    use stairscan::report::sentence::crc32;
    use stairscan::verdict::Status;

    fn sentence(body: &str) -> String {
        format!("${body}*{:08X}", crc32(body))
    }

    /// Parses an answer of these sentences, given without their checksums.
    fn answer(bodies: &[&str]) -> Answer {
        let lines = bodies.iter().map(|body| sentence(body)).collect();
        Answer::parse("made", lines).unwrap()
    }

    fn scan(bodies: &[&str], body: Body) -> ScanOutcome {
        ScanOutcome::of(&answer(bodies), body, 1.0)
    }

    const STEP_AT_95: [&str; 2] = [
        "PSTR,SCAN,1,ok,up,1,0,,1200.0,99.3,0,412B378E,0",
        "PSTR,STEP,1,1,1,950.0,100.0,,100.0,1.5,3.1,100",
    ];

    #[test]
    fn sentences_here_are_whole() {
        for line in STEP_AT_95 {
            Sentence::parse(&sentence(line)).unwrap();
        }
    }

    #[test]
    fn a_step_at_the_place_detects_a_rise_and_no_drop() {
        let found = scan(&STEP_AT_95, Body::Rise(10));
        assert!(found.detected && found.ok && !found.free_beyond_body && found.alarm);
        assert!(!scan(&STEP_AT_95, Body::Drop(10)).detected);
        let far = ScanOutcome::of(&answer(&STEP_AT_95), Body::Rise(10), 1.06);
        assert!(!far.detected && !far.free_beyond_body);
        let near = ScanOutcome::of(&answer(&STEP_AT_95), Body::Rise(10), 0.88);
        assert!(near.detected && near.free_beyond_body);
    }

    #[test]
    fn free_ground_beyond_the_body_is_dangerous_and_before_it_detects_what_has_no_name() {
        let free = |mm: &str, status: &str| {
            let line = format!("PSTR,SCAN,1,{status},none,0,0,,{mm},99.3,0,412B378E,0");
            [Body::Post, Body::Rise(4), Body::Rise(6)].map(|body| scan(&[&line], body))
        };
        let [post, low, rise] = free("1040.0", "ok");
        assert!(post.detected && low.detected && !rise.detected && !rise.free_beyond_body);
        let [post, low, rise] = free("1060.0", "ok");
        assert!(
            !post.detected
                && !low.detected
                && post.free_beyond_body
                && low.free_beyond_body
                && rise.free_beyond_body
        );
        let [post, _, rise] = free("1060.0", "degraded");
        assert!(!post.detected && !post.free_beyond_body && !rise.free_beyond_body && !rise.ok);
    }

    fn sweep(status: Status, free_m: f64, ending: HazardKind) -> GuardAnswer {
        GuardAnswer {
            status,
            free_m: Some(free_m),
            ending,
        }
    }

    #[test]
    fn the_first_sweep_that_ends_and_names_counts() {
        let answers = [
            sweep(Status::Degraded, 0.9, HazardKind::Unknown),
            sweep(Status::Ok, 1.2, HazardKind::Rise),
            sweep(Status::Ok, 1.04, HazardKind::Obstacle),
        ];
        let found = GuardOutcome::of(&answers, Body::Rise(10), &[1.0; 3]);
        assert_eq!((found.named_at, found.free_beyond_body), (Some(3), false));
        assert_eq!(found.named_m, Some(1.0));
        let drop = GuardOutcome::of(&answers, Body::Drop(10), &[1.0; 3]);
        assert_eq!((drop.named_at, drop.alarm), (None, true));
    }

    #[test]
    fn sweeps_are_dangerous_from_the_third_on() {
        let free = sweep(Status::Ok, 1.2, HazardKind::None);
        let found = |n: usize| GuardOutcome::of(&vec![free; n], Body::Post, &vec![1.0; n]);
        assert!(!found(2).free_beyond_body && found(3).free_beyond_body && !found(3).alarm);
        let level = GuardOutcome::of(&[free; 3], Body::Level, &[f64::INFINITY; 3]);
        assert!(level.ok && !level.free_beyond_body && !level.alarm);
    }
}
