//! Motion of the chair: motion sentences of its controller, and a check of them by two sweeps.
//!
//! The results are given in the types of [`crate::drive`] and [`crate::track`]. With them
//! [`MotionCompensation`] moves echoes to where they lie as seen from the chair's last position.
//!
//! | module | from → to |
//! |---|---|
//! | [`odometry`] | motion sentences → checked, interpolated to each row's mid chirp |
//! | [`odometer`] | errors of the odometer → tolerance between two sweeps |
//! | [`sweeps`] | echoes of this sweep and of the one before → whether the chair stands, or moves as reported |

pub mod odometer;
pub mod odometry;
pub mod sweeps;

#[cfg(test)]
mod tests;

pub use crate::drive::{Agreement, Drive, Finding, Input, Mode, Retention};
pub use crate::signal::echoes::MotionCompensation;
pub use crate::track::{RowPose, Track};
pub use odometer::same_place_m;
pub use odometry::{Odometry, Reading};
pub use sweeps::SweepComparison;
