//! The verdict: status, horizon, confidence and reasons of an answer.

use super::evidence::{Evidence, Sight, Validity};
use super::reasons::{Reason, Reasons};
use crate::motion::Finding;

/// Least horizon of an `ok` answer, metres, unless the horizon ends at a told drop that is nearer: design contract.
pub const LEAST_HORIZON_M: f32 = 1.0;

/// From this probability of the first step on, [`Validity::first_step`], stairs that begin beyond the horizon may stand in
/// an `ok` answer. Of 900 such answers among 4,408 `ok`s of the draw that thresholds are tested on, 135 are less sure, and
/// 4 of the 5 that tell stairs where there are none.
pub const LEAST_FIRST_STEP: f32 = 0.9;

/// What a controller may do with a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Trust it; zero steps then means that there are no stairs.
    Ok,
    /// Usable; the reasons say what is weak.
    Degraded,
    /// No answer; the reasons say why. Never holds steps.
    Fault,
}

/// What an answer is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// How far it can be trusted.
    pub status: Status,
    /// How far it is valid; `None` if the estimator does not say.
    pub valid: Option<Validity>,
    /// Why it is not `ok`, and what is weak where it is.
    pub reasons: Reasons,
}

/// Returns the verdict on `evidence`: faults of hardware, then of the signal, then no echo; doubts about the
/// instrument, which leave nothing of the horizon; then what only keeps an answer from being `ok`.
pub fn verdict(evidence: &Evidence) -> Verdict {
    let Evidence {
        faults,
        unusable,
        signs,
        conditions,
        sight,
    } = evidence;
    let mut verdict = match (unusable, sight) {
        _ if !faults.is_empty() => Verdict::fault(*faults),
        (Some(reason), _) => Verdict::fault(Reasons::NONE.with(*reason)),
        (None, None) => Verdict::SILENT,
        (None, Some(sight)) if !sight.heard => Verdict::fault(Reasons::NONE.with(Reason::NoEcho)),
        (None, Some(sight)) => Verdict::of(sight),
    };
    verdict.doubt(*signs);
    verdict.doubt(conditions.board);
    if !conditions.configured {
        verdict.doubt(Reasons::NONE.with(Reason::Unconfigured));
    }
    if conditions.lost_rows {
        verdict.degrade(Reason::LostRows);
    }
    verdict
}

/// Whether a horizon is too near for an `ok`: below [`LEAST_HORIZON_M`], and not up to the near edge of a told drop; or
/// before stairs that are not sure.
fn is_short(valid: Validity, drop_m: Option<f32>) -> bool {
    let at_drop = drop_m.is_some_and(|edge| edge > 0.0 && valid.horizon_m >= edge);
    let near = valid.horizon_m < LEAST_HORIZON_M && !at_drop;
    near || valid.first_step < LEAST_FIRST_STEP
}

impl Verdict {
    /// Where there is nothing to decide on.
    pub const SILENT: Self = Self {
        status: Status::Fault,
        valid: None,
        reasons: Reasons::NONE.with(Reason::Silent),
    };

    /// No answer.
    fn fault(reasons: Reasons) -> Self {
        Self {
            reasons,
            ..Self::SILENT
        }
    }

    /// On what the estimator says alone: `ok` if its answer is valid far enough.
    fn of(sight: &Sight) -> Self {
        let mut verdict = Self {
            status: Status::Ok,
            valid: sight.valid,
            reasons: sight.weak,
        };
        if sight
            .valid
            .is_some_and(|valid| is_short(valid, sight.drop_m))
        {
            verdict.degrade(Reason::ShortHorizon);
        }
        if sight.astray {
            verdict.doubt(Reasons::NONE.with(Reason::Mount));
        }
        if sight.stretched {
            verdict.doubt(Reasons::NONE.with(Reason::AngleJump));
        }
        match sight.agreement.finding {
            Finding::Agreed => {}
            Finding::Alone => verdict.degrade(Reason::Unconfirmed),
            Finding::Moved => verdict.degrade(Reason::Moving),
            Finding::Missing => verdict.degrade(Reason::MotionInput),
        }
        if sight.agreement.input.is_bad() {
            verdict.reasons.add(Reason::MotionInput);
        }
        verdict
    }

    /// Takes in doubts about the instrument: no estimator knows better than its instrument, so that nothing of the
    /// horizon is left.
    fn doubt(&mut self, doubts: Reasons) {
        self.reasons = self.reasons.and(doubts);
        if !doubts.is_empty() && self.status != Status::Fault {
            self.status = Status::Degraded;
            self.valid = self.valid.map(|_| Validity::NONE);
        }
    }

    /// Keeps the answer from being `ok`, and leaves its horizon.
    fn degrade(&mut self, reason: Reason) {
        self.reasons.add(reason);
        if self.status == Status::Ok {
            self.status = Status::Degraded;
        }
    }
}
