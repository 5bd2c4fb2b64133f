//! A flight of stairs going up as the search has it: faces one behind the other, their rise, its score.

use crate::math;
use heapless::Vec;

/// Most faces of a flight.
pub const MAX_FLIGHT: usize = 10;

/// One face of a chain: its place, and the column that shows it unless it is inferred.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChainLink {
    /// Along the line of sight, metres.
    pub along_m: f32,
    /// Index of the column.
    pub column: Option<u8>,
}

/// Faces one behind the other.
pub type Chain = Vec<ChainLink, MAX_FLIGHT>;

/// Mean distance of a flight's faces, landings left out, and the number of those: faces farther apart
/// than `most_m`.
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

/// A kind of explanation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Explanation {
    /// Level ground; going down also ground that falls.
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

/// What two flights of the same risers may differ in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlightShape {
    /// Height of one riser, metres.
    pub rise_m: f32,
    /// Whether there is nothing below the treads.
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
    /// Log-likelihood ratio of the whole against everything that is no stair, nats.
    pub score: f32,
}
