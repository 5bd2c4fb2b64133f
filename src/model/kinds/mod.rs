//! Kinds of things ahead. A kind is one file: its prior, evidence along the ground's line, proposals and variants.
//!
//! | module | kind |
//! |---|---|
//! | [`level_ground`] | nothing ahead |
//! | [`ramp`] | ground with a constant slope |
//! | [`mod@drop`] | ground that ends |
//! | [`stairs`], [`descent`] | steps going up, steps going down |
//! | [`obstacle`] | a box: a single object, too tall to climb |
//! | [`threshold`] | a single object, too low for a step |
//! | [`wall`] | a wall behind any of them |
//! | [`variation`] | ways in which hypotheses are varied |
//!
//! This file lists the kinds and passes each question to its file. A new kind is a new file and a line in each of the
//! functions below: all matches are exhaustive. In `src/`, nothing outside matches on the kind. What all risers have in common,
//! their point features, faces and treads, is in the measurement model ([`super::Model`]).

pub mod descent;
pub mod drop;
pub mod level_ground;
pub mod obstacle;
pub mod ramp;
pub mod stairs;
pub mod threshold;
pub mod variation;
pub mod wall;

use super::surfaces::Surfaces;
use crate::answer::{Direction, Slope};
use crate::params::Params;
pub use variation::{SingleRise, Variation};

/// Length of the way ahead that is examined, metres.
pub const WAY_M: f32 = 2.5;

/// Kind of a hypothesis about the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum GroundKind {
    /// Level ground, perhaps with a wall.
    #[default]
    Nothing,
    /// Ground with a constant slope.
    Ramp {
        /// Distance from the mirror at which the slope begins, metres.
        from_m: f32,
        /// Rise per metre; negative going down.
        slope: f32,
    },
    /// Ground that ends: an edge to lower ground, or a hole.
    Drop {
        /// Distance from the mirror at which the ground ends, metres.
        at_m: f32,
    },
    /// Steps going up: risers, with the heights of their tops.
    Stairs,
    /// Steps going down: edges, with the heights of the treads below them.
    Descent,
    /// A single object on the ground, too tall to climb.
    Box,
    /// A single object on the ground, too low for a step.
    Threshold,
}

/// Single rises that are tried on level ground, the lowest first.
pub const SINGLE_RISES: [&[SingleRise]; 3] = [threshold::SINGLE, stairs::SINGLE, obstacle::SINGLE];

/// Returns the hypotheses without risers that are tried going up, of which the likeliest is kept.
pub fn without_risers() -> impl Iterator<Item = GroundKind> {
    ramp::steep().map(GroundKind::from)
}

/// Returns the hypotheses without edges that are tried going down, of which the likeliest is kept.
pub fn without_edges() -> impl Iterator<Item = GroundKind> {
    ramp::down().map(GroundKind::from)
}

impl From<Slope> for GroundKind {
    fn from(Slope { from_m, slope }: Slope) -> Self {
        Self::Ramp { from_m, slope }
    }
}

/// The part of a hypothesis that shows on the ground's line: first riser and wall.
#[derive(Clone, Copy, Debug)]
pub struct FirstRise {
    /// Distance of the first riser from the mirror, metres; infinite without one.
    pub x_m: f32,
    /// Whether the treads are open (no risers).
    pub open: bool,
    /// Distance of the wall, metres; infinite for none.
    pub wall_m: f32,
}

impl GroundKind {
    /// Returns the kind of a single object of this height on the ground, metres, by the limits of a step's height in `p`.
    pub fn single(height_m: f32, p: &Params) -> Self {
        if height_m < p.lowest_step_m {
            Self::Threshold
        } else if height_m <= p.highest_step_m {
            Self::Stairs
        } else {
            Self::Box
        }
    }

