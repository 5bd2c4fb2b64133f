//! The measurement model, counted from simulated scans: written by `cargo study fit`.

use super::generative::{Extended, Generative, Hidden, Point, TreadEnd, TreadNumbers};

/// Parameters of both planes.
pub static MODEL: Generative = Generative {
    points: [
        // corner
        Point {
            range_m: -0.00018,
            range_sigma_m: 0.002,
            across_m: -0.0002,
            across_sigma_m: 0.0015,
            across_per_width_m: 0.17449,
            sigma_per_width_m: 0.11202,
            snr_db: 26.69168,
            snr_per_db: 1.01563,
            snr_sigma_db: 5.22243,
            seen: 1.20222,
            seen_per_ten_db: 0.24782,
            seen_per_room: 2.80045,
        },
        // nosing
        Point {
            range_m: 0.0011,
            range_sigma_m: 0.00211,
            across_m: -0.00374,
            across_sigma_m: 0.00393,
            across_per_width_m: -0.12629,
            sigma_per_width_m: 0.07211,
            snr_db: 14.26962,
            snr_per_db: 0.82419,
            snr_sigma_db: 6.48352,
            seen: -0.16432,
            seen_per_ten_db: 0.55709,
            seen_per_room: 3.7171,
        },
        // flash
        Point {
            range_m: -0.00011,
            range_sigma_m: 0.002,
            across_m: 0.00254,
            across_sigma_m: 0.0135,
            across_per_width_m: -0.10701,
            sigma_per_width_m: 0.05,
            snr_db: 29.80705,
            snr_per_db: 0.95346,
            snr_sigma_db: 4.32118,
            seen: 1.16441,
            seen_per_ten_db: 0.21785,
            seen_per_room: 0.38004,
        },
        // top
        Point {
            range_m: -0.00264,
            range_sigma_m: 0.0026,
            across_m: -0.02495,
            across_sigma_m: 0.01488,
            across_per_width_m: -0.08274,
            sigma_per_width_m: 0.06614,
            snr_db: 19.17496,
            snr_per_db: 0.90378,
            snr_sigma_db: 7.02525,
            seen: 0.07076,
            seen_per_ten_db: 0.01106,
            seen_per_room: 1.23443,
        },
        // hidden
        Point {
            range_m: -0.00039,
            range_sigma_m: 0.002,
            across_m: 0.0,
            across_sigma_m: 0.0,
            across_per_width_m: 0.0,
            sigma_per_width_m: 0.16449,
            snr_db: 11.38299,
            snr_per_db: 0.75531,
            snr_sigma_db: 8.8516,
            seen: 0.5,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
        // edge below
        Point {
            range_m: 0.00098,
            range_sigma_m: 0.002,
            across_m: -0.00342,
            across_sigma_m: 0.00737,
            across_per_width_m: -0.11324,
            sigma_per_width_m: 0.05,
            snr_db: 21.71004,
            snr_per_db: 0.77186,
            snr_sigma_db: 7.81213,
            seen: 2.0,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
        // edge above
        Point {
            range_m: -0.00361,
            range_sigma_m: 0.00304,
            across_m: -0.0325,
            across_sigma_m: 0.01392,
            across_per_width_m: -0.05821,
            sigma_per_width_m: 0.05002,
            snr_db: 21.02472,
            snr_per_db: 0.86288,
            snr_sigma_db: 10.16305,
            seen: 1.5,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
    ],
    extended: [
        // face
        Extended {
            rate: -0.19691,
            rate_per_ten_db: 0.05984,
            snr_db: 8.51443,
            snr_per_db: 0.66048,
            snr_sigma_db: 9.63246,
            off_sigma_m: 0.00987,
        },
        // tread
        Extended {
            rate: 0.81547,
            rate_per_ten_db: 0.13276,
            snr_db: -4.13757,
            snr_per_db: 0.56444,
            snr_sigma_db: 11.14921,
            off_sigma_m: 0.003,
        },
        // floor
        Extended {
            rate: 2.53574,
            rate_per_ten_db: 0.11349,
            snr_db: 0.33553,
            snr_per_db: 0.38153,
            snr_sigma_db: 11.48776,
            off_sigma_m: 0.003,
        },
        // air
        Extended {
            rate: -11.96826,
            rate_per_ten_db: 2.70476,
            snr_db: 25.0581,
            snr_per_db: -0.12121,
            snr_sigma_db: 2.00001,
            off_sigma_m: 0.0,
        },
        // inside
        Extended {
            rate: -8.71647,
            rate_per_ten_db: -0.04421,
            snr_db: 6.0,
            snr_per_db: 0.3,
            snr_sigma_db: 6.0,
            off_sigma_m: 0.0,
        },
        // noise
        Extended {
            rate: 1.52814,
            rate_per_ten_db: 0.0,
            snr_db: 0.0,
            snr_per_db: 0.0,
            snr_sigma_db: 6.86644,
            off_sigma_m: 0.0,
        },
    ],
    hidden: Hidden {
        low: [0.78748, 0.00216, 0.00957],
        top: [0.21124, -0.03586, 0.00742],
        nothing: [-3.02771, -0.54344, 2.33855, -0.46949],
    },
    treads: TreadNumbers {
        rate: [2.35026, -0.02538, -0.32054, 0.09753],
        ratio_m2: [
            0.27083, 0.6003, 0.64677, 0.72881, 1.0392, 1.267, 1.55142, 1.7644, 2.30257, 2.52938,
            2.45989, 3.39614, 3.54478, 3.14212, 2.96734, 3.53645, 2.87174, 2.98369, 2.74064,
            21.75917,
        ],
        height_sigma_m: 0.00229,
        ends: [
            TreadEnd {
                number: 0.69881,
                off_m: 0.00376,
                sigma_m: 0.00797,
            },
            TreadEnd {
                number: 0.12,
                off_m: 0.00642,
                sigma_m: 0.00945,
            },
        ],
        starts: [
            TreadEnd {
                number: 0.52487,
                off_m: -0.00894,
                sigma_m: 0.01209,
            },
            TreadEnd {
                number: 0.46879,
                off_m: -0.00133,
                sigma_m: 0.00582,
            },
        ],
        edge_sigma_scale: 1.22164,
    },
};
