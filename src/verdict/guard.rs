//! From evidence to the word of a guard sweep: status, free distance, what ends it, confidence and reasons.
//!
//! It stands beside [`status`](super::status) because a guard sweep has neither steps nor a horizon: what is promised
//! is the free distance alone. Like there, evidence that is missing never makes an answer.

use super::evidence::Conditions;
use super::reasons::{Reason, Reasons};
use super::status::Status;
use crate::drive::{Drive, Input, Mode};

/// Kind of the hazard that ends the free ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ending {
    /// Nothing within the range that the sweep sees.
    None,
    /// A rise that may be a step.
    Rise,
    /// The ground ends or falls.
    Drop,
    /// Something taller than a step, or a wall.
    Obstacle,
    /// Nothing is known of the ground beyond.
    #[default]
    Unknown,
}

impl Ending {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::None,
        Self::Rise,
        Self::Drop,
        Self::Obstacle,
        Self::Unknown,
    ];

    /// The word that stands in a sentence.
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

/// Free ground as the sweep's inference estimates it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeGround {
    /// Free distance, metres from the mirror at the sweep's last row.
    pub free_m: f32,
    /// Kind of the hazard that ends it.
    pub ending: Ending,
    /// Probability that no hazard is nearer.
    pub confidence: f32,
}

/// All that the word of a guard sweep rests on. Empty, it makes a `fault`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GuardEvidence {
    /// Faults of motor or link that ended the sweep.
    pub faults: Reasons,
    /// Why the chirps can be no answer.
    pub unusable: Option<Reason>,
    /// Whether any echo stands out of the noise.
    pub heard: bool,
    /// Signs of the instrument above their limits.
    pub signs: Reasons,
    /// Conditions of the sweep that its chirps do not show.
    pub conditions: Conditions,
    /// Why motion input keeps the word from being `ok`, and whether it was bad.
    pub motion: MotionDoubt,
    /// Result of the inference; `None` where none has worked.
    pub ground: Option<FreeGround>,
}

/// Quality of a sweep's motion input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MotionDoubt {
    /// Nothing.
    #[default]
    Fine,
    /// It was late, damaged or impossible; the sweep was worked off without it.
    Bad,
    /// It is required, and not every row's place is known by it.
    Missing,
}

impl MotionDoubt {
    /// That of a sweep.
    pub fn of(drive: &Drive<'_>) -> Self {
        match (drive.mode, drive.input) {
            (Mode::Standing, _) => Self::Fine,
            (Mode::Required, input) if input != Input::Good => Self::Missing,
            (_, input) if input.is_bad() => Self::Bad,
            _ => Self::Fine,
        }
    }
}

/// The word of one guard sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuardWord {
    status: Status,
    free_m: Option<f32>,
    ending: Ending,
    confidence: f32,
    reasons: Reasons,
}

impl GuardWord {
    /// No answer, for these reasons.
    const fn fault(reasons: Reasons) -> Self {
        Self {
            status: Status::Fault,
            free_m: None,
            ending: Ending::Unknown,
            confidence: 0.0,
            reasons,
        }
    }

    /// The word of a sweep that motor or link ended.
    pub fn broken(reason: Reason) -> Self {
        Self::fault(Reasons::NONE.with(reason))
    }

    /// Returns the word that `evidence` allows: faults of hardware, then of the signal, then no echo; doubts about the
    /// instrument, which leave nothing of the free distance; then what only keeps the word from being `ok`.
    pub fn new(evidence: &GuardEvidence) -> Self {
        let reason = |reason| Self::fault(Reasons::NONE.with(reason));
        let mut word = match (evidence.unusable, evidence.ground) {
            _ if !evidence.faults.is_empty() => Self::fault(evidence.faults),
            (Some(unusable), _) => reason(unusable),
            (None, _) if !evidence.heard => reason(Reason::NoEcho),
            (None, None) => reason(Reason::Silent),
            (None, Some(ground)) => Self {
                status: Status::Ok,
                free_m: Some(crate::math::max(ground.free_m, 0.0)),
                ending: ground.ending,
                confidence: ground.confidence,
                reasons: Reasons::NONE,
            },
        };
        word.doubt(evidence.signs.and(evidence.conditions.board));
        if !evidence.conditions.configured {
            word.doubt(Reasons::NONE.with(Reason::Unconfigured));
        }
        if evidence.conditions.lost_rows {
            word.degrade(Reason::LostRows);
        }
        match evidence.motion {
            MotionDoubt::Fine => {}
            MotionDoubt::Bad => word.reasons.add(Reason::MotionInput),
            MotionDoubt::Missing => word.degrade(Reason::MotionInput),
        }
        word
    }

