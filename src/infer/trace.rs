//! Intermediate results of the default estimator for an observer: every scatterer with its role, the winner, its
//! runners-up, their scores.

pub use super::propose::roles::Role;
pub use super::propose::stairs::{ChainLink, Explanation};
use crate::params::carried::PastFeatures;
use crate::params::hazard::Features;
use crate::signal::echoes::Echo;

/// One scatterer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatterer {
    /// Position, level and standard deviations.
    pub echo: Echo,
    /// Role that the winner assigns to it.
    pub role: Role,
}

/// A flight of the search, or level ground, as an explanation of the echoes, and its score.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate<'a> {
    /// Kind and dimensions.
    pub explanation: Explanation,
    /// Its faces along the line of sight, metres: horizontal distances going up, depths below the mirror going down.
    pub faces: &'a [ChainLink],
    /// Log-likelihood ratio against ground without stairs, nats.
    pub score: f32,
    /// Whether it is the answer.
    pub winner: bool,
}

/// One cell of the way ahead, as the horizon uses it.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Its end, metres from the mirror.
    pub end_m: f32,
    /// Features of this scan.
    pub features: Features,
    /// Features of this and earlier scans, where evidence was carried on.
    pub past: Option<PastFeatures>,
    /// Probability that the answer is correct up to its end.
    pub p_correct: f32,
    /// Minimum probability at which the answer is valid up to its end.
    pub required: f32,
}

/// Processing stages after the last row, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Echoes are separated from noise, side lobes and ghosts, and placed.
    Echoes,
    /// The best flight is found.
    Search,
    /// Dimensions of the steps and the horizon are known.
    Dimensions,
}
