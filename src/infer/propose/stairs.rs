//! A flight of stairs going up in the search: faces one behind the other, their rise, its score.

use crate::math;
use crate::observer::trace::ChainLink;
use heapless::Vec;

/// Maximum number of faces of a flight.
pub const MAX_FLIGHT: usize = 10;

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
