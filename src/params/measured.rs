//! The measurement model, counted from simulated scans: written by `cargo study fit`.

use super::generative::{Extended, Generative, Hidden, Point, TreadEnd, TreadNumbers};

/// Parameters of both planes.
pub static MODEL: Generative = Generative {
    points: [
        // corner
        Point {
            range_m: -0.00018,
            range_sigma_m: 0.002,
            across_m: -0.00016,
            across_sigma_m: 0.0015,
            across_per_width_m: 0.17103,
            sigma_per_width_m: 0.11008,
            snr_db: 26.68477,
            snr_per_db: 1.01501,
            snr_sigma_db: 5.23788,
            seen: 1.21008,
            seen_per_ten_db: 0.23564,
            seen_per_room: 2.81099,
        },
        // nosing
        Point {
            range_m: 0.00109,
            range_sigma_m: 0.00211,
            across_m: -0.00374,
            across_sigma_m: 0.00397,
            across_per_width_m: -0.12614,
            sigma_per_width_m: 0.07208,
            snr_db: 14.2529,
            snr_per_db: 0.82543,
            snr_sigma_db: 6.48147,
            seen: -0.18127,
            seen_per_ten_db: 0.55511,
            seen_per_room: 3.72442,
        },
        // flash
        Point {
            range_m: -0.00012,
            range_sigma_m: 0.002,
            across_m: 0.00283,
            across_sigma_m: 0.01326,
            across_per_width_m: -0.11014,
            sigma_per_width_m: 0.05,
            snr_db: 29.87114,
            snr_per_db: 0.9537,
            snr_sigma_db: 4.24385,
            seen: 1.14873,
            seen_per_ten_db: 0.24242,
            seen_per_room: 0.4057,
        },
        // top
        Point {
            range_m: -0.00264,
            range_sigma_m: 0.00261,
            across_m: -0.0248,
            across_sigma_m: 0.01487,
            across_per_width_m: -0.08232,
            sigma_per_width_m: 0.06532,
            snr_db: 19.15603,
            snr_per_db: 0.9035,
            snr_sigma_db: 7.00964,
            seen: 0.08005,
            seen_per_ten_db: 0.00499,
            seen_per_room: 1.22367,
        },
        // hidden
        Point {
            range_m: -0.00042,
            range_sigma_m: 0.002,
            across_m: 0.0,
            across_sigma_m: 0.0,
            across_per_width_m: 0.0,
            sigma_per_width_m: 0.16838,
            snr_db: 11.21688,
            snr_per_db: 0.75623,
            snr_sigma_db: 8.87765,
            seen: 0.5,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
        // edge below
        Point {
            range_m: 0.00098,
            range_sigma_m: 0.002,
            across_m: -0.00343,
            across_sigma_m: 0.00737,
            across_per_width_m: -0.11388,
            sigma_per_width_m: 0.05,
            snr_db: 21.72824,
            snr_per_db: 0.77125,
            snr_sigma_db: 7.81341,
            seen: 2.0,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
        // edge above
        Point {
            range_m: -0.00361,
            range_sigma_m: 0.00304,
            across_m: -0.03248,
            across_sigma_m: 0.01391,
            across_per_width_m: -0.05333,
            sigma_per_width_m: 0.05003,
            snr_db: 21.01355,
            snr_per_db: 0.86235,
            snr_sigma_db: 10.16981,
            seen: 1.5,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
    ],
    extended: [
        // face
        Extended {
            rate: -0.19784,
            rate_per_ten_db: 0.05998,
            snr_db: 8.54042,
            snr_per_db: 0.66037,
            snr_sigma_db: 9.62558,
            off_sigma_m: 0.00986,
        },
        // tread
        Extended {
            rate: 0.81533,
            rate_per_ten_db: 0.13234,
            snr_db: -4.05292,
            snr_per_db: 0.5627,
            snr_sigma_db: 11.11116,
            off_sigma_m: 0.003,
        },
        // floor
        Extended {
            rate: 2.536,
            rate_per_ten_db: 0.11365,
            snr_db: 0.25015,
            snr_per_db: 0.38342,
            snr_sigma_db: 11.52761,
            off_sigma_m: 0.003,
        },
        // air
        Extended {
            rate: -12.19475,
            rate_per_ten_db: 2.78667,
            snr_db: 24.76812,
            snr_per_db: -0.10456,
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
            rate: 1.52841,
            rate_per_ten_db: 0.0,
            snr_db: 0.0,
            snr_per_db: 0.0,
            snr_sigma_db: 6.86556,
            off_sigma_m: 0.0,
        },
    ],
    hidden: Hidden {
        low: [0.78325, 0.00226, 0.00947],
        top: [0.21545, -0.03576, 0.00758],
        nothing: [-3.03735, -0.55049, 2.33512, -0.46116],
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
