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
            across_per_width_m: 0.17407,
            sigma_per_width_m: 0.112,
            snr_db: 26.69061,
            snr_per_db: 1.01563,
            snr_sigma_db: 5.22368,
            seen: 1.19824,
            seen_per_ten_db: 0.24787,
            seen_per_room: 2.80398,
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
            seen: -0.16528,
            seen_per_ten_db: 0.55735,
            seen_per_room: 3.71835,
        },
        // flash
        Point {
            range_m: -0.00011,
            range_sigma_m: 0.002,
            across_m: 0.00254,
            across_sigma_m: 0.0135,
            across_per_width_m: -0.10764,
            sigma_per_width_m: 0.05001,
            snr_db: 29.81089,
            snr_per_db: 0.95328,
            snr_sigma_db: 4.31873,
            seen: 1.16491,
            seen_per_ten_db: 0.22146,
            seen_per_room: 0.38534,
        },
        // top
        Point {
            range_m: -0.00264,
            range_sigma_m: 0.0026,
            across_m: -0.0249,
            across_sigma_m: 0.01495,
            across_per_width_m: -0.08311,
            sigma_per_width_m: 0.06604,
            snr_db: 19.18233,
            snr_per_db: 0.90352,
            snr_sigma_db: 7.0212,
            seen: 0.07401,
            seen_per_ten_db: 0.0103,
            seen_per_room: 1.22616,
        },
        // hidden
        Point {
            range_m: -0.00039,
            range_sigma_m: 0.002,
            across_m: 0.0,
            across_sigma_m: 0.0,
            across_per_width_m: 0.0,
            sigma_per_width_m: 0.16447,
            snr_db: 11.39334,
            snr_per_db: 0.75517,
            snr_sigma_db: 8.85409,
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
            rate: -0.19687,
            rate_per_ten_db: 0.05981,
            snr_db: 8.51408,
            snr_per_db: 0.66049,
            snr_sigma_db: 9.63456,
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
            rate: 2.5354,
            rate_per_ten_db: 0.11362,
            snr_db: 0.34092,
            snr_per_db: 0.38147,
            snr_sigma_db: 11.48268,
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
            rate: 1.52851,
            rate_per_ten_db: 0.0,
            snr_db: 0.0,
            snr_per_db: 0.0,
            snr_sigma_db: 6.86872,
            off_sigma_m: 0.0,
        },
    ],
    hidden: Hidden {
        low: [0.78761, 0.00212, 0.00962],
        top: [0.21111, -0.03586, 0.00742],
        nothing: [-3.02721, -0.54292, 2.33596, -0.47222],
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
