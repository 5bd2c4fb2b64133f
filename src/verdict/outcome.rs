//! An answer with its verdict: the content of a scan's report.

use super::evidence::{Conditions, Evidence};
use super::reasons::Reasons;
use super::status::{Status, Verdict, verdict};
use crate::answer::{Answer, DropEdge};

/// Returns the free distance, metres from the mirror: the distance to the nearest of the horizon, the first
/// step (`step_m`) and the drop's [`DropEdge::nearest_m`], over level ground; at least 0.
///
/// Returns `None` if the answer is not `ok` or has no horizon.
pub fn free_m(
    status: Status,
    horizon_m: Option<f32>,
    step_m: Option<f32>,
    drop: Option<&DropEdge>,
) -> Option<f32> {
    let horizon_m = horizon_m.filter(|_| status == Status::Ok)?;
    let ends = [step_m, drop.map(DropEdge::nearest_m)];
    Some(
        ends.into_iter()
            .flatten()
            .fold(horizon_m, f32::min)
            .max(0.0),
    )
}

/// Outcome of one scan: its answer, and the verdict on it.
///
/// ```
/// use stairscan::answer::{Direction, Step};
/// use stairscan::motion::Agreement;
/// use stairscan::verdict::{Assessment, Conditions, Evidence, Outcome, Reason, Reasons, Status, Validity};
///
/// let mut outcome = Outcome::silent();
/// outcome.answer.direction = Direction::Up;
/// outcome.answer.steps.push(Step { distance_m: 0.5, height_m: 0.17, ..Step::default() }).unwrap();
/// assert_eq!(outcome.status(), Status::Fault);
///
/// let valid = Some(Validity { horizon_m: 1.2, confidence: 0.995, first_step: 0.99 });
/// let assessment = Assessment { echo_found: true, valid, ..Assessment::nothing(Agreement::STANDING) };
/// outcome.decide(&Evidence { assessment: Some(assessment), ..Evidence::default() });
/// assert!(outcome.status() == Status::Ok && outcome.reasons().is_empty());
///
/// let fault = Outcome::broken(Reasons::NONE.with(Reason::MotorStall), Conditions::GOOD);
/// assert!(fault.status() == Status::Fault && fault.answer.steps.is_empty());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Steps and drop ahead.
    pub answer: Answer,
    verdict: Verdict,
}

impl Outcome {
    /// An outcome without an answer: a `fault` (`silent`) until [`Outcome::decide`].
    pub const fn silent() -> Self {
        Self {
            answer: Answer::NONE,
            verdict: Verdict::SILENT,
        }
    }

    /// Returns the outcome of a scan that a hardware fault prevented or ended.
    pub fn broken(faults: Reasons, conditions: Conditions) -> Self {
        let mut outcome = Self::silent();
        outcome.decide(&Evidence {
            faults,
            conditions,
            ..Evidence::default()
        });
        outcome
    }

    /// Sets the verdict from `evidence`. A `fault` clears the answer.
    #[inline(never)]
    pub fn decide(&mut self, evidence: &Evidence) {
        self.verdict = verdict(evidence);
        if self.verdict.status == Status::Fault {
            self.answer.clear();
        }
    }

    /// Returns the status of the scan's answer: `ok`, `degraded` or `fault`.
    pub fn status(&self) -> Status {
        self.verdict.status
    }

    /// Returns the reasons that prevent `ok`, and the weaknesses of the answer.
    pub fn reasons(&self) -> Reasons {
        self.verdict.reasons
    }

    /// Returns the horizon, metres from the mirror. `None` if the estimator computes none; the answer is then never `ok`.
    pub fn horizon_m(&self) -> Option<f32> {
        self.verdict.valid.map(|valid| valid.horizon_m)
    }

    /// Returns the free distance, metres from the mirror: [`free_m`] of status, horizon and answer.
    pub fn free_m(&self) -> Option<f32> {
        let first = self.answer.steps.first().map(|step| step.distance_m);
        free_m(
            self.status(),
            self.horizon_m(),
            first,
            self.answer.drop.as_ref(),
        )
    }

    /// Returns the probability that the answer is right up to the horizon, or over the first metre if that is
    /// farther; `None` if the estimator computes none.
    pub fn confidence(&self) -> Option<f32> {
        self.verdict.valid.map(|valid| valid.confidence)
    }
}
