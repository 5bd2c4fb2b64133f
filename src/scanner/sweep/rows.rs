//! Definitions that both sweep modes share: state of a row, result of a scan's rows, reasons of its end.

use crate::scanner::mirror::MirrorError;
use crate::signal::radar::module::LinkError;
use crate::time::Micros;
use crate::verdict::Reason;

/// Number of consecutive rows without a chirp after which the scan ends at once: noise on the line loses fewer.
pub(super) const LOST_STREAK: u16 = 8;

/// Margin that is added to every computed deadline, µs: for one pass of the main loop, and for a long listing by
/// `get`.
pub(super) const MARGIN_US: u32 = 100_000;

/// State of a sweep: how far the row that is due has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RowState {
    /// The module's settings are queried; the mirror already moves.
    Configure,
    /// The previous chirp is processed; the mirror moves.
    Work,
    /// The mirror moves.
    Move,
    /// The mirror stands and settles until this time.
    Settle(Micros),
    /// The chirp is awaited; the mirror moves on once it is captured.
    Receive,
    /// The mirror moves to the start of the ramp of a continuous sweep.
    Approach,
    /// The mirror turns, and rows are triggered in passing.
    Turn,
    /// All rows are done; the position is checked at the home switch or with an encoder.
    Prove,
}

/// Result of a sweep: how many of its rows were lost, and why it ended early if it did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rows {
    /// Number of lost rows: those without a chirp.
    pub lost: u16,
    /// Reason for which the scan ended before its last row; `None` if it is complete.
    pub fault: Option<Reason>,
}

/// Returns the reason that reports an error of the link to the radar module.
pub fn link_reason(error: LinkError) -> Reason {
    match error {
        LinkError::Module(_) | LinkError::Answer => Reason::ModuleError,
        LinkError::Unable => Reason::ModuleConfig,
        LinkError::Timeout | LinkError::Frame(_) | LinkError::Sequence => Reason::LinkSilent,
    }
}

/// Returns the reason that reports an error of the mirror's motor.
pub fn mirror_reason(error: MirrorError) -> Reason {
    match error {
        MirrorError::Stall => Reason::MotorStall,
        MirrorError::Driver => Reason::MotorDriver,
        MirrorError::Slipped => Reason::MirrorSlipped,
        MirrorError::Encoder => Reason::EncoderSilent,
        MirrorError::HomeNotFound | MirrorError::NotHomed => Reason::HomeNotFound,
    }
}

/// Returns the later of two times.
pub(super) fn later(a: Micros, b: Micros) -> Micros {
    if a.reached(b) { a } else { b }
}