    /// Returns the log-prior of the kind, nats.
    pub fn log_prior(&self) -> f32 {
        match self {
            Self::Nothing => level_ground::log_prior(),
            Self::Ramp { .. } => ramp::log_prior(),
            Self::Drop { .. } => drop::log_prior(),
            Self::Stairs => stairs::log_prior(),
            Self::Descent => descent::log_prior(),
            Self::Box => obstacle::log_prior(),
            Self::Threshold => threshold::log_prior(),
        }
    }

    /// Returns the log-density of the mean rise `rise_m` of `risers` risers, metres; nats.
    pub fn log_prior_of_rise(&self, risers: usize, rise_m: f32) -> f32 {
        match self {
            Self::Box => obstacle::log_prior_of_rise(),
            Self::Threshold => threshold::log_prior_of_rise(),
            Self::Descent => descent::log_prior_of_rise(risers, rise_m),
            // Those without risers have none to weight.
            Self::Stairs | Self::Nothing | Self::Ramp { .. } | Self::Drop { .. } => {
                stairs::log_prior_of_rise(risers, rise_m)
            }
        }
    }

    /// Returns the log-likelihood ratio of the hypothesis to ground that goes on, by its nearest riser, wall or end, from
    /// the power along the ground's line, nats.
    pub fn ground_line(&self, line: &Surfaces, first: FirstRise) -> f32 {
        let FirstRise { x_m, open, wall_m } = first;
        match *self {
            Self::Nothing => level_ground::ground_line(line, wall_m),
            Self::Ramp { from_m, .. } => stairs::ground_line(line, from_m, false),
            Self::Drop { at_m } => drop::ground_line(line, at_m),
            Self::Stairs => stairs::ground_line(line, x_m, open),
            Self::Descent => descent::ground_line(line, x_m, open),
            Self::Box => obstacle::ground_line(line, x_m, open),
            Self::Threshold => threshold::ground_line(line, x_m),
        }
    }

    /// Returns the height above the ground of the surface at distance `x_m`, metres, where the treads are at height
    /// `level_m`.
    #[inline]
    pub fn height_m(&self, x_m: f32, level_m: f32) -> f32 {
        match *self {
            Self::Ramp { from_m, slope } => Slope { from_m, slope }.height_m(x_m),
            Self::Nothing
            | Self::Drop { .. }
            | Self::Stairs
            | Self::Descent
            | Self::Box
            | Self::Threshold => level_m,
        }
    }

    /// Returns the distance at which the ground ends, metres; `None` where it goes on.
    #[inline]
    pub fn end_m(&self) -> Option<f32> {
        match *self {
            Self::Drop { at_m } => Some(at_m),
            Self::Nothing
            | Self::Ramp { .. }
            | Self::Stairs
            | Self::Descent
            | Self::Box
            | Self::Threshold => None,
        }
    }

    /// Returns whether the risers are steps of an answer, and in which direction.
    #[inline]
    pub fn direction(&self) -> Direction {
        match self {
            Self::Stairs => Direction::Up,
            Self::Descent => Direction::Down,
            Self::Nothing | Self::Ramp { .. } | Self::Drop { .. } | Self::Box | Self::Threshold => {
                Direction::None
            }
        }
    }

    /// Whether the kind has nothing of its own: hypotheses differ by the wall alone, and have the same variants.
    pub fn is_level_ground(&self) -> bool {
        match self {
            Self::Nothing => true,
            Self::Ramp { .. }
            | Self::Drop { .. }
            | Self::Stairs
            | Self::Descent
            | Self::Box
            | Self::Threshold => false,
        }
    }

    /// Returns the ways in which a hypothesis of the kind is varied.
    pub fn variations(&self) -> &'static [Variation] {
        match self {
            Self::Nothing => level_ground::VARIATIONS,
            Self::Stairs => stairs::VARIATIONS,
            Self::Ramp { .. } | Self::Drop { .. } | Self::Descent | Self::Box | Self::Threshold => {
                &[]
            }
        }
    }
}
