//! The verdict over all combinations of evidence, and against the table of reasons.

use super::*;
use crate::motion::{Agreement, Finding, Input};
use std::vec::Vec;

fn valid_to(horizon_m: f32) -> Validity {
    let confidence = 0.995;
    Validity {
        horizon_m,
        confidence,
    }
}

/// An estimator's word that makes an `ok`.
fn sure() -> Sight {
    Sight {
        heard: true,
        valid: Some(valid_to(1.4)),
        ..Sight::nothing(Agreement::STANDING)
    }
}

fn seen(sight: Sight) -> Evidence {
    Evidence {
        sight: Some(sight),
        ..Evidence::default()
    }
}

/// One reason, or none.
fn one_of(reason: Reason) -> [Reasons; 2] {
    [Reasons::NONE, Reasons::NONE.with(reason)]
}

/// Every sight that differs in what a verdict looks at.
fn sights() -> Vec<Option<Sight>> {
    let mut sights = Vec::from([None]);
    let findings = [
        Finding::Agreed,
        Finding::Alone,
        Finding::Moved,
        Finding::Missing,
    ];
    for bits in 0_u32..16 {
        let bit = |k: u32| bits >> k & 1 == 1;
        for horizon_m in [None, Some(0.9), Some(LEAST_HORIZON_M)] {
            for finding in findings {
                for input in [Input::Absent, Input::Late] {
                    sights.push(Some(Sight {
                        heard: bit(0),
                        valid: horizon_m.map(valid_to),
                        astray: bit(1),
                        stretched: bit(2),
                        agreement: Agreement { finding, input },
                        weak: one_of(Reason::CloseRival)[usize::from(bit(3))],
                    }));
                }
            }
        }
    }
    sights
}

/// Every evidence that differs in what a verdict looks at.
fn all() -> Vec<Evidence> {
    let mut all = Vec::new();
    for sight in sights() {
        for faults in one_of(Reason::MotorStall) {
            for unusable in [None, Some(Reason::Saturated)] {
                for signs in one_of(Reason::GainDrift) {
                    for bits in 0_u32..8 {
                        let conditions = Conditions {
                            board: one_of(Reason::ImageUnsealed)[(bits & 1) as usize],
                            configured: bits & 2 == 0,
                            lost_rows: bits & 4 != 0,
                        };
                        all.push(Evidence {
                            faults,
                            unusable,
                            signs,
                            conditions,
                            sight,
                        });
                    }
                }
            }
        }
    }
    all
}

/// Whether one of the reasons may have this effect.
fn may(reasons: Reasons, effect: ReasonEffect) -> bool {
    reasons.iter().any(|r| r.effects().contains(&effect))
}

#[test]
fn without_evidence_there_is_no_answer() {
    assert_eq!(verdict(&Evidence::default()), Verdict::SILENT);
    let empty = seen(Sight::nothing(Agreement::STANDING));
    assert_eq!(verdict(&empty).status, Status::Fault);
}

#[test]
fn a_sure_answer_is_ok_up_to_its_horizon() {
    let verdict = verdict(&seen(sure()));
    assert_eq!((verdict.status, verdict.valid), (Status::Ok, sure().valid));
    assert!(verdict.reasons.is_empty());
}

#[test]
fn each_status_has_a_reason_whose_effect_it_is() {
    for evidence in all() {
        let found = verdict(&evidence);
        match found.status {
            Status::Fault => assert!(may(found.reasons, ReasonEffect::Fault), "{evidence:?}"),
            Status::Degraded => assert!(
                may(found.reasons, ReasonEffect::Doubt)
                    || may(found.reasons, ReasonEffect::Degraded),
                "{evidence:?}"
            ),
            Status::Ok => {
                let word = |r: Reason| r.effects().contains(&ReasonEffect::Word);
                assert!(found.reasons.iter().all(word), "{evidence:?}");
            }
        }
    }
}

#[test]
fn a_fault_has_no_horizon_a_doubt_leaves_nothing_of_it_and_an_ok_has_a_metre() {
    for evidence in all() {
        let found = verdict(&evidence);
        let sight = evidence.sight.unwrap_or(sure());
        let conditions = evidence.conditions;
        let doubt = sight.astray
            || sight.stretched
            || !conditions.configured
            || !conditions.board.is_empty()
            || !evidence.signs.is_empty();
        let expected = match (found.status, doubt) {
            (Status::Fault, _) => None,
            (_, true) => sight.valid.map(|_| Validity::NONE),
            (_, false) => sight.valid,
        };
        assert_eq!(found.valid, expected, "{evidence:?}");
        let least = found.valid.map_or(LEAST_HORIZON_M, |v| v.horizon_m);
        assert!(found.status != Status::Ok || least >= LEAST_HORIZON_M);
    }
}

#[test]
fn what_is_decided_by_a_plain_value_has_the_effect_of_the_table() {
    let by = |finding, input| {
        seen(Sight {
            agreement: Agreement { finding, input },
            ..sure()
        })
    };
    let under = |conditions| Evidence {
        conditions,
        ..seen(sure())
    };
    let cases = [
        (Reason::NoEcho, seen(Sight::nothing(Agreement::STANDING))),
        (
            Reason::ShortHorizon,
            seen(Sight {
                valid: Some(valid_to(0.9)),
                ..sure()
            }),
        ),
        (
            Reason::Mount,
            seen(Sight {
                astray: true,
                ..sure()
            }),
        ),
        (
            Reason::AngleJump,
            seen(Sight {
                stretched: true,
                ..sure()
            }),
        ),
        (Reason::Unconfirmed, by(Finding::Alone, Input::Absent)),
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
            (Status::Ok, _) => ReasonEffect::Word,
            (Status::Degraded, Some(0.0)) => ReasonEffect::Doubt,
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
