//! Tests of the verdict over all combinations of evidence, and against the table of reasons.

use super::*;
use crate::answer::{Direction, DropEdge, Step};
use crate::motion::{Agreement, Finding, Input};
use std::vec::Vec;

fn valid_to(horizon_m: f32) -> Validity {
    let confidence = 0.995;
    Validity {
        horizon_m,
        confidence,
        first_step: 0.99,
    }
}

/// Returns an estimator's assessment that leads to `ok`.
fn sure() -> Assessment {
    Assessment {
        echo_found: true,
        valid: Some(valid_to(1.4)),
        ..Assessment::nothing(Agreement::STANDING)
    }
}

fn seen(sight: Assessment) -> Evidence {
    Evidence {
        assessment: Some(sight),
        ..Evidence::default()
    }
}

/// Returns two sets of reasons: the empty set, and the set of this one reason.
fn one_of(reason: Reason) -> [Reasons; 2] {
    [Reasons::NONE, Reasons::NONE.with(reason)]
}

/// Pairs of a horizon and a drop's near edge, metres from the mirror: the horizon reaches the drop, ends before it, or
/// one or both are missing.
const HORIZONS_AND_DROPS: [(Option<f32>, Option<f32>); 6] = [
    (None, None),
    (None, Some(0.8)),
    (Some(0.9), None),
    (Some(0.9), Some(0.8)),
    (Some(0.9), Some(0.95)),
    (Some(MIN_HORIZON_M), None),
];

/// Returns no assessment, and assessments in all combinations of the fields that a verdict depends on.
fn sights() -> Vec<Option<Assessment>> {
    let mut sights = Vec::from([None]);
    let findings = [
        Finding::Agreed,
        Finding::Unconfirmed,
        Finding::Moved,
        Finding::Missing,
    ];
    for bits in 0_u32..16 {
        let bit = |k: u32| bits >> k & 1 == 1;
        for (horizon_m, drop_m) in HORIZONS_AND_DROPS {
            for finding in findings {
                for input in [Input::Absent, Input::Late] {
                    sights.push(Some(Assessment {
                        echo_found: bit(0),
                        valid: horizon_m.map(valid_to),
                        drop_m,
                        mounting_off: bit(1),
                        lobe_width_off: bit(2),
                        agreement: Agreement { finding, input },
                        weaknesses: one_of(Reason::CloseRival)[usize::from(bit(3))],
                    }));
                }
            }
        }
    }
    sights
}

/// Returns evidence in all combinations of the fields that a verdict depends on.
fn all() -> Vec<Evidence> {
    let mut all = Vec::new();
    for sight in sights() {
        for faults in one_of(Reason::MotorStall) {
            for unusable in [None, Some(Reason::Saturated)] {
                for health_faults in one_of(Reason::GainDrift) {
                    for bits in 0_u32..8 {
                        let conditions = Conditions {
                            board: one_of(Reason::ImageUnsealed)[(bits & 1) as usize],
                            configured: bits & 2 == 0,
                            lost_rows: bits & 4 != 0,
                        };
                        all.push(Evidence {
                            faults,
                            unusable,
                            health_faults,
                            conditions,
                            assessment: sight,
                        });
                    }
                }
            }
        }
    }
    all
}

/// Whether any reason of the set may have this effect.
fn may(reasons: Reasons, effect: ReasonEffect) -> bool {
    reasons.iter().any(|r| r.effects().contains(&effect))
}

#[test]
fn without_evidence_there_is_no_answer() {
    assert_eq!(verdict(&Evidence::default()), Verdict::SILENT);
    let empty = seen(Assessment::nothing(Agreement::STANDING));
    assert_eq!(verdict(&empty).status, Status::Fault);
}

#[test]
fn a_sure_answer_is_ok_up_to_its_horizon() {
    let verdict = verdict(&seen(sure()));
    assert_eq!((verdict.status, verdict.valid), (Status::Ok, sure().valid));
    assert!(verdict.reasons.is_empty());
}

