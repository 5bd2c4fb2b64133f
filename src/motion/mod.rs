//! The chair's own motion: what its controller reports of it, where each row was seen, and whether two sweeps agree with it.
//!
//! | module | does |
//! |---|---|
//! | [`track`] | when each row was seen, and where the chair was then |
//! | [`known`] | what is known of the motion when a scan ends, and what holds where nothing is |
//! | [`odometry`] | motion sentences in: checked, interpolated to each row's mid chirp |
//! | [`odometer`] | errors of the odometer, and the tolerance between two sweeps that follows from them |
//! | [`place`] | echoes as they were seen → as they lie from the mirror at the last row |
//! | [`sweeps`] | this sweep's echoes and the last one's → whether the chair stands, or moves as is said |

pub mod known;
pub mod odometer;
pub mod odometry;
pub mod place;
pub mod sweeps;
pub mod track;

#[cfg(test)]
mod tests;

pub use known::{Drive, Input, Mode, Retention};
pub use odometer::{ODOMETER_SCALE_ERROR, ODOMETER_WANDER_M, SAME_PLACE_M, same_place_m};
pub use odometry::{Odometry, Reading};
pub use place::Ride;
pub use sweeps::{Agreement, Finding, Sweeps};
pub use track::{RowPose, Track};
