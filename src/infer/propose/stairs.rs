//! A flight of stairs going up in the search: faces one behind the other, their rise, its score.

use crate::math;
use heapless::Vec;

/// Maximum number of faces of a flight.
pub const MAX_FLIGHT: usize = 10;

/// One face (riser, or going down tread) of a chain: its place, and the column of its echoes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChainLink {
    /// Position of the face along the line of sight, metres: horizontal distance of a riser, depth of a tread below the
    /// mirror.
    pub along_m: f32,
    /// Index of the column of echoes at the face; `None` for a face inferred without echoes.
    pub column: Option<u8>,
}

/// Faces of a flight, one behind the other, the nearest first.
pub type Chain = Vec<ChainLink, MAX_FLIGHT>;

/// Returns the mean going of a flight, metres, without its landings, and the number of landings. A landing is a
/// distance of more than `most_m`, metres, between two faces.
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

/// Parameters of a flight besides the places of its risers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlightShape {
    /// Riser height, metres.
    pub rise_m: f32,
    /// Whether the treads are open (no risers).
    pub open: bool,
}

/// A flight going up, or the beginning of one, as the search builds it.
#[derive(Clone, Debug, Default)]
pub struct Flight {
    /// Faces of the flight, the nearest first.
    pub chain: Chain,
    /// Riser height of the flight, and whether its treads are open.
    pub shape: FlightShape,
    /// Sum of the search scores of the flight's faces (risers), each with the tread before it, nats.
    pub faces: f32,
    /// Score of the whole flight less that of level ground, nats.
    pub score: f32,
}
