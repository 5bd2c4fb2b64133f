//! From evidence to the result of a guard sweep: status, free distance, hazard that ends it, confidence and
//! reasons.
//!
//! It is apart from [`status`](super::status) because a guard sweep has neither steps nor a horizon: it reports
//! the free distance alone. As there, missing evidence never leads to an answer.

use super::evidence::Conditions;
use super::reasons::{Reason, Reasons};
use super::status::Status;
use crate::drive::{Drive, Input, Mode};

/// Kind of the hazard that ends the free distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HazardKind {
    /// No hazard within the range of the sweep.
    None,
    /// A rise that may be a step.
    Rise,
    /// The ground ends or falls.
    Drop,
    /// An obstacle taller than a step, or a wall.
    Obstacle,
    /// The ground beyond the free distance is unknown.
    #[default]
    Unknown,
}

impl HazardKind {
    /// All kinds of hazard.
    pub const ALL: [Self; 5] = [
        Self::None,
        Self::Rise,
        Self::Drop,
        Self::Obstacle,
        Self::Unknown,
    ];

    /// Returns the word for the kind in a `GUARD` sentence.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Rise => "rise",
            Self::Drop => "drop",
            Self::Obstacle => "obstacle",
            Self::Unknown => "unknown",
        }
    }
}

/// Free ground as estimated by the sweep's inference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeGround {
    /// Free distance, metres from the mirror at the sweep's last row.
    pub free_m: f32,
    /// Kind of the hazard that ends the free distance.
    pub hazard: HazardKind,
    /// Probability that no hazard is nearer than `free_m`.
    pub confidence: f32,
}

/// All inputs of a guard sweep's result. The default, without any evidence, leads to a `fault`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GuardEvidence {
    /// Faults of motor or link that ended the sweep.
    pub faults: Reasons,
    /// Signal fault that makes the sweep's chirps unusable, if there is one.
    pub unusable: Option<Reason>,
    /// Whether any echo of the sweep is above the noise.
    pub echo_found: bool,
    /// Instrument faults: health checks of the signal beyond their limits.
    pub health_faults: Reasons,
    /// Conditions of the sweep that its chirps do not show.
    pub conditions: Conditions,
    /// Quality of the sweep's motion input.
    pub motion: MotionQuality,
    /// Free ground as estimated by the sweep's inference; `None` if it has not run.
    pub ground: Option<FreeGround>,
}

/// Quality of a sweep's motion input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MotionQuality {
    /// The input is good, or none is needed.
    #[default]
    Fine,
    /// The input was late, damaged or impossible; the sweep was processed without it.
    Bad,
    /// The input is required, and does not give every row's position.
    Missing,
}

impl MotionQuality {
    /// Returns the quality of a sweep's motion input.
    pub fn of(drive: &Drive<'_>) -> Self {
        match (drive.mode, drive.input) {
            (Mode::Standing, _) => Self::Fine,
            (Mode::Required, input) if input != Input::Good => Self::Missing,
            (_, input) if input.is_bad() => Self::Bad,
            _ => Self::Fine,
        }
    }
}

/// Result of one guard sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuardResult {
    status: Status,
    free_m: Option<f32>,
    hazard: HazardKind,
    confidence: f32,
    reasons: Reasons,
}

impl GuardResult {
    /// Returns a result without an answer, for these reasons.
    const fn fault(reasons: Reasons) -> Self {
        Self {
            status: Status::Fault,
            free_m: None,
            hazard: HazardKind::Unknown,
            confidence: 0.0,
            reasons,
        }
    }

    /// Returns the result of a sweep that a fault of motor or link ended.
    pub fn broken(reason: Reason) -> Self {
        Self::fault(Reasons::NONE.with(reason))
    }

    /// Returns the result that `evidence` allows. Order of precedence: hardware faults, signal faults, no echo
    /// (each a `fault`); instrument faults, which set the free distance to 0; conditions that only prevent
    /// `ok`.
    pub fn new(evidence: &GuardEvidence) -> Self {
        let reason = |reason| Self::fault(Reasons::NONE.with(reason));
        let mut result = match (evidence.unusable, evidence.ground) {
            _ if !evidence.faults.is_empty() => Self::fault(evidence.faults),
            (Some(unusable), _) => reason(unusable),
            (None, _) if !evidence.echo_found => reason(Reason::NoEcho),
            (None, None) => reason(Reason::Silent),
            (None, Some(ground)) => Self {
                status: Status::Ok,
                free_m: Some(crate::math::max(ground.free_m, 0.0)),
                hazard: ground.hazard,
                confidence: ground.confidence,
                reasons: Reasons::NONE,
            },
        };
        result.add_instrument_fault(evidence.health_faults.and(evidence.conditions.board));
        if !evidence.conditions.configured {
            result.add_instrument_fault(Reasons::NONE.with(Reason::Unconfigured));
        }
        if evidence.conditions.lost_rows {
            result.degrade(Reason::LostRows);
        }
        match evidence.motion {
            MotionQuality::Fine => {}
            MotionQuality::Bad => result.reasons.add(Reason::MotionInput),
            MotionQuality::Missing => result.degrade(Reason::MotionInput),
        }
        result
    }

    /// Adds instrument faults to the reasons: with any, the free distance and the confidence become 0, and `ok` becomes
    /// `degraded`.
    fn add_instrument_fault(&mut self, faults: Reasons) {
        self.reasons = self.reasons.and(faults);
        if !faults.is_empty() && self.status != Status::Fault {
            self.status = Status::Degraded;
            (self.free_m, self.hazard) = (Some(0.0), HazardKind::Unknown);
            self.confidence = 0.0;
        }
    }

