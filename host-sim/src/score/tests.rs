use super::*;
use crate::answer::Answer;
use crate::recording::{TrueStep, Truth};
use stairscan::answer::Direction;
use stairscan::report::{MaybeLine, ScanLine, StepLine, Tenths};
use stairscan::verdict::{Reasons, Status};

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
        part: None,
        horizon_m: None,
        sentences: Vec::new(),
        scan: ScanLine {
            horizon: None,
            confidence: None,
            maybes: 0,
            settings: 0,
            drops: 0,
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
        drop: None,
        maybes: Vec::new(),
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
    assert!(score.matches[0].distance_z.abs() <= 2.0 && score.matches[0].height_z.abs() > 2.0);
    assert_eq!(quantile(&[1.0, 2.0, 3.0, 4.0], 0.5), 2.5);
    assert!(quantile(&[], 0.5).is_nan());
}

/// An answer that vouches for itself up to `horizon_m`.
fn vouching(horizon_m: f64, steps: &[(f64, f64)]) -> Answer {
    Answer {
        horizon_m: Some(horizon_m),
        ..answer(Status::Ok, steps)
    }
}

#[test]
fn wrong_is_what_is_missing_made_up_or_off_up_to_the_horizon() {
    let real = truth(&[(0.6, 0.15), (0.9, 0.30), (1.4, 0.45)], &[(1.8, 0.6)]);
    let wrong = |answer: &Answer| scene(answer, &real).wrong;
    let all = [(0.6, 0.15), (0.9, 0.30), (1.4, 0.45)];
    assert!(!wrong(&answer(Status::Ok, &all)));
    // Without a horizon an answer vouches for everything; with one, for no more than it says.
    assert!(wrong(&answer(Status::Ok, &all[..2])));
    assert!(!wrong(&vouching(1.2, &all[..2])));
    assert!(
        wrong(&vouching(1.38, &all[..2])),
        "within 3 cm of the horizon"
    );
    assert!(wrong(&vouching(1.2, &all[..1])));
    // Made up, before the horizon and behind it.
    let more = [all[0], all[1], (1.15, 0.4)];
    assert!(wrong(&vouching(1.2, &more)));
    assert!(!wrong(&vouching(1.0, &more)));
    // Off in height or distance.
    assert!(wrong(&vouching(1.2, &[(0.6, 0.181), (0.9, 0.30)])));
    assert!(wrong(&vouching(1.2, &[(0.631, 0.15), (0.9, 0.30)])));
    assert!(!wrong(&vouching(1.2, &[(0.629, 0.179), (0.9, 0.30)])));
    assert!(!wrong(&vouching(0.7, &[(0.6, 0.15), (0.95, 0.30)])));
    // A step told just before the end that is the true one just behind it is no invention.
    assert!(!wrong(&vouching(1.35, &[all[0], all[1], (1.37, 0.45)])));
    // Uncounted steps are neither right nor wrong.
    assert!(!wrong(&answer(
        Status::Ok,
        &[all[0], all[1], all[2], (1.8, 0.6)]
    )));
    // No answer is wrong where there is something, and right where there is nothing.
    assert!(wrong(&answer(Status::Fault, &[])));
    assert!(!scene(&answer(Status::Fault, &[]), &truth(&[], &[])).wrong);
    assert!(scene(&answer(Status::Ok, &[(0.6, 0.1)]), &truth(&[], &[])).wrong);
}

#[test]
fn coverage_is_what_lies_within_the_horizon_or_is_reported() {
    let real = truth(&[(0.6, 0.15), (0.9, 0.30), (1.4, 0.45)], &[]);
    let covered = |answer: &Answer| scene(answer, &real).covered;
    assert_eq!(covered(&answer(Status::Ok, &[])), 3);
    assert_eq!(covered(&vouching(0.88, &[])), 2);
    assert_eq!(covered(&vouching(0.5, &[(1.4, 0.45)])), 1);
    assert_eq!(covered(&answer(Status::Fault, &[])), 0);
}

#[test]
fn ok_and_wrong_is_counted_of_what_is_ok() {
    let real = truth(&[(0.6, 0.15)], &[]);
    let scenes = [
        scene(&answer(Status::Ok, &[(0.6, 0.15)]), &real),
        scene(&answer(Status::Ok, &[(0.6, 0.25)]), &real),
        scene(&answer(Status::Degraded, &[(0.6, 0.25)]), &real),
        scene(&answer(Status::Degraded, &[(0.6, 0.15)]), &real),
        scene(&answer(Status::Fault, &[]), &real),
    ];
    let set = SetScore::new("set", scenes.iter());
    assert_eq!((set.exact, set.ok), (Share::new(4, 5), Share::new(2, 5)));
    assert_eq!(set.ok_and_wrong, Share::new(1, 2));
    assert_eq!(set.ok_of_right, Share::new(1, 2));
    assert_eq!(set.covered, Share::new(4, 5));
    assert_eq!(set.json()["ok_horizon_m"], serde_json::Value::Null);
    assert!(confusions(&scenes).contains("ok WRONG"));
}