#[test]
fn every_status_has_a_reason_with_that_effect() {
    for evidence in all() {
        let found = verdict(&evidence);
        match found.status {
            Status::Fault => assert!(may(found.reasons, ReasonEffect::Fault), "{evidence:?}"),
            Status::Degraded => assert!(
                may(found.reasons, ReasonEffect::InstrumentFault)
                    || may(found.reasons, ReasonEffect::Degraded),
                "{evidence:?}"
            ),
            Status::Ok => {
                let word = |r: Reason| r.effects().contains(&ReasonEffect::Info);
                assert!(found.reasons.iter().all(word), "{evidence:?}");
            }
        }
    }
}

#[test]
fn horizon_is_none_for_a_fault_and_zero_for_an_instrument_fault_and_long_enough_for_ok() {
    for evidence in all() {
        let found = verdict(&evidence);
        let sight = evidence.assessment.unwrap_or(sure());
        let conditions = evidence.conditions;
        let doubt = sight.mounting_off
            || sight.lobe_width_off
            || !conditions.configured
            || !conditions.board.is_empty()
            || !evidence.health_faults.is_empty();
        let expected = match (found.status, doubt) {
            (Status::Fault, _) => None,
            (_, true) => sight.valid.map(|_| Validity::NONE),
            (_, false) => sight.valid,
        };
        assert_eq!(found.valid, expected, "{evidence:?}");
        let least = sight
            .drop_m
            .map_or(MIN_HORIZON_M, |edge| edge.min(MIN_HORIZON_M));
        let is_far = found.valid.is_some_and(|v| v.horizon_m >= least);
        assert!(found.status != Status::Ok || is_far, "{evidence:?}");
    }
}

#[test]
fn stairs_beyond_the_horizon_that_are_not_sure_are_no_ok_and_keep_the_horizon() {
    for (first_step, status) in [(0.89, Status::Degraded), (0.9, Status::Ok)] {
        let valid = Some(Validity {
            first_step,
            ..valid_to(1.4)
        });
        let verdict = verdict(&seen(Assessment { valid, ..sure() }));
        assert_eq!(verdict.status, status, "{first_step}");
        let short = verdict.reasons.has(Reason::ShortHorizon);
        assert_eq!(short, status == Status::Degraded);
        assert_eq!(verdict.valid, valid);
    }
}

#[test]
fn a_horizon_that_ends_at_a_nearer_drop_is_not_short() {
    let found = |horizon_m, drop_m| {
        let valid = Some(valid_to(horizon_m));
        let sight = Assessment {
            valid,
            drop_m,
            ..sure()
        };
        verdict(&seen(sight))
    };
    let at_drop = found(0.7, Some(0.7));
    assert!(at_drop.status == Status::Ok && at_drop.reasons.is_empty());
    assert_eq!(at_drop.valid, Some(valid_to(0.7)));
    // Ground between horizon and drop is not free; neither is any if the edge may be behind the mirror.
    for (horizon_m, drop_m) in [(0.7, 0.71), (0.7, 1.2), (0.0, 0.0), (0.1, -0.1)] {
        let short = found(horizon_m, Some(drop_m));
        assert_eq!(short.status, Status::Degraded, "{horizon_m} {drop_m}");
        assert!(short.reasons.has(Reason::ShortHorizon));
    }
}

/// Returns an answer with a step and a drop, on evidence that makes it `ok` up to `horizon_m`.
fn outcome(horizon_m: f32, step_m: Option<f32>, drop: Option<DropEdge>) -> Outcome {
    let mut outcome = Outcome::silent();
    outcome.answer.drop = drop;
    if let Some(distance_m) = step_m {
        outcome.answer.direction = Direction::Up;
        let step = Step {
            distance_m,
            ..Step::default()
        };
        outcome.answer.steps.push(step).unwrap();
    }
    outcome.decide(&seen(Assessment {
        valid: Some(valid_to(horizon_m)),
        drop_m: drop.map(|drop| drop.nearest_m()),
        ..sure()
    }));
    outcome
}

