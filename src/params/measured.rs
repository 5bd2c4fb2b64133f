//! The measurement model, counted from simulated scans: written by `cargo study fit`.

use super::generative::{Extended, Generative, Hidden, Point, TreadEnd, TreadNumbers};

/// Parameters of both planes.
pub static MODEL: Generative = Generative {
    points: [
        // corner
        Point {
            range_m: -0.00019,
            range_sigma_m: 0.002,
            across_m: -0.00018,
            across_sigma_m: 0.0015,
            across_per_width_m: 0.17522,
            sigma_per_width_m: 0.10844,
            snr_db: 26.64839,
            snr_per_db: 1.01847,
            snr_sigma_db: 5.24687,
            seen: 1.25721,
            seen_per_ten_db: 0.22623,
            seen_per_room: 2.88605,
        },
        // nosing
        Point {
            range_m: 0.00107,
            range_sigma_m: 0.00212,
            across_m: -0.00371,
            across_sigma_m: 0.00386,
            across_per_width_m: -0.12949,
            sigma_per_width_m: 0.0783,
            snr_db: 14.28472,
            snr_per_db: 0.82345,
            snr_sigma_db: 6.49493,
            seen: -0.09434,
            seen_per_ten_db: 0.55455,
            seen_per_room: 3.59452,
        },
        // flash
        Point {
            range_m: -0.00012,
            range_sigma_m: 0.002,
            across_m: 0.00253,
            across_sigma_m: 0.01369,
            across_per_width_m: -0.10262,
            sigma_per_width_m: 0.05,
            snr_db: 29.78614,
            snr_per_db: 0.95151,
            snr_sigma_db: 4.32291,
            seen: 1.15981,
            seen_per_ten_db: 0.23027,
            seen_per_room: 0.25021,
        },
        // top
        Point {
            range_m: -0.00262,
            range_sigma_m: 0.0026,
            across_m: -0.02516,
            across_sigma_m: 0.01496,
            across_per_width_m: -0.06072,
            sigma_per_width_m: 0.05942,
            snr_db: 19.28205,
            snr_per_db: 0.90093,
            snr_sigma_db: 6.94457,
            seen: 0.09272,
            seen_per_ten_db: -0.0113,
            seen_per_room: 1.19786,
        },
        // hidden
        Point {
            range_m: -0.00039,
            range_sigma_m: 0.002,
            across_m: 0.0,
            across_sigma_m: 0.0,
            across_per_width_m: 0.0,
            sigma_per_width_m: 0.15013,
            snr_db: 11.17631,
            snr_per_db: 0.76487,
            snr_sigma_db: 8.9556,
            seen: 0.5,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
        // edge below
        Point {
            range_m: 0.00097,
            range_sigma_m: 0.002,
            across_m: -0.0034,
            across_sigma_m: 0.00752,
            across_per_width_m: -0.11228,
            sigma_per_width_m: 0.05001,
            snr_db: 21.77019,
            snr_per_db: 0.76866,
            snr_sigma_db: 7.81972,
            seen: 2.0,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
        // edge above
        Point {
            range_m: -0.00356,
            range_sigma_m: 0.00298,
            across_m: -0.03235,
            across_sigma_m: 0.01389,
            across_per_width_m: -0.05778,
            sigma_per_width_m: 0.05001,
            snr_db: 21.19055,
            snr_per_db: 0.85406,
            snr_sigma_db: 10.08315,
            seen: 1.5,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
    ],
    extended: [
        // face
        Extended {
            rate: -0.20622,
            rate_per_ten_db: 0.06243,
            snr_db: 8.52395,
            snr_per_db: 0.66001,
            snr_sigma_db: 9.64527,
            off_sigma_m: 0.01,
        },
        // tread
        Extended {
            rate: 0.81823,
            rate_per_ten_db: 0.13024,
            snr_db: -4.04906,
            snr_per_db: 0.56001,
            snr_sigma_db: 11.09576,
            off_sigma_m: 0.003,
        },
        // floor
        Extended {
            rate: 2.53535,
            rate_per_ten_db: 0.11374,
            snr_db: 0.29218,
            snr_per_db: 0.38289,
            snr_sigma_db: 11.52114,
            off_sigma_m: 0.003,
        },
        // air
        Extended {
            rate: -12.26945,
            rate_per_ten_db: 2.82392,
            snr_db: 25.13257,
            snr_per_db: -0.1172,
            snr_sigma_db: 2.00001,
            off_sigma_m: 0.0,
        },
        // inside
        Extended {
            rate: -8.71642,
            rate_per_ten_db: -0.04426,
            snr_db: 6.0,
            snr_per_db: 0.3,
            snr_sigma_db: 6.0,
            off_sigma_m: 0.0,
        },
        // noise
        Extended {
            rate: 1.52726,
            rate_per_ten_db: 0.0,
            snr_db: 0.0,
            snr_per_db: 0.0,
            snr_sigma_db: 6.85666,
            off_sigma_m: 0.0,
        },
    ],
    hidden: Hidden {
        low: [0.79909, 0.00227, 0.00995],
        top: [0.19966, -0.0348, 0.00757],
        nothing: [-3.06342, -0.52984, 2.397, -0.49722],
    },
    treads: TreadNumbers {
        rate: [2.34604, -0.02232, -0.31639, 0.09588],
        ratio_m2: [
            0.2657, 0.59344, 0.67287, 0.69939, 1.11016, 1.22449, 1.54591, 1.75468, 2.56158,
            2.39478, 2.68723, 3.329, 3.62547, 3.13768, 3.09541, 3.16692, 2.9861, 2.93483, 2.743,
            22.311,
        ],
        height_sigma_m: 0.0023,
        ends: [
            TreadEnd {
                number: 0.69418,
                off_m: 0.00376,
                sigma_m: 0.00794,
            },
            TreadEnd {
                number: 0.11988,
                off_m: 0.00653,
                sigma_m: 0.00943,
            },
        ],
        starts: [
            TreadEnd {
                number: 0.51839,
                off_m: -0.00873,
                sigma_m: 0.01198,
            },
            TreadEnd {
                number: 0.46984,
                off_m: -0.00133,
                sigma_m: 0.00588,
            },
        ],
        edge_sigma_scale: 1.16482,
    },
};
