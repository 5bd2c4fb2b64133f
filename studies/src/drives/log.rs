//! Record of a drive, from which [`super::outcome`] is decided.

use stairscan::verdict::Reasons;

use host_sim::sweeps::score::GuardAnswer;
use host_sim::sweeps::truth::Hazard;

/// State of a drive at the last row of one sweep of the guard.
#[derive(Clone, Copy, Debug)]
pub struct SweepLog {
    /// Distance from the mirror to the hazard, metres; `None` without a hazard, and before a person
    /// has stepped in.
    pub hazard_m: Option<f64>,
    /// The guard's answer on this sweep.
    pub answer: GuardAnswer,
    /// Reason codes of the answer.
    pub reasons: Reasons,
    /// Distance from the mirror up to which the ground's echo is detectable, metres
    /// ([`host_sim::sweeps::ground`]).
    pub ground_echo_range_m: f64,
    /// True speed of the chair, m/s.
    pub speed_m_s: f64,
}

impl SweepLog {
    /// Whether the guard's answer on this sweep is `ok` with a free distance that ends beyond the hazard.
    pub fn is_beyond(&self) -> bool {
        let free = self.answer.free_m.filter(|_| self.answer.is_ok());
        free.zip(self.hazard_m).is_some_and(|(free, at)| free > at)
    }
}

/// Gap and stopping distance at the time at which a person stepped in.
#[derive(Clone, Copy, Debug)]
pub struct StepIn {
    /// Distance from the chair's foremost point to the person, metres.
    pub gap_m: f64,
    /// Stopping distance of the chair, metres. It covers the rest of the sweep under way, one whole
    /// sweep, the transfer of the sentence, a control cycle, the chair's latency and its brakes.
    pub needed_m: f64,
}

/// The condition that ended a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The chair has stood still with the joystick forward, or the maximum duration of a drive is
    /// over.
    Stood,
    /// The chair's foremost point has passed the hazard.
    Passed,
    /// The chair has reached the end of the way without passing a hazard.
    Through,
}

/// A drive from beginning to end.
#[derive(Clone, Debug)]
pub struct DriveLog {
    /// Name of the scene and number of the drive through it: `kerb_007-0`.
    pub name: String,
    /// All sweeps of the drive, in order of time.
    pub sweeps: Vec<SweepLog>,
    /// The first hazard, its distance from the mirror at the first row; `None` without one, or if a
    /// person has not stepped in by the end of the drive.
    pub hazard: Option<Hazard>,
    /// Whether [`Self::hazard`] lies beside the beam's axis.
    pub beside: bool,
    /// Gap and stopping distance when a person stepped in; `None` if nobody did.
    pub step_in: Option<StepIn>,
    /// The condition that ended the drive.
    pub end: End,
    /// True travel of the chair at the end of the drive, metres.
    pub travel_m: f64,
    /// Duration of the drive, seconds.
    pub time_s: f64,
}
