//! The verdict: status, horizon, confidence and reasons of an answer.
//!
//! In: the evidence of a scan. Out: its verdict, by one function without state.

use super::evidence::{Assessment, Evidence, Validity};
use super::reasons::{Reason, Reasons};
use crate::drive::Finding;

/// Minimum horizon of an `ok` answer, metres, unless the horizon ends at a nearer reported drop. Source: design
/// contract.
pub const MIN_HORIZON_M: f32 = 1.0;

/// Minimum probability of the first step, [`Validity::first_step`], for stairs that begin beyond the horizon in
/// an `ok` answer. Measured on the draw for testing thresholds: of 4,408 `ok` answers 900 have such stairs. 135
/// of these are below the limit, among them 4 of the 5 that report stairs where there are none.
pub const MIN_FIRST_STEP: f32 = 0.9;

/// Permitted use of a scan by a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The answer is valid; zero steps then means that there are no stairs.
    Ok,
    /// The answer is usable, but not `ok`; the reasons say why.
    Degraded,
    /// There is no answer, and never a step; the reasons name the faults.
    Fault,
}

/// Status, validity and reasons of an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// Permitted use of the scan by a controller.
    pub status: Status,
    /// Horizon and confidence; `None` if the estimator computes none.
    pub valid: Option<Validity>,
    /// Reasons that prevent `ok`, and weaknesses of the answer.
    pub reasons: Reasons,
}

/// Returns the verdict on `evidence`. Order of precedence: hardware faults, signal faults, no echo (each a
/// `fault`); instrument faults, which set the horizon to 0; conditions that only prevent `ok`.
pub fn verdict(evidence: &Evidence) -> Verdict {
    let Evidence {
        faults,
        unusable,
        health_faults,
        conditions,
        assessment,
    } = evidence;
    let mut verdict = match (unusable, assessment) {
        _ if !faults.is_empty() => Verdict::fault(*faults),
        (Some(reason), _) => Verdict::fault(Reasons::NONE.with(*reason)),
        (None, None) => Verdict::SILENT,
        (None, Some(assessment)) if !assessment.echo_found => {
            Verdict::fault(Reasons::NONE.with(Reason::NoEcho))
        }
        (None, Some(assessment)) => Verdict::of(assessment),
    };
    verdict.add_instrument_fault(*health_faults);
    verdict.add_instrument_fault(conditions.board);
    if !conditions.configured {
        verdict.add_instrument_fault(Reasons::NONE.with(Reason::Unconfigured));
    }
    if conditions.lost_rows {
        verdict.degrade(Reason::LostRows);
    }
    verdict
}

/// Returns status and reasons of a report as they are to be shown: an `ok` without a horizon, as an image before the reason
/// `no-promise` sent it, is `degraded`.
pub fn promised(status: Status, reasons: Reasons, has_horizon: bool) -> (Status, Reasons) {
    match status {
        Status::Ok if !has_horizon => (Status::Degraded, reasons.with(Reason::NoPromise)),
        _ => (status, reasons),
    }
}

/// Whether the horizon is too short for an `ok`: below [`MIN_HORIZON_M`] and not up to the near edge of a
/// reported drop, or the first step's probability is below [`MIN_FIRST_STEP`].
fn is_short(valid: Validity, drop_m: Option<f32>) -> bool {
    let at_drop = drop_m.is_some_and(|edge| edge > 0.0 && valid.horizon_m >= edge);
    let near = valid.horizon_m < MIN_HORIZON_M && !at_drop;
    near || valid.first_step < MIN_FIRST_STEP
}

impl Verdict {
    /// Verdict without evidence.
    pub const SILENT: Self = Self {
        status: Status::Fault,
        valid: None,
        reasons: Reasons::NONE.with(Reason::Silent),
    };

    /// Returns a verdict without an answer.
    fn fault(reasons: Reasons) -> Self {
        Self {
            reasons,
            ..Self::SILENT
        }
    }

    /// Returns the verdict by the estimator's assessment alone: `ok` if the answer has a horizon that is far enough.
    fn of(assessment: &Assessment) -> Self {
        let mut verdict = Self {
            status: Status::Ok,
            valid: assessment.valid,
            reasons: assessment.weaknesses,
        };
        match assessment.valid {
            None => verdict.degrade(Reason::NoPromise),
            Some(valid) if is_short(valid, assessment.drop_m) => {
                verdict.degrade(Reason::ShortHorizon);
            }
            Some(_) => {}
        }
        if assessment.mounting_off {
            verdict.add_instrument_fault(Reasons::NONE.with(Reason::Mount));
        }
        if assessment.lobe_width_off {
            verdict.add_instrument_fault(Reasons::NONE.with(Reason::AngleJump));
        }
        match assessment.agreement.finding {
            Finding::Agreed => {}
            Finding::Unconfirmed => verdict.degrade(Reason::Unconfirmed),
            Finding::Moved => verdict.degrade(Reason::Moving),
            Finding::Missing => verdict.degrade(Reason::MotionInput),
        }
        if assessment.agreement.input.is_bad() {
            verdict.reasons.add(Reason::MotionInput);
        }
        verdict
    }

    /// Adds instrument faults to the reasons. No estimator can correct its instrument's faults, so with any of them
    /// horizon and confidence become 0, and `ok` becomes `degraded`.
    fn add_instrument_fault(&mut self, faults: Reasons) {
        self.reasons = self.reasons.and(faults);
        if !faults.is_empty() && self.status != Status::Fault {
            self.status = Status::Degraded;
            self.valid = self.valid.map(|_| Validity::NONE);
        }
    }

    /// Adds a reason that makes `ok` `degraded` and keeps the horizon.
    fn degrade(&mut self, reason: Reason) {
        self.reasons.add(reason);
        if self.status == Status::Ok {
            self.status = Status::Degraded;
        }
    }
}
