//! Inputs of a scan's status, as plain values.

use super::reasons::{Reason, Reasons};
use crate::drive::Agreement;

/// All inputs of a scan's status. The default, without any evidence, leads to a `fault`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Evidence {
    /// Faults of board, motor or link that prevented the scan or ended it.
    pub faults: Reasons,
    /// Signal fault that makes the scan's chirps unusable, if there is one.
    pub unusable: Option<Reason>,
    /// Instrument faults: health checks of the signal beyond their limits.
    pub health_faults: Reasons,
    /// Conditions of the scan that its chirps do not show.
    pub conditions: Conditions,
    /// The estimator's assessment of its answer; `None` if no estimator has run.
    pub assessment: Option<Assessment>,
}

/// Conditions of a scan that the scanner knows and its chirps do not show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conditions {
    /// Degrading faults of processor and image, which last until a reset.
    pub board: Reasons,
    /// Whether the mounting has been configured.
    pub configured: bool,
    /// Whether the chirps of any row were lost.
    pub lost_rows: bool,
}

impl Conditions {
    /// No faults of the board, a configured mounting, all rows received.
    pub const GOOD: Self = Self {
        board: Reasons::NONE,
        configured: true,
        lost_rows: false,
    };
}

impl Default for Conditions {
    fn default() -> Self {
        Self::GOOD
    }
}

/// Range and probability for which an answer is valid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Validity {
    /// Horizon, metres from the mirror.
    pub horizon_m: f32,
    /// Probability that the answer is right up to the horizon, or over the first metre if that is farther.
    pub confidence: f32,
    /// Probability that the first step exists and that the answer is right up to it; 1 without steps.
    pub first_step: f32,
}

impl Validity {
    /// An answer that is valid nowhere.
    pub const NONE: Self = Self {
        horizon_m: 0.0,
        confidence: 0.0,
        first_step: 0.0,
    };
}

/// An estimator's assessment of its answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assessment {
    /// Whether any echo is clearly above the noise.
    pub echo_found: bool,
    /// Horizon and confidence; `None` if the estimator computes none.
    pub valid: Option<Validity>,
    /// Nearest position of the reported drop's edge,
    /// [`DropEdge::nearest_m`](crate::answer::DropEdge::nearest_m), metres from the mirror; `None` if no drop
    /// is reported.
    pub drop_m: Option<f32>,
    /// Whether the floor, or the first riser's corner, is not where the mounting puts it.
    pub mounting_off: bool,
    /// Whether the lobes of echoes over the rows are narrower or broader than the beam: the rows are not at their
    /// angles.
    pub lobe_width_off: bool,
    /// Agreement of the scan with the sweep before and with the motion input: whether the chair stood or moved as
    /// reported.
    pub agreement: Agreement,
    /// Reasons that the answer is uncertain; they are reported and leave the status as it is.
    pub weaknesses: Reasons,
}

impl Assessment {
    /// Returns the assessment of a scan with nothing but noise.
    pub fn nothing(agreement: Agreement) -> Self {
        Self {
            echo_found: false,
            valid: None,
            drop_m: None,
            mounting_off: false,
            lobe_width_off: false,
            agreement,
            weaknesses: Reasons::NONE,
        }
    }
}
