//! What both ways of sweeping share: what a row is at, how a scan's rows went, the reasons of its end.

use crate::scanner::mirror::MirrorError;
use crate::signal::radar::module::LinkError;
use crate::time::Micros;
use crate::verdict::Reason;

/// So many rows in a row without a chirp are no noise on the line: the scan ends at once.
pub(super) const LOST_STREAK: u16 = 8;

/// On top of every computed deadline: the main loop's own grain, a long command listing.
pub(super) const MARGIN_US: u32 = 100_000;

/// What the row that is due is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RowState {
    /// The module is asked what it is set to; the mirror already moves.
    Configure,
    /// The chirp before is worked off; the mirror moves.
    Work,
    /// The mirror moves.
    Move,
    /// The mirror stands and comes to rest.
    Settle(Micros),
    /// The chirp is on its way; the mirror goes on once it is captured.
    Receive,
    /// The mirror goes to where the ramp of a continuous sweep begins.
    Approach,
    /// It turns, and rows are triggered in passing.
    Turn,
    /// All rows are done, and the mirror shows where it is: to the home switch, or to an encoder.
    Prove,
}

/// How a scan's rows went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rows {
    /// Rows whose chirp did not come.
    pub lost: u16,
    /// What ended the scan before its last row.
    pub fault: Option<Reason>,
}

/// The reason that a link's error gives a scan.
pub fn link_reason(error: LinkError) -> Reason {
    match error {
        LinkError::Module(_) | LinkError::Answer => Reason::ModuleError,
        LinkError::Timeout | LinkError::Frame(_) | LinkError::Sequence => Reason::LinkSilent,
    }
}

/// The reason that a motor's error gives a scan.
pub fn mirror_reason(error: MirrorError) -> Reason {
    match error {
        MirrorError::Stall => Reason::MotorStall,
        MirrorError::Driver => Reason::MotorDriver,
        MirrorError::Slipped => Reason::MirrorSlipped,
        MirrorError::Encoder => Reason::EncoderSilent,
        MirrorError::HomeNotFound | MirrorError::NotHomed => Reason::HomeNotFound,
    }
}

/// The later of two moments.
pub(super) fn later(a: Micros, b: Micros) -> Micros {
    if a.reached(b) { a } else { b }
}