    /// Takes in doubts about the instrument: nothing of the free distance is left.
    fn doubt(&mut self, doubts: Reasons) {
        self.reasons = self.reasons.and(doubts);
        if !doubts.is_empty() && self.status != Status::Fault {
            self.status = Status::Degraded;
            (self.free_m, self.ending) = (Some(0.0), Ending::Unknown);
            self.confidence = 0.0;
        }
    }

    /// Keeps the word from being `ok`, and leaves its free distance.
    fn degrade(&mut self, reason: Reason) {
        self.reasons.add(reason);
        if self.status == Status::Ok {
            self.status = Status::Degraded;
        }
    }

    /// Takes in that the last full scan has a hazard at `at_m`, metres from where the mirror is now: the nearer counts.
    pub fn limit(&mut self, at_m: f32, ending: Ending) {
        if self.free_m.is_some_and(|free_m| at_m < free_m) {
            (self.free_m, self.ending) = (Some(crate::math::max(at_m, 0.0)), ending);
            self.reasons.add(Reason::ScanNearer);
        }
    }

    /// How far it can be trusted.
    pub fn status(&self) -> Status {
        self.status
    }

    /// Free distance, metres from the mirror at the sweep's last row; `None` of a fault.
    pub fn free_m(&self) -> Option<f32> {
        self.free_m
    }

    /// Kind of the hazard that ends the free ground.
    pub fn ending(&self) -> Ending {
        self.ending
    }

    /// Probability that no hazard is nearer.
    pub fn confidence(&self) -> f32 {
        self.confidence
    }

    /// Why it is not `ok`, and what is weak where it is.
    pub fn reasons(&self) -> Reasons {
        self.reasons
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GROUND: FreeGround = FreeGround {
        free_m: 1.4,
        ending: Ending::Rise,
        confidence: 0.998,
    };

    /// Evidence without a fault or a doubt.
    fn good() -> GuardEvidence {
        GuardEvidence {
            heard: true,
            ground: Some(GROUND),
            ..GuardEvidence::default()
        }
    }

    fn told(evidence: GuardEvidence) -> (Status, Option<f32>, Reasons) {
        let word = GuardWord::new(&evidence);
        (word.status(), word.free_m(), word.reasons())
    }

    #[test]
    fn evidence_that_is_missing_is_a_fault() {
        let of = |reason| (Status::Fault, None, Reasons::NONE.with(reason));
        assert_eq!(told(GuardEvidence::default()), of(Reason::NoEcho));
        let ground = None;
        assert_eq!(told(GuardEvidence { ground, ..good() }), of(Reason::Silent));
        let unusable = Some(Reason::Saturated);
        assert_eq!(
            told(GuardEvidence { unusable, ..good() }),
            of(Reason::Saturated)
        );
        let faults = Reasons::NONE.with(Reason::MotorStall);
        let all = GuardEvidence {
            faults,
            unusable,
            ..good()
        };
        assert_eq!(told(all), of(Reason::MotorStall));
        assert_eq!(GuardWord::broken(Reason::MotorStall), GuardWord::new(&all));
    }

    #[test]
    fn a_doubt_leaves_no_free_distance_and_a_lost_row_all_of_it() {
        assert_eq!(told(good()), (Status::Ok, Some(1.4), Reasons::NONE));
        let signs = Reasons::NONE.with(Reason::Clipped);
        let doubted = told(GuardEvidence { signs, ..good() });
        assert_eq!(doubted, (Status::Degraded, Some(0.0), signs));
        let conditions = Conditions {
            configured: false,
            ..Conditions::GOOD
        };
        let (status, free_m, reasons) = told(GuardEvidence {
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
        assert_eq!(told(lost), (Status::Degraded, Some(1.4), expected));
    }

    #[test]
    fn motion_input_degrades_where_it_is_required() {
        let reasons = Reasons::NONE.with(Reason::MotionInput);
        for (motion, status) in [
            (MotionDoubt::Bad, Status::Ok),
            (MotionDoubt::Missing, Status::Degraded),
        ] {
            let found = told(GuardEvidence { motion, ..good() });
            assert_eq!(found, (status, Some(1.4), reasons));
        }
    }

    #[test]
    fn the_nearer_hazard_counts_and_is_told() {
        let mut word = GuardWord::new(&good());
        word.limit(1.5, Ending::Drop);
        assert_eq!(word, GuardWord::new(&good()));
        word.limit(0.9, Ending::Drop);
        assert_eq!((word.free_m(), word.ending()), (Some(0.9), Ending::Drop));
        assert!(word.status() == Status::Ok && word.reasons().has(Reason::ScanNearer));
        word.limit(-0.1, Ending::Drop);
        assert_eq!(word.free_m(), Some(0.0));
        let mut fault = GuardWord::broken(Reason::MotorStall);
        fault.limit(0.1, Ending::Rise);
        assert_eq!(fault, GuardWord::broken(Reason::MotorStall));
    }
}