    /// Adds a reason that makes `ok` `degraded` and keeps the free distance.
    fn degrade(&mut self, reason: Reason) {
        self.reasons.add(reason);
        if self.status == Status::Ok {
            self.status = Status::Degraded;
        }
    }

    /// Limits the free distance to a hazard of the last full scan at `at_m`, metres from the mirror's present
    /// position, if that is nearer.
    pub fn limit(&mut self, at_m: f32, ending: HazardKind) {
        if self.free_m.is_some_and(|free_m| at_m < free_m) {
            (self.free_m, self.hazard) = (Some(crate::math::max(at_m, 0.0)), ending);
            self.reasons.add(Reason::ScanNearer);
        }
    }

    /// Returns the status of the sweep's result: `ok`, `degraded` or `fault`.
    pub fn status(&self) -> Status {
        self.status
    }

    /// Returns the free distance, metres from the mirror at the sweep's last row; `None` for a fault.
    pub fn free_m(&self) -> Option<f32> {
        self.free_m
    }

    /// Returns the kind of the hazard that ends the free distance.
    pub fn hazard(&self) -> HazardKind {
        self.hazard
    }

    /// Returns the probability that no hazard is nearer than the free distance.
    pub fn confidence(&self) -> f32 {
        self.confidence
    }

    /// Returns the reasons that prevent `ok`, and the weaknesses of the result.
    pub fn reasons(&self) -> Reasons {
        self.reasons
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GROUND: FreeGround = FreeGround {
        free_m: 1.4,
        hazard: HazardKind::Rise,
        confidence: 0.998,
    };

    /// Evidence without any fault.
    fn good() -> GuardEvidence {
        GuardEvidence {
            echo_found: true,
            ground: Some(GROUND),
            ..GuardEvidence::default()
        }
    }

    fn reported(evidence: GuardEvidence) -> (Status, Option<f32>, Reasons) {
        let word = GuardResult::new(&evidence);
        (word.status(), word.free_m(), word.reasons())
    }

    #[test]
    fn evidence_that_is_missing_is_a_fault() {
        let of = |reason| (Status::Fault, None, Reasons::NONE.with(reason));
        assert_eq!(reported(GuardEvidence::default()), of(Reason::NoEcho));
        let ground = None;
        assert_eq!(
            reported(GuardEvidence { ground, ..good() }),
            of(Reason::Silent)
        );
        let unusable = Some(Reason::Saturated);
        assert_eq!(
            reported(GuardEvidence { unusable, ..good() }),
            of(Reason::Saturated)
        );
        let faults = Reasons::NONE.with(Reason::MotorStall);
        let all = GuardEvidence {
            faults,
            unusable,
            ..good()
        };
        assert_eq!(reported(all), of(Reason::MotorStall));
        assert_eq!(
            GuardResult::broken(Reason::MotorStall),
            GuardResult::new(&all)
        );
    }

    #[test]
    fn a_doubt_leaves_no_free_distance_and_a_lost_row_all_of_it() {
        assert_eq!(reported(good()), (Status::Ok, Some(1.4), Reasons::NONE));
        let health_faults = Reasons::NONE.with(Reason::Clipped);
        let doubted = reported(GuardEvidence {
            health_faults,
            ..good()
        });
        assert_eq!(doubted, (Status::Degraded, Some(0.0), health_faults));
        let conditions = Conditions {
            configured: false,
            ..Conditions::GOOD
        };
        let (status, free_m, reasons) = reported(GuardEvidence {
            conditions,
            ..good()
        });
        assert_eq!((status, free_m), (Status::Degraded, Some(0.0)));
        assert!(reasons.has(Reason::Unconfigured));
        let conditions = Conditions {
            lost_rows: true,
            ..Conditions::GOOD
        };
        let lost = GuardEvidence {
            conditions,
            ..good()
        };
        let expected = Reasons::NONE.with(Reason::LostRows);
        assert_eq!(reported(lost), (Status::Degraded, Some(1.4), expected));
    }

    #[test]
    fn motion_input_degrades_where_it_is_required() {
        let reasons = Reasons::NONE.with(Reason::MotionInput);
        for (motion, status) in [
            (MotionQuality::Bad, Status::Ok),
            (MotionQuality::Missing, Status::Degraded),
        ] {
            let found = reported(GuardEvidence { motion, ..good() });
            assert_eq!(found, (status, Some(1.4), reasons));
        }
    }

    #[test]
    fn the_nearer_hazard_counts_and_is_reported() {
        let mut word = GuardResult::new(&good());
        word.limit(1.5, HazardKind::Drop);
        assert_eq!(word, GuardResult::new(&good()));
        word.limit(0.9, HazardKind::Drop);
        assert_eq!(
            (word.free_m(), word.hazard()),
            (Some(0.9), HazardKind::Drop)
        );
        assert!(word.status() == Status::Ok && word.reasons().has(Reason::ScanNearer));
        word.limit(-0.1, HazardKind::Drop);
        assert_eq!(word.free_m(), Some(0.0));
        let mut fault = GuardResult::broken(Reason::MotorStall);
        fault.limit(0.1, HazardKind::Rise);
        assert_eq!(fault, GuardResult::broken(Reason::MotorStall));
    }
}
