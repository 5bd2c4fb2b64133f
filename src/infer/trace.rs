//! What the default estimator tells an observer: every scatterer with its role, the winner, its
//! rivals, their scores.

pub use super::propose::roles::Role;
pub use super::propose::stairs::{ChainLink, Explanation};
use crate::params::carried::PastFeatures;
use crate::params::hazard::Features;
use crate::signal::echoes::Echo;

/// One scatterer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatterer {
    /// Where it is, how strong, and its standard deviations.
    pub echo: Echo,
    /// What the winner takes it for.
    pub role: Role,
}

/// A flight of the search, or level ground, as an explanation of the echoes, and its score.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate<'a> {
    /// What it says.
    pub explanation: Explanation,
    /// Its faces along the line of sight: horizontal distances going up, depths below the mirror
    /// going down.
    pub faces: &'a [ChainLink],
    /// Log-likelihood ratio against everything that is no stair, nats.
    pub score: f32,
    /// Whether it is the answer.
    pub winner: bool,
}

/// One cell of the way ahead, as the verdict sees it.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Where it ends, metres from the mirror.
    pub end_m: f32,
    /// What is known of it.
    pub features: Features,
    /// Where earlier scans have a say: what they know of it.
    pub past: Option<PastFeatures>,
    /// Probability that the answer is right up to its end.
    pub right: f32,
    /// Probability from which on the answer is valid up to there.
    pub asked: f32,
}

/// What is done one after the other after the last row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Echoes are told from noise, side lobes and ghosts, and placed.
    Echoes,
    /// The best flight is found.
    Search,
    /// Steps have their dimensions, and how far the answer is valid is known.
    Dimensions,
}
