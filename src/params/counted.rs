//! What one scan's word counts in the next one, counted from simulated sequences: written by
//! `cargo sim sequences --fit`.

use super::carried::{Carried, Correlation};
use super::hazard::Map;

/// Of the errors of steps' distances.
pub const PLACES: Correlation = Correlation {
    standing: 0.525,
    way_m: 1.0,
};

/// Of the errors of steps' heights.
pub const LEVELS: Correlation = Correlation {
    standing: 0.7,
    way_m: 0.225,
};

/// In the depth plane.
pub static UP: Carried = Carried {
    hazard: [
        0.16747679,
        1.2903198,
        0.9712992,
        0.9393549,
        -0.6815381,
        1.136423,
        -0.31773382,
        0.46291324,
        -0.032076854,
        -0.70091414,
        0.043112915,
        0.041317508,
    ],
    maps: [
        Map {
            slope: 1.1508794,
            offset: -3.1247313,
        },
        Map {
            slope: 1.0582926,
            offset: 0.39168406,
        },
    ],
    ok_from: 0.989,
};
