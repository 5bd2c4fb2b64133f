//! From evidence to status, horizon, confidence and reasons: the only place that sets a status.
//!
//! In: faults of board, motor and link; the results of [`crate::health`]; the conditions of the scan
//! ([`Conditions`]); the estimator's assessment of its answer ([`Assessment`]). Out: a [`Verdict`]. [`verdict`] is
//! defined for any evidence and starts from a `fault`: missing evidence never leads to an answer.
//!
//! | module | content |
//! |---|---|
//! | [`evidence`] | inputs of a status, as plain values |
//! | [`status`] | evidence → verdict: one function |
//! | [`outcome`] | an answer with its verdict, which only this module can set |
//! | [`guard`] | evidence → result of a guard sweep: one function |
//! | [`reasons`] | table of the reasons: code, meaning, effect, condition |

pub mod evidence;
pub mod guard;
pub mod outcome;
pub mod reasons;
pub mod status;

#[cfg(test)]
mod tests;

pub use evidence::{Assessment, Conditions, Evidence, Validity};
pub use guard::{FreeGround, GuardEvidence, GuardResult, HazardKind, MotionQuality};
pub use outcome::{Outcome, free_m};
pub use reasons::{INSTRUMENT_REASONS, Reason, ReasonEffect, Reasons};
pub use status::{MIN_FIRST_STEP, MIN_HORIZON_M, Status, Verdict, promised, verdict};
