//! What one scan's word counts in the next one, counted from simulated sequences: written by
//! `cargo sim sequences --fit`.

use super::carried::{Carried, Correlation};
use super::hazard::Map;

/// Of the errors of steps' distances.
pub const PLACES: Correlation = Correlation {
    standing: 0.575,
    way_m: 1.0,
};

/// Of the errors of steps' heights.
pub const LEVELS: Correlation = Correlation {
    standing: 0.65,
    way_m: 0.3,
};

/// In the depth plane.
pub static UP: Carried = Carried {
    hazard: [
        0.118821815,
        1.1953932,
        -0.020796621,
        0.543349,
        -0.80314815,
        1.5610317,
        -0.28344882,
        0.4573186,
        -0.40112278,
        1.5914754,
        0.35181144,
        -0.24098593,
    ],
    maps: [
        Map {
            slope: 1.39796,
            offset: -1.743915,
        },
        Map {
            slope: 0.6570439,
            offset: 1.0267359,
        },
    ],
    ok_from: 0.989,
};
