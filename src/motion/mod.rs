//! The chair's own motion: what its controller reports of it, and whether two sweeps agree with it.
//!
//! Its results are values of [`crate::drive`] and [`crate::track`]. By them [`Ride`] moves echoes to where they lie from
//! the chair's last place.
//!
//! | module | does |
//! |---|---|
//! | [`odometry`] | motion sentences in: checked, interpolated to each row's mid chirp |
//! | [`odometer`] | errors of the odometer, and the tolerance between two sweeps that follows from them |
//! | [`sweeps`] | this sweep's echoes and the last one's → whether the chair stands, or moves as is said |

pub mod odometer;
pub mod odometry;
pub mod sweeps;

#[cfg(test)]
mod tests;

pub use crate::drive::{Drive, Input, Mode, Retention};
pub use crate::signal::echoes::Ride;
pub use crate::track::{RowPose, Track};
pub use odometer::{ODOMETER_SCALE_ERROR, ODOMETER_WANDER_M, SAME_PLACE_M, same_place_m};
pub use odometry::{Odometry, Reading};
pub use sweeps::{Agreement, Finding, Sweeps};
