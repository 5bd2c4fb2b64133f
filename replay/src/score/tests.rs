use super::*;
use crate::answer::Answer;
use crate::recording::{TrueDrop, TrueStep, Truth};
use stairscan::report::{DropLine, MaybeLine, Tenths};
use stairscan::verdict::Status;

mod answers;

fn tenths(m: f64) -> Tenths {
    Tenths((m * 10_000.0).round() as i32)
}

fn answer(status: Status, steps: &[(f64, f64)]) -> Answer {
    let steps: Vec<_> = steps
        .iter()
        .map(|&(d, h)| (tenths(d).0, tenths(h).0))
        .collect();
    answers::answer(status, &steps)
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
        drops: None,
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
    // Of two reported steps, the farther one is unmatched although it is within 10 cm.
    let score = scene(
        &answer(Status::Ok, &[(0.55, 0.1), (0.62, 0.1)]),
        &truth(&[(0.60, 0.1)], &[]),
    );
    assert_eq!(score.false_steps, [0.55]);
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

/// Returns an `ok` answer with the horizon `horizon_m`.
fn valid_to(horizon_m: f64, steps: &[(f64, f64)]) -> Answer {
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
    // Without a horizon an answer is checked over all distances; otherwise up to the horizon.
    assert!(wrong(&answer(Status::Ok, &all[..2])));
    assert!(!wrong(&valid_to(1.2, &all[..2])));
    assert!(
        wrong(&valid_to(1.38, &all[..2])),
        "within 3 cm of the horizon"
    );
    assert!(wrong(&valid_to(1.2, &all[..1])));
    // A false step, before and behind the horizon.
    let more = [all[0], all[1], (1.15, 0.4)];
    assert!(wrong(&valid_to(1.2, &more)));
    assert!(!wrong(&valid_to(1.0, &more)));
    // Off in height or distance.
    assert!(wrong(&valid_to(1.2, &[(0.6, 0.181), (0.9, 0.30)])));
    assert!(wrong(&valid_to(1.2, &[(0.631, 0.15), (0.9, 0.30)])));
    assert!(!wrong(&valid_to(1.2, &[(0.629, 0.179), (0.9, 0.30)])));
    assert!(!wrong(&valid_to(0.7, &[(0.6, 0.15), (0.95, 0.30)])));
    // A step reported just before the horizon that matches the true one just behind it is not
    // false.
    assert!(!wrong(&valid_to(1.35, &[all[0], all[1], (1.37, 0.45)])));
    // Uncounted steps are neither right nor wrong.
    assert!(!wrong(&answer(
        Status::Ok,
        &[all[0], all[1], all[2], (1.8, 0.6)]
    )));
    // A `fault` is wrong if there are steps, and correct if there are none.
    assert!(wrong(&answer(Status::Fault, &[])));
    assert!(!scene(&answer(Status::Fault, &[]), &truth(&[], &[])).wrong);
    assert!(scene(&answer(Status::Ok, &[(0.6, 0.1)]), &truth(&[], &[])).wrong);
}

#[test]
fn coverage_is_what_lies_within_the_horizon_or_is_reported() {
    let real = truth(&[(0.6, 0.15), (0.9, 0.30), (1.4, 0.45)], &[]);
    let covered = |answer: &Answer| scene(answer, &real).covered;
    assert_eq!(covered(&answer(Status::Ok, &[])), 3);
    assert_eq!(covered(&valid_to(0.88, &[])), 2);
    assert_eq!(covered(&valid_to(0.5, &[(1.4, 0.45)])), 1);
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
    assert_eq!(set.ok_among_correct, Share::new(1, 2));
    assert_eq!(set.covered, Share::new(4, 5));
    assert_eq!(set.json()["ok_horizon_m"], serde_json::Value::Null);
    assert!(confusions(&scenes).contains("ok WRONG"));
}

/// For 1, 2, … 100 the median's interval is that of tables of the sign test (40 and 61), except for
/// the interpolation between ranks.
#[test]
fn quantiles_have_intervals() {
    let errors: Vec<(f64, f64)> = (0..100).map(|k| (10.0 + f64::from(k), 0.1)).collect();
    let reported: Vec<(f64, f64)> = errors
        .iter()
        .zip(1..)
        .map(|(e, k)| (e.0, 0.1 + f64::from(k) * 0.01))
        .collect();
    let score = scene(&answer(Status::Ok, &reported), &truth(&errors, &[]));
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
    let reported = |mut answer: Answer, permille| {
        answer.scan.confidence = permille;
        scene(&answer, &real).confidence
    };
    let first = &[(0.6, 0.15)];
    // The step missing at 0.9 m is beyond the horizon, but within the first metre.
    let short = valid_to(0.7, first);
    assert!(!scene(&short, &real).wrong);
    let so = |outcome, predicted| Some(Prediction { predicted, outcome });
    assert_eq!(reported(short, Some(873)), so(false, 0.873));
    // The step missing at 1.4 m is beyond both.
    let two = &[(0.6, 0.15), (0.9, 0.30)];
    assert_eq!(reported(valid_to(0.7, two), Some(995)), so(true, 0.995));
    assert_eq!(reported(valid_to(1.2, two), Some(995)), so(true, 0.995));
    assert_eq!(reported(valid_to(1.4, two), Some(995)), so(false, 0.995));
    // Without a horizon the confidence applies to all distances; without a confidence there is no
    // prediction.
    assert_eq!(
        reported(answer(Status::Ok, two), Some(995)),
        so(false, 0.995)
    );
    assert_eq!(reported(valid_to(1.2, two), None), None);
    assert_eq!(reported(answer(Status::Fault, &[]), Some(10)), None);
    let mut sure = valid_to(1.2, two);
    sure.scan.confidence = Some(995);
    let set = SetScore::new("set", [scene(&sure, &real)].iter());
    let last = &set.json()["confidence"]["bins"][7];
    assert_eq!(last["actual"]["count"], 1);
    assert_eq!(last["predicted_mean"], 0.995);
}

#[test]
fn maybes_are_right_where_something_of_their_kind_stands() {
    let maybes = |status, reported: &[(i32, i32)], real: &Truth| {
        let mut answer = answer(status, &[]);
        answer.maybes = (reported.iter())
            .map(|&(distance, height)| MaybeLine {
                distance: Tenths(10 * distance),
                height: Tenths(10 * height),
                probability: 250,
                ..MaybeLine::default()
            })
            .collect();
        let reported = scene(&answer, real).maybes;
        assert!(reported.iter().all(|m| m.predicted == 0.25));
        reported.iter().map(|m| m.outcome).collect::<Vec<_>>()
    };
    let stairs = truth(&[(0.6, 0.15)], &[(1.8, 0.6)]);
    let reported = [(690, 150), (710, 150), (600, -100), (1750, 300)];
    let so = maybes(Status::Degraded, &reported, &stairs);
    assert_eq!(so, [true, false, false, true]);
    let drop = truth(&[], &[(0.8, -0.6)]);
    let so = maybes(Status::Degraded, &[(800, -100), (800, 100)], &drop);
    assert_eq!(so, [true, false]);
    assert!(maybes(Status::Fault, &reported, &stairs).is_empty());
}

/// An answer with the horizon `horizon_m` that reports a drop: distance and σ in metres,
/// probability.
fn dropping(status: Status, horizon_m: f64, (at, sigma, probability): (f64, f64, u16)) -> Answer {
    Answer {
        horizon_m: Some(horizon_m),
        drop: Some(DropLine {
            distance: tenths(at),
            distance_sigma: tenths(sigma),
            probability,
            ..DropLine::default()
        }),
        ..answer(status, &[])
    }
}

fn ground_ends_at(places: &[f64]) -> Truth {
    let drop = |&distance_m: &f64| TrueDrop {
        distance_m,
        depth_m: None,
        far_m: None,
    };
    Truth {
        drops: Some(places.iter().map(drop).collect()),
        ..truth(&[], &[])
    }
}

#[test]
fn a_reported_drop_covers_a_true_one_within_10_cm_or_3_sigma() {
    let wrong = |horizon_m, reported, real: &Truth| {
        scene(&dropping(Status::Ok, horizon_m, reported), real).wrong
    };
    let real = ground_ends_at(&[0.9]);
    assert!(scene(&valid_to(0.88, &[]), &real).wrong, "not told");
    assert!(!scene(&valid_to(0.86, &[]), &real).wrong, "beyond the end");
    assert!(!wrong(1.2, (0.81, 0.01, 990), &real));
    assert!(wrong(1.2, (0.79, 0.01, 990), &real));
    assert!(!wrong(1.2, (0.79, 0.04, 990), &real), "3σ are 12 cm");
    // The second of two drops is not covered by the first.
    let two = ground_ends_at(&[0.9, 1.3]);
    assert!(wrong(1.4, (0.9, 0.01, 990), &two) && !wrong(1.2, (0.9, 0.01, 990), &two));
    // A `fault` reports nothing.
    let fault = scene(&dropping(Status::Fault, 1.2, (0.9, 0.01, 990)), &real);
    assert!(fault.wrong && fault.near_drops == Share::new(0, 1));
    // Edges of recordings that list no drops.
    let stairs = truth(&[], &[(0.9, -0.17), (1.2, -0.34)]);
    assert!(!wrong(1.3, (0.92, 0.01, 990), &stairs) && wrong(1.3, (1.2, 0.01, 990), &stairs));
}

#[test]
fn a_drop_that_is_made_up_is_wrong_up_to_the_horizon() {
    let score =
        |horizon_m, reported, real: &Truth| scene(&dropping(Status::Ok, horizon_m, reported), real);
    let none = ground_ends_at(&[]);
    let made_up = score(1.2, (1.1, 0.01, 990), &none);
    assert!(made_up.wrong && made_up.false_drop);
    assert_eq!(made_up.flaws, ["the ground does not end at 1.10 m"]);
    let beyond = score(1.2, (1.24, 0.01, 990), &none);
    assert!(!beyond.wrong && beyond.false_drop);
    let doubtful = score(1.2, (1.24, 0.01, 490), &none);
    assert!(!doubtful.wrong && !doubtful.false_drop);
    // Behind steps, where downward edges are uncounted.
    let behind = truth(&[(0.5, 0.17)], &[(1.1, -0.1)]);
    assert!(!score(0.3, (1.1, 0.01, 990), &behind).false_drop);
    assert!(score(0.3, (0.9, 0.01, 990), &behind).false_drop);
}

#[test]
fn drops_are_counted_where_they_are_near() {
    let real = ground_ends_at(&[0.9, 1.7]);
    let none = ground_ends_at(&[]);
    let scenes = [
        scene(&dropping(Status::Ok, 0.85, (0.9, 0.01, 990)), &real),
        scene(&dropping(Status::Degraded, 0.0, (0.9, 0.01, 490)), &real),
        scene(&dropping(Status::Ok, 1.6, (1.7, 0.01, 990)), &real),
        scene(&dropping(Status::Degraded, 0.0, (1.3, 0.01, 990)), &real),
        scene(&dropping(Status::Degraded, 0.0, (1.3, 0.01, 990)), &none),
        scene(&valid_to(1.2, &[]), &none),
    ];
    let set = SetScore::new("set", scenes.iter());
    assert_eq!(set.reported_drops, Share::new(1, 4));
    assert_eq!((set.drops, set.false_drops), (5, 2));
    assert_eq!(set.false_drops_without, Share::new(1, 2));
    let text = table(std::slice::from_ref(&set));
    let words = "set: drops nearer than 1.6 m reported 1 of 4; false drops 2, 1 of them on 2 scenes without one\n";
    assert!(text.contains(words), "{text}");
    assert_eq!(set.json()["told_drops"]["count"], 1);
    // Two of the `ok` answers report a drop; one of them is wrong.
    let by_type = |kind| {
        set.ok_and_wrong_by_type
            .iter()
            .find(|t| t.0 == kind)
            .unwrap()
            .1
    };
    assert_eq!(by_type(AnswerType::Drop), Share::new(1, 2));
    assert_eq!(by_type(AnswerType::NoSteps), Share::new(0, 1));
    // No line on drops if none is true or reported.
    let quiet = SetScore::new("set", scenes[5..].iter());
    assert!(!table(&[quiet]).contains("drops"));
}

#[test]
fn a_reported_depth_is_held_against_the_drop_that_is_covered() {
    let reported = |at: f64, depth_m: f64| {
        let mut answer = dropping(Status::Ok, 0.5, (at, 0.01, 990));
        answer.drop.as_mut().unwrap().depth = Some(tenths(depth_m));
        answer
    };
    let listed = |depth_m| Truth {
        drops: Some(vec![TrueDrop {
            distance_m: 0.9,
            depth_m,
            far_m: None,
        }]),
        ..truth(&[], &[])
    };
    let stairs = truth(&[], &[(0.9, -0.17), (1.2, -0.34)]);
    let scenes = [
        scene(&reported(0.92, 0.16), &listed(Some(0.15))),
        scene(&reported(0.92, 0.14), &stairs),
        scene(&reported(0.92, 0.16), &listed(None)),
        scene(&reported(0.7, 0.16), &stairs),
        scene(&dropping(Status::Ok, 0.5, (0.9, 0.01, 990)), &stairs),
        scene(&valid_to(0.5, &[]), &stairs),
    ];
    let millimetres = scenes
        .iter()
        .map(|s| s.depth_error_m.map(|m| (1000.0 * m).round()));
    let millimetres: Vec<_> = millimetres.collect();
    assert_eq!(
        millimetres,
        [Some(10.0), Some(-30.0), None, None, None, None]
    );
    let set = SetScore::new("set", scenes.iter());
    assert_eq!(
        (set.depths, set.depths_off),
        (Share::new(4, 5), Share::new(1, 2))
    );
    let text = table(std::slice::from_ref(&set));
    let words = "; depth reported with 4 of 5, error of 2 that cover a true one: median 2.0 cm, 95 % 2.9 cm, \
                 more than 2 cm 1\n";
    assert!(text.contains(words), "{text}");
}

/// If every step is matched but one is off, the text gives the error.
#[test]
fn what_is_wrong_is_reported() {
    let reported = |answer: &Answer, truth: &Truth| {
        let score = scene(answer, truth);
        let (exact, text) = (score.exact, confusions(&[score]));
        assert!(text.contains("ok WRONG"), "{text}");
        (exact, text)
    };
    let (exact, text) = reported(
        &answer(Status::Ok, &[(0.6, 0.1)]),
        &truth(&[(0.6, 0.16)], &[]),
    );
    assert!(exact);
    let words = ": height of the step at 0.60 m off by -6.0 cm (more than 3.0)";
    assert!(text.contains(words), "{text}");
    let (exact, text) = reported(&answer(Status::Ok, &[]), &truth(&[], &[(0.8, -0.3)]));
    assert!(
        exact && text.contains(": the ground ends at 0.80 m"),
        "{text}"
    );
    let (_, text) = reported(
        &answer(Status::Ok, &[(0.6, 0.1)]),
        &truth(&[(0.9, 0.1)], &[]),
    );
    let words = ": the step at 0.90 m is missing, there is no step at 0.60 m";
    assert!(text.contains(words), "{text}");
}

/// Steps beyond the horizon of an answer with horizon 0, in a scene without steps.
#[test]
fn a_false_stair_beyond_the_horizon_is_reported() {
    let mut answer = answer(Status::Degraded, &[(0.6, 0.1)]);
    answer.horizon_m = Some(0.0);
    let score = scene(&answer, &truth(&[], &[]));
    assert!(score.wrong);
    assert_eq!(score.flaws, ["there are no steps"]);
}
