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
            across_per_width_m: 0.17276,
            sigma_per_width_m: 0.11027,
            snr_db: 26.67191,
            snr_per_db: 1.01624,
            snr_sigma_db: 5.23205,
            seen: 1.21973,
            seen_per_ten_db: 0.23219,
            seen_per_room: 2.84085,
        },
        // nosing
        Point {
            range_m: 0.00109,
            range_sigma_m: 0.0021,
            across_m: -0.00374,
            across_sigma_m: 0.00393,
            across_per_width_m: -0.12576,
            sigma_per_width_m: 0.07227,
            snr_db: 14.22558,
            snr_per_db: 0.82562,
            snr_sigma_db: 6.46276,
            seen: -0.21124,
            seen_per_ten_db: 0.565,
            seen_per_room: 3.64437,
        },
        // flash
        Point {
            range_m: -0.00011,
            range_sigma_m: 0.002,
            across_m: 0.00253,
            across_sigma_m: 0.01351,
            across_per_width_m: -0.10775,
            sigma_per_width_m: 0.05,
            snr_db: 29.80386,
            snr_per_db: 0.95418,
            snr_sigma_db: 4.31531,
            seen: 1.18015,
            seen_per_ten_db: 0.22095,
            seen_per_room: 0.40346,
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
            seen: 0.07479,
            seen_per_ten_db: 0.0097,
            seen_per_room: 1.22579,
        },
        // hidden
        Point {
            range_m: -0.00039,
            range_sigma_m: 0.002,
            across_m: 0.0,
            across_sigma_m: 0.0,
            across_per_width_m: 0.0,
            sigma_per_width_m: 0.16449,
            snr_db: 11.36875,
            snr_per_db: 0.75703,
            snr_sigma_db: 8.8431,
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
            rate: -0.19706,
            rate_per_ten_db: 0.06037,
            snr_db: 8.54215,
            snr_per_db: 0.65915,
            snr_sigma_db: 9.64188,
            off_sigma_m: 0.00986,
        },
        // tread
        Extended {
            rate: 0.80269,
            rate_per_ten_db: 0.13298,
            snr_db: -4.44478,
            snr_per_db: 0.57008,
            snr_sigma_db: 11.25734,
            off_sigma_m: 0.003,
        },
        // floor
        Extended {
            rate: 2.54844,
            rate_per_ten_db: 0.10874,
            snr_db: 0.33921,
            snr_per_db: 0.38185,
            snr_sigma_db: 11.47632,
            off_sigma_m: 0.003,
        },
        // air
        Extended {
            rate: -12.25508,
            rate_per_ten_db: 2.72981,
            snr_db: 24.13481,
            snr_per_db: -0.09538,
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
            rate: 1.53122,
            rate_per_ten_db: 0.0,
            snr_db: 0.0,
            snr_per_db: 0.0,
            snr_sigma_db: 6.88628,
            off_sigma_m: 0.0,
        },
    ],
    hidden: Hidden {
        low: [0.78792, 0.00216, 0.00957],
        top: [0.2108, -0.03593, 0.00735],
        nothing: [-3.03501, -0.53975, 2.34855, -0.4703],
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
