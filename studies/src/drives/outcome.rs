//! Outcome of a drive: the record of the drive in, one of five outcomes out, decided by fixed
//! rules.

use super::controller::FRONT_M;
use super::log::{DriveLog, End, SweepLog};
use host_sim::sweeps::ground;

/// Maximum distance from the chair's foremost point to the hazard at which a stop counts as near
/// the hazard, metres.
pub const NEAR_M: f64 = 0.30;
/// Minimum distance from the mirror at which the ground is within the guard's sector, metres: for a
/// mirror 0.4 m high, the last row's 38° plus half a beam below the horizontal. Nearer ground is
/// below the last row's beam.
const IN_SECTOR_M: f64 = 0.47;

/// Reason for which a chair has driven over a hazard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// A person stepped in nearer than the chair can stop.
    SteppedInTooNear,
    /// The ground before the hazard has no detectable echo.
    NoGroundEcho,
    /// The hazard lies beside the beam's axis.
    BesideTheBeam,
    /// The hazard came so near that it lay below the last row's beam, and the free distance grew
    /// again.
    LeftTheSector,
    /// The guard reported a free distance that ends beyond the hazard, and no other cause applies.
    FreeTooFar,
    /// No free distance ended beyond the hazard: the chair itself failed, by its brakes, odometer
    /// or latency.
    Chair,
}

impl Cause {
    /// All causes, in the order of tables.
    pub const ALL: [Self; 6] = [
        Self::SteppedInTooNear,
        Self::NoGroundEcho,
        Self::BesideTheBeam,
        Self::LeftTheSector,
        Self::FreeTooFar,
        Self::Chair,
    ];

    /// Returns the cause as text for tables.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::SteppedInTooNear => "stepped in nearer than the chair can stop",
            Self::NoGroundEcho => "no ground echo before the hazard",
            Self::BesideTheBeam => "beside the beam's axis",
            Self::LeftTheSector => "left the sector below the last row",
            Self::FreeTooFar => "`ok`, free distance beyond the hazard",
            Self::Chair => "within the free distance: chair",
        }
    }
}

/// Outcome of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// The chair's foremost point passed the hazard.
    DroveOver {
        /// Whether the ground's echo was detectable up to the hazard while the chair could still
        /// stop.
        has_ground_echo: bool,
        /// Why the chair did not stop.
        cause: Cause,
    },
    /// The chair stopped at most [`NEAR_M`] before the hazard.
    StoppedNear {
        /// Distance from the chair's foremost point to the hazard, metres.
        gap_m: f64,
    },
    /// The chair stopped more than [`NEAR_M`] before the hazard.
    StoppedEarly {
        /// Distance from the chair's foremost point to the hazard, metres.
        gap_m: f64,
        /// Whether the ground's echo is detectable up to the hazard at the place where the chair
        /// stopped.
        has_ground_echo: bool,
    },
    /// The chair stopped although no hazard was on its way.
    StoppedWithoutHazard,
    /// The chair reached the end of a way without a hazard.
    Completed,
}

impl Outcome {
    /// Decides the outcome of a drive from its record.
    pub fn of(log: &DriveLog) -> Self {
        let gap_m = log
            .hazard
            .map(|hazard| hazard.at_m - FRONT_M - log.travel_m);
        match (log.end, gap_m) {
            (End::Passed, Some(_)) => over(log),
            (End::Stood, Some(gap_m)) if gap_m <= NEAR_M => Self::StoppedNear { gap_m },
            (End::Stood, Some(gap_m)) => Self::StoppedEarly {
                gap_m,
                has_ground_echo: log.sweeps.last().is_some_and(has_ground_echo),
            },
            (End::Stood, None) => Self::StoppedWithoutHazard,
            (End::Through | End::Passed, _) => Self::Completed,
        }
    }
}

/// Whether the ground's echo is detectable up to the hazard at a sweep; false without a hazard.
fn has_ground_echo(sweep: &SweepLog) -> bool {
    let at_m = sweep.hazard_m.unwrap_or(f64::INFINITY);
    ground::reaches(sweep.ground_echo_range_m, at_m)
}

