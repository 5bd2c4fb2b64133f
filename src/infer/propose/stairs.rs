//! A flight of stairs going up in the search: faces one behind the other, their rise, its score.

use crate::math;
use heapless::Vec;

/// Maximum number of faces of a flight.
pub const MAX_FLIGHT: usize = 10;

/// One face of a chain: its place, and the column of its echoes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChainLink {
    /// Position along the line of sight, metres.
    pub along_m: f32,
    /// Index of the column; none for an inferred face.
    pub column: Option<u8>,
}

/// Faces one behind the other.
pub type Chain = Vec<ChainLink, MAX_FLIGHT>;

/// Returns the mean distance of a flight's faces without landings, metres, and the number of landings. A landing is a
/// distance of more than `most_m`.
pub fn regular(chain: &[ChainLink], most_m: f32) -> (f32, usize) {
    let (mut sum, mut spans, mut landings) = (0.0, 0.0, 0);
    for pair in chain.windows(2) {
        let [before, after] = pair else { continue };
        let away_m = after.along_m - before.along_m;
        if away_m <= most_m {
            sum += away_m;
            spans += 1.0;
        } else {
            landings += 1;
        }
    }
    (sum / math::max(spans, 1.0), landings)
}

/// Kind of an explanation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Explanation {
    /// Level ground; going down also a falling ramp.
    NoStairs,
    /// Stairs going up.
    Up {
        /// Riser height, metres.
        rise_m: f32,
        /// Whether the treads are open (no risers).
        open: bool,
    },
    /// Stairs going down.
    Down {
        /// Distance of the first edge, metres from the mirror.
        edge_m: f32,
        /// Going from edge to edge, metres.
        going_m: f32,
    },
}

/// Parameters of a flight besides its risers' places.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlightShape {
    /// Riser height, metres.
    pub rise_m: f32,
    /// Whether the treads are open (no risers).
    pub open: bool,
}

/// A flight, or the beginning of one.
#[derive(Clone, Debug, Default)]
pub struct Flight {
    /// Its faces.
    pub chain: Chain,
    /// Its shape.
    pub shape: FlightShape,
    /// Log-likelihood of its faces, nats.
    pub faces: f32,
    /// Log-likelihood ratio against ground without stairs, nats.
    pub score: f32,
}
