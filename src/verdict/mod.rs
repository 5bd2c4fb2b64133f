//! From evidence to status, horizon, confidence and reasons: the only place that writes a status.
//!
//! In: faults of board, motor and link; the verdict and the doubts of [`crate::health`]; what the scanner knows of the
//! scan ([`Conditions`]); what the estimator says of its answer ([`Sight`]). Out: a [`Verdict`]. [`verdict`] is total,
//! and begins with a `fault`: evidence that is missing never makes an answer.
//!
//! | module | holds |
//! |---|---|
//! | [`evidence`] | what a status rests on, as plain values |
//! | [`status`] | evidence → verdict: one function |
//! | [`outcome`] | an answer with its verdict, which nothing else can write |
//! | [`guard`] | evidence → word of a guard sweep: one function |
//! | [`reasons`] | the table of reasons: word, meaning, effect, condition |

pub mod evidence;
pub mod guard;
pub mod outcome;
pub mod reasons;
pub mod status;

#[cfg(test)]
mod tests;

pub use evidence::{Conditions, Evidence, Sight, Validity};
pub use guard::{Ending, FreeGround, GuardEvidence, GuardWord, MotionDoubt};
pub use outcome::{Outcome, free_m};
pub use reasons::{Reason, ReasonEffect, Reasons};
pub use status::{LEAST_FIRST_STEP, LEAST_HORIZON_M, Status, Verdict, verdict};
