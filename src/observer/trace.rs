//! Intermediate results of the default estimator for an observer: every echo with its role, the accepted hypothesis,
//! its runners-up, their scores, the way cells.

use crate::params::carried::PastFeatures;
use crate::params::hazard::Features;
use crate::signal::echoes::Echo;

/// Role of an echo: the feature of a hypothesis that it shows, or how it contradicts it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Role {
    /// The inner corner at the foot of a riser.
    Corner,
    /// The front edge at the top of a riser.
    Nosing,
    /// The specular reflection of a face at right angles to the line of sight.
    Flash,
    /// A place on a riser between foot and top.
    Face,
    /// The surface of a tread, of the landing or of the floor.
    Tread,
    /// The end of a tread, seen from above.
    Edge,
    /// Inside the solid: contradicts the flight.
    Inside,
    /// Above the top of its own riser: contradicts the flight.
    Above,
    /// Standing on a tread: contradicts the flight.
    Clutter,
    /// Not explained by the flight.
    #[default]
    Stray,
}

impl Role {
    /// Whether an echo in this role contradicts the flight.
    pub const fn contradicts(self) -> bool {
        matches!(self, Self::Inside | Self::Above | Self::Clutter)
    }

    /// Returns the role's name in the output of `cargo sim inspect`.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Corner => "corner",
            Self::Nosing => "nosing",
            Self::Flash => "flash",
            Self::Face => "face",
            Self::Tread => "tread",
            Self::Edge => "edge",
            Self::Inside => "inside",
            Self::Above => "above",
            Self::Clutter => "clutter",
            Self::Stray => "unexplained",
        }
    }
}

/// One echo, taken for a scatterer, with its role.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatterer {
    /// The echo: position, SNR and standard deviations.
    pub echo: Echo,
    /// Role of the echo under the accepted hypothesis.
    pub role: Role,
}

/// One face (riser, or going down tread) of a chain: its place, and the column of its echoes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChainLink {
    /// Position of the face along the line of sight, metres: horizontal distance of a riser, depth of a tread below the
    /// mirror.
    pub along_m: f32,
    /// Index of the column of echoes at the face; `None` for a face inferred without echoes.
    pub column: Option<u8>,
}

/// Kind of an explanation of the echoes, with its dimensions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Explanation {
    /// Level ground; going down also a falling ramp.
    NoStairs,
    /// Stairs going up.
    Up {
        /// Riser height of the stairs going up, metres.
        rise_m: f32,
        /// Whether the treads are open (no risers).
        open: bool,
    },
    /// Stairs going down.
    Down {
        /// Horizontal distance of the first edge of the stairs going down, metres from the mirror.
        edge_m: f32,
        /// Going of the stairs going down, from edge to edge, metres.
        going_m: f32,
    },
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
