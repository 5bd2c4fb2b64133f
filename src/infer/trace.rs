//! Intermediate results of the default estimator for an observer: every echo with its role, the accepted hypothesis,
//! its runners-up, their scores, the way cells.

pub use super::propose::roles::Role;
pub use super::propose::stairs::{ChainLink, Explanation};
use crate::params::carried::PastFeatures;
use crate::params::hazard::Features;
use crate::signal::echoes::Echo;

/// One echo, taken for a scatterer, with its role.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatterer {
    /// The echo: position, SNR and standard deviations.
    pub echo: Echo,
    /// Role of the echo under the accepted hypothesis.
    pub role: Role,
}

/// A flight of the search, or level ground, as an explanation of the echoes, and its score.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate<'a> {
    /// Kind of the explanation (level ground, stairs up or down), with its dimensions.
    pub explanation: Explanation,
    /// Positions of the flight's faces along the line of sight, metres: horizontal distances going up, depths below the
    /// mirror going down.
    pub faces: &'a [ChainLink],
    /// Log-likelihood ratio against ground without stairs, nats.
    pub score: f32,
    /// Whether the accepted hypothesis has this kind and number of steps.
    pub winner: bool,
}

/// One way cell (10 cm of the way ahead), as the horizon uses it.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Far end of the way cell, metres from the mirror.
    pub end_m: f32,
    /// Features of the way cell by this scan, from which its hazard (probability of the answer's first error) is
    /// computed.
    pub features: Features,
    /// Features of the way cell by this and earlier scans; `None` where no evidence was carried on from earlier scans.
    pub past: Option<PastFeatures>,
    /// Probability that the answer is correct up to the way cell's far end.
    pub p_correct: f32,
    /// Probability that is required for the answer to be valid up to the way cell's far end.
    pub required: f32,
}

/// Processing stages after the last row, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Echoes are separated from noise, side lobes and ghosts, and placed.
    Echoes,
    /// The search has found the best flight going up; going down, the echoes are prepared.
    Search,
    /// Dimensions of the steps and the horizon are known.
    Dimensions,
}
