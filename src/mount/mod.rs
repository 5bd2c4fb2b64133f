//! How the scanner is mounted: the floor as a model of angle, height and range scale.
//!
//! In: echoes as they are placed with the configured mounting. Out: what height, angles and ranges are off by, with
//! standard errors, and whether the floor lies where the configured mounting puts it. Both calibrations are weighted
//! least squares over echoes of the floor, whose errors [`floor_variance`] gives; neither knows stairs.
//!
//! | module | from → to |
//! |---|---|
//! | [`command`] | echoes of a floor and a wall, scanned on command → height, angle offset and range scale, to be saved |
//! | [`online`] | echoes of the floor in any scan → angle bias and height error of that scan, taken out |
//! | `floor` | echoes → variance of a floor echo's height; whether the floor is where mount height and angle say |

pub mod command;
mod floor;
pub mod online;

pub use command::Mounting;
pub use floor::{Floor, floor_variance};
pub use online::Calibration;
