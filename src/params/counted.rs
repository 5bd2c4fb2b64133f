//! What one scan's word counts in the next one, counted from simulated sequences: written by
//! `cargo sim sequences --fit`.

use super::carried::{Carried, Correlation};
use super::hazard::Map;

/// Of the errors of steps' distances.
pub const PLACES: Correlation = Correlation {
    standing: 0.9,
    way_m: 0.3,
};
/// Of the errors of steps' heights.
pub const LEVELS: Correlation = Correlation {
    standing: 0.95,
    way_m: 0.2,
};

/// In the depth plane.
pub static UP: Carried = Carried {
    hazard: [0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    maps: [Map::IDENTITY, Map::IDENTITY],
    ok_from: 0.98,
};