#[test]
fn the_free_distance_ends_at_the_nearest_of_horizon_step_and_drop() {
    let drop = |distance_m| {
        Some(DropEdge {
            distance_m,
            distance_sigma_m: 0.02,
            depth_m: None,
            probability: 0.97,
        })
    };
    let free = |horizon_m, step_m, drop| outcome(horizon_m, step_m, drop).free_m();
    let near = |free: Option<f32>, m: f32| free.is_some_and(|free| (free - m).abs() < 1e-6);
    assert_eq!(free(1.4, None, None), Some(1.4));
    assert_eq!(free(1.4, Some(0.6), None), Some(0.6));
    assert_eq!(free(1.4, Some(1.5), drop(1.6)), Some(1.4));
    assert!(near(free(1.4, None, drop(1.3)), 1.24));
    assert!(near(free(0.7, None, drop(0.76)), 0.7));
    assert!(near(free(1.4, Some(0.9), drop(0.8)), 0.74));
    assert_eq!(free(1.4, Some(-0.1), None), Some(0.0));
    // Not `ok`: the horizon is too near. Without a horizon there is no free distance.
    assert_eq!(free(0.7, None, drop(0.9)), None);
    assert_eq!(free_m(Status::Ok, None, None, None), None);
    assert_eq!(free_m(Status::Degraded, Some(1.4), None, None), None);
    assert_eq!(Outcome::silent().free_m(), None);
}

#[test]
fn fault_clears_the_reported_drop() {
    let mut reported = outcome(1.4, None, Some(DropEdge::default()));
    assert!(reported.answer.drop.is_some());
    reported.decide(&Evidence::default());
    assert_eq!(reported.answer.drop, None);
}

#[test]
fn reasons_from_plain_values_have_the_effect_of_the_table() {
    let by = |finding, input| {
        seen(Assessment {
            agreement: Agreement { finding, input },
            ..sure()
        })
    };
    let under = |conditions| Evidence {
        conditions,
        ..seen(sure())
    };
    let cases = [
        (
            Reason::NoEcho,
            seen(Assessment::nothing(Agreement::STANDING)),
        ),
        (
            Reason::ShortHorizon,
            seen(Assessment {
                valid: Some(valid_to(0.9)),
                ..sure()
            }),
        ),
        (
            Reason::NoPromise,
            seen(Assessment {
                valid: None,
                ..sure()
            }),
        ),
        (
            Reason::Mount,
            seen(Assessment {
                mounting_off: true,
                ..sure()
            }),
        ),
        (
            Reason::AngleJump,
            seen(Assessment {
                lobe_width_off: true,
                ..sure()
            }),
        ),
        (Reason::Unconfirmed, by(Finding::Unconfirmed, Input::Absent)),
        (Reason::Moving, by(Finding::Moved, Input::Good)),
        (Reason::MotionInput, by(Finding::Missing, Input::Absent)),
        (Reason::MotionInput, by(Finding::Agreed, Input::Late)),
        (
            Reason::LostRows,
            under(Conditions {
                lost_rows: true,
                ..Conditions::GOOD
            }),
        ),
        (
            Reason::Unconfigured,
            under(Conditions {
                configured: false,
                ..Conditions::GOOD
            }),
        ),
    ];
    for (reason, evidence) in cases {
        let found = verdict(&evidence);
        assert_eq!(found.reasons, Reasons::NONE.with(reason));
        let effect = match (found.status, found.valid.map(|v| v.horizon_m)) {
            (Status::Ok, _) => ReasonEffect::Info,
            (Status::Degraded, Some(0.0)) => ReasonEffect::InstrumentFault,
            (Status::Degraded, _) => ReasonEffect::Degraded,
            (Status::Fault, _) => ReasonEffect::Fault,
        };
        assert!(
            reason.effects().contains(&effect),
            "{reason:?} is told as {effect:?}"
        );
    }
}

#[test]
fn each_reason_has_a_word_a_condition_and_an_effect() {
    for reason in Reason::ALL {
        assert!(!reason.as_str().is_empty() && !reason.effects().is_empty());
        let condition = reason.condition();
        assert!(condition.ends_with('.'), "{}: {condition}", reason.as_str());
    }
}

