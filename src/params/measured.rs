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
            across_per_width_m: 0.17754,
            sigma_per_width_m: 0.11456,
            snr_db: 26.68108,
            snr_per_db: 1.0162,
            snr_sigma_db: 5.23036,
            seen: 1.22823,
            seen_per_ten_db: 0.23414,
            seen_per_room: 2.81671,
        },
        // nosing
        Point {
            range_m: 0.00109,
            range_sigma_m: 0.00212,
            across_m: -0.00373,
            across_sigma_m: 0.00389,
            across_per_width_m: -0.12672,
            sigma_per_width_m: 0.07281,
            snr_db: 14.26538,
            snr_per_db: 0.82443,
            snr_sigma_db: 6.48853,
            seen: -0.14446,
            seen_per_ten_db: 0.56938,
            seen_per_room: 3.67473,
        },
        // flash
        Point {
            range_m: -0.00011,
            range_sigma_m: 0.002,
            across_m: 0.0026,
            across_sigma_m: 0.01341,
            across_per_width_m: -0.10629,
            sigma_per_width_m: 0.05,
            snr_db: 29.8294,
            snr_per_db: 0.95262,
            snr_sigma_db: 4.29704,
            seen: 1.14789,
            seen_per_ten_db: 0.2193,
            seen_per_room: 0.351,
        },
        // top
        Point {
            range_m: -0.00264,
            range_sigma_m: 0.0026,
            across_m: -0.02486,
            across_sigma_m: 0.01496,
            across_per_width_m: -0.08363,
            sigma_per_width_m: 0.06595,
            snr_db: 19.18233,
            snr_per_db: 0.90352,
            snr_sigma_db: 7.0212,
            seen: 0.07273,
            seen_per_ten_db: 0.0105,
            seen_per_room: 1.22625,
        },
        // hidden
        Point {
            range_m: -0.00039,
            range_sigma_m: 0.002,
            across_m: 0.0,
            across_sigma_m: 0.0,
            across_per_width_m: 0.0,
            sigma_per_width_m: 0.16507,
            snr_db: 11.37027,
            snr_per_db: 0.75471,
            snr_sigma_db: 8.84604,
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
            across_per_width_m: -0.11355,
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
            across_m: -0.03247,
            across_sigma_m: 0.0139,
            across_per_width_m: -0.05862,
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
            rate: -0.19797,
            rate_per_ten_db: 0.06037,
            snr_db: 8.50655,
            snr_per_db: 0.66128,
            snr_sigma_db: 9.63973,
            off_sigma_m: 0.00986,
        },
        // tread
        Extended {
            rate: 0.81537,
            rate_per_ten_db: 0.13393,
            snr_db: -4.11809,
            snr_per_db: 0.56295,
            snr_sigma_db: 11.14665,
            off_sigma_m: 0.003,
        },
        // floor
        Extended {
            rate: 2.53566,
            rate_per_ten_db: 0.1135,
            snr_db: 0.35436,
            snr_per_db: 0.38106,
            snr_sigma_db: 11.47494,
            off_sigma_m: 0.003,
        },
        // air
        Extended {
            rate: -12.19701,
            rate_per_ten_db: 2.76173,
            snr_db: 24.68376,
            snr_per_db: -0.10938,
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
            rate: 1.52791,
            rate_per_ten_db: 0.0,
            snr_db: 0.0,
            snr_per_db: 0.0,
            snr_sigma_db: 6.86785,
            off_sigma_m: 0.0,
        },
    ],
    hidden: Hidden {
        low: [0.78598, 0.00217, 0.00951],
        top: [0.21274, -0.0357, 0.00738],
        nothing: [-3.03066, -0.54213, 2.34884, -0.46598],
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
