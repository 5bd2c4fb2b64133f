//! The measurement model, counted from simulated scans: written by `cargo sim fit`.

use super::generative::{Extended, Generative, Hidden, Point, TreadEnd, TreadNumbers};

/// Of both planes.
pub static MODEL: Generative = Generative {
    points: [
        // corner
        Point {
            range_m: -0.00026,
            range_sigma_m: 0.002,
            across_m: -0.00052,
            across_sigma_m: 0.0015,
            across_per_width_m: 0.0338,
            sigma_per_width_m: 0.05,
            snr_db: 27.66557,
            snr_per_db: 1.0037,
            snr_sigma_db: 4.40621,
            seen: -0.43785,
            seen_per_ten_db: 0.35427,
            seen_per_room: 3.23549,
        },
        // nosing
        Point {
            range_m: 0.00159,
            range_sigma_m: 0.002,
            across_m: -0.00319,
            across_sigma_m: 0.00275,
            across_per_width_m: -0.04379,
            sigma_per_width_m: 0.05,
            snr_db: 14.14077,
            snr_per_db: 0.83815,
            snr_sigma_db: 6.40834,
            seen: -7.09943,
            seen_per_ten_db: 0.36685,
            seen_per_room: 8.93063,
        },
        // flash
        Point {
            range_m: -2e-5,
            range_sigma_m: 0.002,
            across_m: 0.00209,
            across_sigma_m: 0.00956,
            across_per_width_m: -0.0747,
            sigma_per_width_m: 0.08532,
            snr_db: 30.62964,
            snr_per_db: 0.95937,
            snr_sigma_db: 3.49276,
            seen: 0.53241,
            seen_per_ten_db: 0.11991,
            seen_per_room: 0.66122,
        },
        // top
        Point {
            range_m: -0.00139,
            range_sigma_m: 0.00223,
            across_m: -0.02847,
            across_sigma_m: 0.00915,
            across_per_width_m: -0.01274,
            sigma_per_width_m: 0.05,
            snr_db: 24.01055,
            snr_per_db: 0.93991,
            snr_sigma_db: 6.82725,
            seen: -2.75657,
            seen_per_ten_db: -0.11493,
            seen_per_room: 2.96161,
        },
        // hidden
        Point {
            range_m: -0.00013,
            range_sigma_m: 0.002,
            across_m: 0.0,
            across_sigma_m: 0.0,
            across_per_width_m: 0.0,
            sigma_per_width_m: 0.05,
            snr_db: 14.98538,
            snr_per_db: 0.78693,
            snr_sigma_db: 8.29061,
            seen: 0.5,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
        // edge below
        Point {
            range_m: 0.00114,
            range_sigma_m: 0.002,
            across_m: -0.00451,
            across_sigma_m: 0.00627,
            across_per_width_m: -0.03619,
            sigma_per_width_m: 0.05,
            snr_db: 21.41055,
            snr_per_db: 0.80819,
            snr_sigma_db: 7.66107,
            seen: 2.0,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
        // edge above
        Point {
            range_m: -0.00369,
            range_sigma_m: 0.00322,
            across_m: -0.03168,
            across_sigma_m: 0.01309,
            across_per_width_m: -0.01865,
            sigma_per_width_m: 0.05,
            snr_db: 19.53982,
            snr_per_db: 0.92212,
            snr_sigma_db: 10.42113,
            seen: 1.5,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
    ],
    extended: [
        // face
        Extended {
            rate: -1.71865,
            rate_per_ten_db: -0.07462,
            snr_db: 9.54975,
            snr_per_db: 0.73574,
            snr_sigma_db: 10.65285,
            off_sigma_m: 0.00804,
        },
        // tread
        Extended {
            rate: 0.63736,
            rate_per_ten_db: 0.18786,
            snr_db: -9.20677,
            snr_per_db: 0.34615,
            snr_sigma_db: 11.48545,
            off_sigma_m: 0.003,
        },
        // floor
        Extended {
            rate: 1.86065,
            rate_per_ten_db: 0.12495,
            snr_db: -4.14244,
            snr_per_db: 0.41997,
            snr_sigma_db: 12.18313,
            off_sigma_m: 0.003,
        },
        // air
        Extended {
            rate: -1.25354,
            rate_per_ten_db: 0.67436,
            snr_db: 13.02209,
            snr_per_db: 0.0616,
            snr_sigma_db: 5.22536,
            off_sigma_m: 0.0,
        },
        // inside
        Extended {
            rate: -3.35706,
            rate_per_ten_db: 0.91547,
            snr_db: 0.22485,
            snr_per_db: 0.60181,
            snr_sigma_db: 5.75063,
            off_sigma_m: 0.0,
        },
        // noise
        Extended {
            rate: 0.985,
            rate_per_ten_db: 0.0,
            snr_db: 0.0,
            snr_per_db: 0.0,
            snr_sigma_db: 0.56673,
            off_sigma_m: 0.0,
        },
    ],
    hidden: Hidden {
        low: [0.50586, 0.00665, 0.0062],
        top: [0.09043, -0.0395, 0.00644],
        nothing: [-2.75431, -0.79243, 0.94392, -0.45445],
    },
    treads: TreadNumbers {
        rate: [1.90336, -0.0395, -0.34352, 0.11271],
        ratio_m2: [
            0.0, 0.0, 0.0, 0.10044, 0.51997, 1.41686, 2.87879, 4.14447, 3.48251, 2.7328, 3.0457,
            3.45741, 2.4949, 2.74459, 2.62696, 2.53181, 2.61708, 2.62595, 2.78707, 15.76919,
        ],
        height_sigma_m: 0.0018,
        ends: [
            TreadEnd {
                number: 0.62526,
                off_m: 0.00555,
                sigma_m: 0.00408,
            },
            TreadEnd {
                number: 0.0379,
                off_m: 0.01776,
                sigma_m: 0.00311,
            },
        ],
        starts: [
            TreadEnd {
                number: 0.19727,
                off_m: 0.00071,
                sigma_m: 0.00439,
            },
            TreadEnd {
                number: 0.35659,
                off_m: 0.00087,
                sigma_m: 0.00366,
            },
        ],
        edge_sigma_scale: 0.73126,
    },
};
