//! Calibration of the mounting on the ground: angle, height and range scale.
//!
//! In: echoes as the configured mounting places them. Out: the errors of height, angles and ranges with
//! standard errors, and whether the ground lies where the configured mounting puts it. Both calibrations are
//! weighted least squares over ground echoes, with the variance of [`floor_variance`]; neither uses a model of
//! stairs.
//!
//! | module | from → to |
//! |---|---|
//! | [`command`] | echoes of a level ground and a wall, scanned on command → height, angle offset and range scale, to be saved |
//! | [`online`] | ground echoes of any scan → angle bias and height error of that scan, subtracted |
//! | `ground` | echoes → whether the ground is where mounting height and angle put it, and its slope |
//! | `variance` | a ground echo → variance of its height |

pub mod command;
mod ground;
pub mod online;
mod variance;

pub use command::Mounting;
pub use ground::GroundEvidence;
pub use online::Calibration;
pub use variance::floor_variance;