/// Of 1, 2, … 100 the median's interval is what tables of the sign test give (40 and 61), but for
/// the interpolation between ranks.
#[test]
fn quantiles_have_intervals() {
    let errors: Vec<(f64, f64)> = (0..100).map(|k| (10.0 + f64::from(k), 0.1)).collect();
    let told: Vec<(f64, f64)> = errors
        .iter()
        .zip(1..)
        .map(|(e, k)| (e.0, 0.1 + f64::from(k) * 0.01))
        .collect();
    let score = scene(&answer(Status::Ok, &told), &truth(&errors, &[]));
    let height = SetScore::new("set", [score].iter()).height[0].unwrap();
    assert!((height.median - 0.505).abs() < 1e-3, "{height:?}");
    let (low, high) = height.median_interval;
    assert!(
        (low - 0.40).abs() < 0.02 && (high - 0.61).abs() < 0.02,
        "{height:?}"
    );
    let (low, high) = height.p95_interval;
    assert!(
        low < height.p95 && height.p95 < high && high < 0.995,
        "{height:?}"
    );
}

#[test]
fn confidence_is_held_against_what_it_speaks_of() {
    let real = truth(&[(0.6, 0.15), (0.9, 0.30), (1.4, 0.45)], &[]);
    let told = |mut answer: Answer, permille| {
        answer.scan.confidence = permille;
        scene(&answer, &real).confidence
    };
    let first = &[(0.6, 0.15)];
    // What is missing at 0.9 m is beyond the horizon, but within the first metre.
    let short = vouching(0.7, first);
    assert!(!scene(&short, &real).wrong);
    let so = |so, told| Some(Prediction { told, so });
    assert_eq!(told(short, Some(873)), so(false, 0.873));
    // What is missing at 1.4 m lies beyond both.
    let two = &[(0.6, 0.15), (0.9, 0.30)];
    assert_eq!(told(vouching(0.7, two), Some(995)), so(true, 0.995));
    assert_eq!(told(vouching(1.2, two), Some(995)), so(true, 0.995));
    assert_eq!(told(vouching(1.4, two), Some(995)), so(false, 0.995));
    // Without a horizon it speaks of everything, without a confidence of nothing.
    assert_eq!(told(answer(Status::Ok, two), Some(995)), so(false, 0.995));
    assert_eq!(told(vouching(1.2, two), None), None);
    assert_eq!(told(answer(Status::Fault, &[]), Some(10)), None);
    let mut sure = vouching(1.2, two);
    sure.scan.confidence = Some(995);
    let set = SetScore::new("set", [scene(&sure, &real)].iter());
    let last = &set.json()["confidence"]["bins"][7];
    assert_eq!(last["actual"]["count"], 1);
    assert_eq!(last["predicted_mean"], 0.995);
}

#[test]
fn maybes_are_right_where_something_of_their_kind_stands() {
    let maybes = |status, told: &[(i32, i32)], real: &Truth| {
        let mut answer = answer(status, &[]);
        answer.maybes = (told.iter())
            .map(|&(distance, height)| MaybeLine {
                distance: Tenths(10 * distance),
                height: Tenths(10 * height),
                probability: 250,
                ..MaybeLine::default()
            })
            .collect();
        let told = scene(&answer, real).maybes;
        assert!(told.iter().all(|m| m.told == 0.25));
        told.iter().map(|m| m.so).collect::<Vec<_>>()
    };
    let stairs = truth(&[(0.6, 0.15)], &[(1.8, 0.6)]);
    let told = [(690, 150), (710, 150), (600, -100), (1750, 300)];
    let so = maybes(Status::Degraded, &told, &stairs);
    assert_eq!(so, [true, false, false, true]);
    let drop = truth(&[], &[(0.8, -0.6)]);
    let so = maybes(Status::Degraded, &[(800, -100), (800, 100)], &drop);
    assert_eq!(so, [true, false]);
    assert!(maybes(Status::Fault, &told, &stairs).is_empty());
}

/// Every step matched is not yet right: then it says by how much it is off.
#[test]
fn what_is_wrong_is_told() {
    let told = |answer: &Answer, truth: &Truth| {
        let score = scene(answer, truth);
        let (exact, text) = (score.exact, confusions(&[score]));
        assert!(text.contains("ok WRONG"), "{text}");
        (exact, text)
    };
    let (exact, text) = told(
        &answer(Status::Ok, &[(0.6, 0.1)]),
        &truth(&[(0.6, 0.16)], &[]),
    );
    assert!(exact);
    let words = ": height of the step at 0.60 m off by -6.0 cm (more than 3.0)";
    assert!(text.contains(words), "{text}");
    let (exact, text) = told(&answer(Status::Ok, &[]), &truth(&[], &[(0.8, -0.3)]));
    assert!(
        exact && text.contains(": the ground ends at 0.80 m"),
        "{text}"
    );
    let (_, text) = told(
        &answer(Status::Ok, &[(0.6, 0.1)]),
        &truth(&[(0.9, 0.1)], &[]),
    );
    let words = ": the step at 0.90 m is missing, there is no step at 0.60 m";
    assert!(text.contains(words), "{text}");
}

/// Steps beyond the horizon of an answer that reaches nowhere: there are no steps at all.
#[test]
fn a_false_stair_beyond_the_horizon_is_told() {
    let mut answer = answer(Status::Degraded, &[(0.6, 0.1)]);
    answer.horizon_m = Some(0.0);
    let score = scene(&answer, &truth(&[], &[]));
    assert!(score.wrong);
    assert_eq!(score.flaws, ["there are no steps"]);
}
