//! Record of a drive: the facts that [`super::outcome`] decides by.

use stairscan::verdict::Reasons;

use crate::sweeps::score::Word;
use crate::sweeps::truth::Hazard;

/// One sweep of a drive, at its last row.
#[derive(Clone, Copy, Debug)]
pub struct SweepLog {
    /// Distance from the mirror to the hazard, metres; none where none is, or nobody has stepped in yet.
    pub hazard_m: Option<f64>,
    /// The scanner's word.
    pub word: Word,
    /// Its reasons.
    pub reasons: Reasons,
    /// How far the ground shows, metres from the mirror.
    pub shows_m: f64,
    /// True speed, m/s.
    pub speed_m_s: f64,
}

impl SweepLog {
    /// Whether the word is `ok` with a free distance beyond the hazard.
    pub fn is_beyond(&self) -> bool {
        let free = self.word.free_m.filter(|_| self.word.is_ok());
        free.zip(self.hazard_m).is_some_and(|(free, at)| free > at)
    }
}

/// How somebody stepped in.
#[derive(Clone, Copy, Debug)]
pub struct StepIn {
    /// From the chair's foremost point, metres.
    pub gap_m: f64,
    /// Stopping distance of the chair, metres: the rest of the sweep under way, a whole one, the word, a cycle, its own
    /// latency and its brakes.
    pub needed_m: f64,
}

/// How a drive ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The chair has stood with the joystick forward.
    Stood,
    /// The foremost point has passed the hazard.
    Passed,
    /// The way has ended.
    Through,
}

/// A drive from beginning to end.
#[derive(Clone, Debug)]
pub struct DriveLog {
    /// Scene and number of the drive.
    pub name: String,
    /// Its sweeps.
    pub sweeps: Vec<SweepLog>,
    /// The first hazard, from the mirror at the first row, if it was there at the end.
    pub hazard: Option<Hazard>,
    /// Whether that lies beside the beam's axis.
    pub beside: bool,
    /// How somebody stepped in.
    pub step_in: Option<StepIn>,
    /// How it ended.
    pub end: End,
    /// True travel then, metres.
    pub travel_m: f64,
    /// Duration, seconds.
    pub time_s: f64,
}