/// Decides the cause of a drive over a hazard. The deciding sweep is the first of the last unbroken
/// run of sweeps whose free distance ends beyond the hazard: by the sentences before that run the
/// chair would have stopped.
fn over(log: &DriveLog) -> Outcome {
    let run = log
        .sweeps
        .iter()
        .rev()
        .take_while(|sweep| sweep.is_beyond());
    let run = run.count();
    let decides = log.sweeps.get(log.sweeps.len() - run).filter(|_| run > 0);
    let in_sector = |sweep: &&SweepLog| sweep.hazard_m.is_some_and(|m| m >= IN_SECTOR_M);
    let seen = decides.filter(in_sector);
    let last = log.sweeps.iter().rev().find(in_sector);
    let has_ground_echo = seen.or(last).is_some_and(has_ground_echo);
    let too_near = log.step_in.is_some_and(|step| step.gap_m < step.needed_m);
    let cause = match decides {
        _ if too_near => Cause::SteppedInTooNear,
        None => Cause::Chair,
        _ if log.beside => Cause::BesideTheBeam,
        _ if seen.is_none() => Cause::LeftTheSector,
        _ if !has_ground_echo => Cause::NoGroundEcho,
        _ => Cause::FreeTooFar,
    };
    Outcome::DroveOver {
        has_ground_echo,
        cause,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drives::log::StepIn;
    use host_sim::sweeps::score::GuardAnswer;
    use host_sim::sweeps::truth::Hazard;
    use stairscan::verdict::{HazardKind, Reasons, Status};

    /// A sweep with a hazard at `at_m`, answer `ok`, a free distance of `free_m` and the ground's
    /// echo detectable up to `ground_echo_range_m`, all metres from the mirror.
    fn sweep(at_m: f64, free_m: f64, ground_echo_range_m: f64) -> SweepLog {
        SweepLog {
            hazard_m: Some(at_m),
            answer: GuardAnswer {
                status: Status::Ok,
                free_m: Some(free_m),
                ending: HazardKind::Rise,
            },
            reasons: Reasons::NONE,
            ground_echo_range_m,
            speed_m_s: 0.4,
        }
    }

    fn log(sweeps: &[SweepLog], end: End, travel_m: f64) -> DriveLog {
        DriveLog {
            name: "made".into(),
            sweeps: sweeps.to_vec(),
            hazard: Some(Hazard {
                at_m: 2.0,
                kind: HazardKind::Rise,
            }),
            beside: false,
            step_in: None,
            end,
            travel_m,
            time_s: 5.0,
        }
    }

    fn cause(log: &DriveLog) -> (bool, Cause) {
        match Outcome::of(log) {
            Outcome::DroveOver {
                has_ground_echo,
                cause,
            } => (has_ground_echo, cause),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_chair_that_stands_is_near_or_early() {
        let sweeps = [sweep(0.6, 0.5, 1.7)];
        let of = |travel_m| Outcome::of(&log(&sweeps, End::Stood, travel_m));
        assert!(matches!(of(1.4), Outcome::StoppedNear { gap_m } if (gap_m - 0.2).abs() < 1e-9));
        assert!(matches!(
            of(1.2),
            Outcome::StoppedEarly {
                has_ground_echo: true,
                ..
            }
        ));
        let free = DriveLog {
            hazard: None,
            ..log(&sweeps, End::Stood, 1.2)
        };
        assert_eq!(Outcome::of(&free), Outcome::StoppedWithoutHazard);
        let through = DriveLog {
            end: End::Through,
            ..free
        };
        assert_eq!(Outcome::of(&through), Outcome::Completed);
    }

    #[test]
    fn the_first_sweep_of_the_last_run_beyond_the_hazard_decides() {
        let short = sweep(0.9, 0.8, 1.7);
        let passed = |sweeps: &[SweepLog]| log(sweeps, End::Passed, 1.6);
        let far = passed(&[short, sweep(0.8, 1.2, 1.7), sweep(0.4, 1.2, 1.7)]);
        assert_eq!(cause(&far), (true, Cause::FreeTooFar));
        let dark = passed(&[short, sweep(0.8, 1.2, 0.6), sweep(0.4, 1.2, 1.7)]);
        assert_eq!(cause(&dark), (false, Cause::NoGroundEcho));
        let left = passed(&[sweep(0.8, 1.2, 1.7), short, sweep(0.45, 1.2, 1.7)]);
        assert_eq!(cause(&left), (true, Cause::LeftTheSector));
        assert_eq!(cause(&passed(&[short])), (true, Cause::Chair));
        let beside = DriveLog {
            beside: true,
            ..far.clone()
        };
        assert_eq!(cause(&beside), (true, Cause::BesideTheBeam));
        let step_in = Some(StepIn {
            gap_m: 0.2,
            needed_m: 0.3,
        });
        let stepped = DriveLog { step_in, ..far };
        assert_eq!(cause(&stepped), (true, Cause::SteppedInTooNear));
    }
}
