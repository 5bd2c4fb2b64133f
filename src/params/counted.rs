//! Weights of earlier scans' evidence, counted from simulated sequences: written by
//! `cargo study sequences --fit`.

use super::carried::{Carried, Correlation};
use super::hazard::PlattMap;

/// Correlation of the errors of steps' distances.
pub const PLACES: Correlation = Correlation {
    at_rest: 0.575,
    length_m: 1.0,
};

/// Correlation of the errors of steps' heights.
pub const LEVELS: Correlation = Correlation {
    at_rest: 0.775,
    length_m: 0.2,
};

/// Weights of the depth plane.
pub static UP: Carried = Carried {
    hazard: [
        0.23445718,
        0.9551455,
        -0.20808621,
        0.6422676,
        -0.63800067,
        1.0786628,
        -0.27289692,
        0.20786333,
        0.19409534,
        1.3121324,
        0.29082668,
        -0.40125817,
    ],
    maps: [
        PlattMap {
            slope: 1.2603583,
            offset: -0.7134354,
        },
        PlattMap {
            slope: 0.76715356,
            offset: 0.91175,
        },
    ],
    ok_from: [0.988, 0.988],
};