/// Returns the status of an assessment in words, with the codes of its reasons.
fn in_words(assessment: Assessment) -> std::string::String {
    let verdict = verdict(&seen(assessment));
    let status = match verdict.status {
        Status::Ok => "ok",
        Status::Degraded => "degraded",
        Status::Fault => "fault",
    };
    let reasons = verdict.reasons.iter().map(Reason::as_str);
    let words: Vec<&str> = core::iter::once(status).chain(reasons).collect();
    words.join(" ")
}

#[test]
fn an_answer_is_ok_from_a_horizon_of_one_metre_on() {
    let to = |horizon_m| {
        in_words(Assessment {
            valid: Some(valid_to(horizon_m)),
            ..sure()
        })
    };
    assert_eq!(to(0.999), "degraded short-horizon");
    assert_eq!(to(1.0), "ok");
}

#[test]
fn an_answer_without_a_horizon_is_never_ok() {
    for evidence in all() {
        let found = verdict(&evidence);
        let is_promised = found.valid.is_some();
        assert!(is_promised || found.status != Status::Ok, "{evidence:?}");
        assert_eq!(
            found.reasons.has(Reason::NoPromise),
            !is_promised && found.status == Status::Degraded,
            "{evidence:?}"
        );
    }
    let as_reported = |status, has_horizon| promised(status, Reasons::NONE, has_horizon);
    assert_eq!(
        as_reported(Status::Ok, false),
        (Status::Degraded, Reasons::NONE.with(Reason::NoPromise))
    );
    for status in [Status::Ok, Status::Degraded, Status::Fault] {
        assert_eq!(as_reported(status, true), (status, Reasons::NONE));
    }
    assert_eq!(
        as_reported(Status::Fault, false),
        (Status::Fault, Reasons::NONE)
    );
}

#[test]
fn a_horizon_below_one_metre_is_ok_where_it_reaches_the_drop() {
    let to = |horizon_m, drop_m| {
        in_words(Assessment {
            valid: Some(valid_to(horizon_m)),
            drop_m: Some(drop_m),
            ..sure()
        })
    };
    assert_eq!(to(0.7, 0.701), "degraded short-horizon");
    assert_eq!(to(0.7, 0.7), "ok");
    // A drop beneath the mirror leaves nothing to be valid for.
    assert_eq!(to(0.0, 0.0), "degraded short-horizon");
}

#[test]
fn an_answer_is_ok_from_a_first_step_of_nine_tenths_on() {
    let with = |first_step| {
        in_words(Assessment {
            valid: Some(Validity {
                first_step,
                ..valid_to(1.4)
            }),
            ..sure()
        })
    };
    assert_eq!(with(0.899), "degraded short-horizon");
    assert_eq!(with(0.9), "ok");
}

#[test]
fn each_condition_that_prevents_ok_is_named() {
    let finding = |finding| {
        in_words(Assessment {
            agreement: Agreement {
                finding,
                input: Input::Absent,
            },
            ..sure()
        })
    };
    assert_eq!(finding(Finding::Agreed), "ok");
    assert_eq!(finding(Finding::Unconfirmed), "degraded unconfirmed");
    assert_eq!(finding(Finding::Moved), "degraded moving");
    assert_eq!(finding(Finding::Missing), "degraded motion-input");
    let mounting_off = true;
    assert_eq!(
        in_words(Assessment {
            mounting_off,
            ..sure()
        }),
        "degraded mount"
    );
    let lobe_width_off = true;
    assert_eq!(
        in_words(Assessment {
            lobe_width_off,
            ..sure()
        }),
        "degraded angle-jump"
    );
    let echo_found = false;
    assert_eq!(
        in_words(Assessment {
            echo_found,
            ..sure()
        }),
        "fault no-echo"
    );
    let weaknesses = Reasons::NONE
        .with(Reason::CloseRival)
        .with(Reason::WeakEchoes);
    assert_eq!(
        in_words(Assessment {
            weaknesses,
            ..sure()
        }),
        "ok close-rival weak-echoes"
    );
}
