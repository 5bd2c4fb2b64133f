//! What the estimator thought: every scatterer with its role, the winner, its rivals, their scores.
//!
//! The scanner's own calls pass `()`, which listens to nothing and costs nothing; a program that
//! wants to show why a scan came out as it did passes an [`Observer`] of its own.

use super::echo::Echo;
pub use super::role::Role;
pub use super::search::Link;

/// One scatterer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatterer {
    /// Where it is, how strong, and its standard deviations.
    pub echo: Echo,
    /// What the winner takes it for.
    pub role: Role,
}

/// A kind of explanation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Explanation {
    /// Flat ground, a ramp, or one thing too tall to climb.
    NoStairs,
    /// Stairs going up.
    Up {
        /// Height of one riser, metres.
        rise_m: f32,
        /// Whether they float.
        open: bool,
    },
    /// Stairs going down.
    Down {
        /// First edge, metres from the mirror.
        edge_m: f32,
        /// From edge to edge, metres.
        going_m: f32,
    },
}

/// One explanation of the echoes and its score.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hypothesis<'a> {
    /// What it says.
    pub explanation: Explanation,
    /// Its faces along the line of sight: horizontal distances going up, depths below the mirror
    /// going down.
    pub faces: &'a [Link],
    /// Log-likelihood ratio against everything that is no stair, nats.
    pub score: f32,
    /// Whether it is the answer.
    pub winner: bool,
}

/// What is done one after the other after the last row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The filter has run out behind the last row.
    Rows,
    /// Noise is known, candidates are sorted and those that are echoes chosen.
    Echoes,
    /// Particles have settled, and their clusters.
    Particles,
    /// The best flight is found.
    Search,
    /// Steps have their dimensions and the answer its status.
    Dimensions,
}

/// Listens to the estimator.
pub trait Observer {
    /// Whether it wants to hear about scatterers and explanations.
    fn listens(&self) -> bool {
        true
    }
    /// A stage is done.
    fn done(&mut self, _stage: Stage) {}
    /// The noise: the filtered map's median, map units (1/8 octave).
    fn noise(&mut self, _units: f32) {}
    /// What the floor said: angle bias, radians, and mount-height error, metres.
    fn calibration(&mut self, _bias_rad: f32, _height_m: f32) {}
    /// One scatterer, strongest first.
    fn scatterer(&mut self, _scatterer: &Scatterer) {}
    /// One explanation: the best of each number of steps.
    fn hypothesis(&mut self, _hypothesis: &Hypothesis<'_>) {}
}

impl Observer for () {
    fn listens(&self) -> bool {
        false
    }
}
