//! What a status rests on, as plain values.

use super::reasons::{Reason, Reasons};
use crate::motion::Agreement;

/// All that a status rests on. Empty, it makes a `fault`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Evidence {
    /// What of board, motor or link allowed no scan, or ended it.
    pub faults: Reasons,
    /// Why the chirps can be no answer.
    pub unusable: Option<Reason>,
    /// Signs of the instrument above their limits.
    pub signs: Reasons,
    /// What the scanner knows of the scan beside its chirps.
    pub conditions: Conditions,
    /// What the estimator says; `None` where none has worked.
    pub sight: Option<Sight>,
}

/// The conditions under which a scan was made: known to the scanner, not to its data path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conditions {
    /// Doubts about processor and image that hold until a reset.
    pub board: Reasons,
    /// Whether somebody has said how the scanner is mounted.
    pub configured: bool,
    /// Whether rows were lost.
    pub lost_rows: bool,
}

impl Conditions {
    /// A board without doubts, a known mounting, all rows.
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

/// How far an answer is valid, and how likely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Validity {
    /// Up to where, metres from the mirror.
    pub horizon_m: f32,
    /// Probability that nothing is wrong up to the horizon, or over the first metre where that is farther.
    pub confidence: f32,
    /// Probability that nothing is wrong up to the first step, and that it is there; 1 without steps.
    pub first_step: f32,
}

impl Validity {
    /// Nowhere.
    pub const NONE: Self = Self {
        horizon_m: 0.0,
        confidence: 0.0,
        first_step: 0.0,
    };
}

/// What an estimator says of its answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Whether any echo stands out of the noise for sure.
    pub heard: bool,
    /// How far the answer is valid; `None` if the estimator does not say.
    pub valid: Option<Validity>,
    /// Nearest place of the told drop's edge, [`DropEdge::nearest_m`](crate::answer::DropEdge::nearest_m), metres
    /// from the mirror; `None` if no drop is told.
    pub drop_m: Option<f32>,
    /// Whether the floor, or the first riser's corner, is elsewhere than the mounting says.
    pub astray: bool,
    /// Whether lobes are narrower or broader over the rows than the beam.
    pub stretched: bool,
    /// Whether this sweep and the one before agree.
    pub agreement: Agreement,
    /// What is weak about the answer.
    pub weak: Reasons,
}

impl Sight {
    /// Nothing but noise.
    pub fn nothing(agreement: Agreement) -> Self {
        Self {
            heard: false,
            valid: None,
            drop_m: None,
            astray: false,
            stretched: false,
            agreement,
            weak: Reasons::NONE,
        }
    }
}
