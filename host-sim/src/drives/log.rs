//! Record of a drive, from which [`super::outcome`] is decided.

use stairscan::verdict::Reasons;

use crate::sweeps::score::GuardAnswer;
use crate::sweeps::truth::Hazard;

/// One sweep of a drive, at its last row.
#[derive(Clone, Copy, Debug)]
pub struct SweepLog {
    /// Distance from the mirror to the hazard, metres; `None` without a hazard, and before a person
    /// has stepped in.
    pub hazard_m: Option<f64>,
    /// The scanner's answer.
    pub answer: GuardAnswer,
    /// The answer's reasons.
    pub reasons: Reasons,
    /// Distance up to which the ground's echo shows, metres from the mirror.
    pub ground_echo_range_m: f64,
    /// True speed, m/s.
    pub speed_m_s: f64,
}

impl SweepLog {
    /// Whether the answer is `ok` with a free distance beyond the hazard.
    pub fn is_beyond(&self) -> bool {
        let free = self.answer.free_m.filter(|_| self.answer.is_ok());
        free.zip(self.hazard_m).is_some_and(|(free, at)| free > at)
    }
}

/// Distances at the moment at which a person stepped in.
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
    /// The chair has stood still with the joystick forward.
    Stood,
    /// The chair's foremost point has passed the hazard.
    Passed,
    /// The chair has reached the end of the way.
    Through,
}

/// A drive from beginning to end.
#[derive(Clone, Debug)]
pub struct DriveLog {
    /// Scene and number of the drive.
    pub name: String,
    /// All sweeps of the drive.
    pub sweeps: Vec<SweepLog>,
    /// The first hazard, from the mirror at the first row, if it was there at the end of the drive.
    pub hazard: Option<Hazard>,
    /// Whether that hazard lies beside the beam's axis.
    pub beside: bool,
    /// Distances when a person stepped in; `None` if nobody did.
    pub step_in: Option<StepIn>,
    /// The condition that ended the drive.
    pub end: End,
    /// True travel at the end, metres.
    pub travel_m: f64,
    /// Duration, seconds.
    pub time_s: f64,
}
