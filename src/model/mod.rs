//! Hypotheses about the scene, and the likelihood of the echoes under them.
//!
//! | module | content |
//! |---|---|
//! | [`kinds`] | kinds of things ahead, a file each |
//! | `staircase` | a hypothesis: its kind, its risers, a wall; and its conflicts with an answer |
//! | `normal`, `sight` | the normal distribution and its tail; visibility behind and below an edge |
//! | `feature`, `places` | classes of point features, their expected places, and the visible part of a riser |
//! | `points` | the measurement model: likelihood of the echoes under a hypothesis |
//! | `gaze`, `power`, `lines`, `above`, `mean` | power along lines of the ground, below and above it; its mean over sweeps |
//! | `surfaces` | likelihood that the ground goes on, ends, or that something stands on it |
//! | `treads` | the measurement model of stairs going down: likelihood of the echoes on treads seen from above |
//! | [`cloud`] | weighted hypotheses (particles), their resampling, and where an answer is wrong by them |
//! | `prior` | prior of stairs as they are built, and of the alternatives |
//!
//! Nothing here searches or decides: that is done by [`crate::infer`], on which this module does not depend.

pub mod above;
pub mod chart;
pub mod cloud;
mod feature;
mod gaze;
pub mod kinds;
pub mod lines;
pub mod mean;
pub(crate) mod normal;
mod places;
mod points;
pub mod power;
pub(crate) mod prior;
mod sight;
mod staircase;
pub mod surfaces;
pub mod treads;

#[cfg(test)]
pub(crate) mod tests;

pub use feature::{Class, FeaturePlace, excess_level};
pub use kinds::GroundKind;
pub use normal::{logistic, tailed};
pub use points::{EchoSums, MAX_MODEL_ECHOES, MIN_DB, Model, ModelEcho, NEAR, level_density};
pub use sight::{sight_m, tread_begins_m};
pub use staircase::{
    Edge, MAX_STEPS, MIN_EXPANDED_M, ReportedDrop, ReportedStep, SAME_M, Sigmas, Staircase, View,
};
pub use surfaces::Surfaces;
