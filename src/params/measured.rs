//! The measurement model, counted from simulated scans: written by `cargo sim fit`.

use super::generative::{Extended, Generative, Hidden, Point};

/// In the depth plane.
pub static UP: Generative = Generative {
    points: [
        // corner
        Point {
            range_m: -0.00024,
            range_sigma_m: 0.002,
            across_m: -0.00061,
            across_sigma_m: 0.0015,
            across_per_width_m: 0.03145,
            sigma_per_width_m: 0.05,
            snr_db: 28.13953,
            snr_per_db: 0.99249,
            snr_sigma_db: 3.90835,
            seen: -0.76204,
            seen_per_ten_db: 0.41098,
            seen_per_room: 2.87585,
        },
        // nosing
        Point {
            range_m: 0.00146,
            range_sigma_m: 0.002,
            across_m: -0.0025,
            across_sigma_m: 0.0024,
            across_per_width_m: -0.04881,
            sigma_per_width_m: 0.05,
            snr_db: 13.31513,
            snr_per_db: 0.85145,
            snr_sigma_db: 5.75966,
            seen: -7.18524,
            seen_per_ten_db: 0.34813,
            seen_per_room: 9.10747,
        },
        // flash
        Point {
            range_m: -0.00011,
            range_sigma_m: 0.002,
            across_m: -0.00064,
            across_sigma_m: 0.01005,
            across_per_width_m: -0.05666,
            sigma_per_width_m: 0.06786,
            snr_db: 30.43377,
            snr_per_db: 0.97704,
            snr_sigma_db: 3.37282,
            seen: 0.3684,
            seen_per_ten_db: 0.08869,
            seen_per_room: 0.6176,
        },
        // top
        Point {
            range_m: -0.00156,
            range_sigma_m: 0.00206,
            across_m: -0.02799,
            across_sigma_m: 0.01013,
            across_per_width_m: -0.0372,
            sigma_per_width_m: 0.05001,
            snr_db: 23.45225,
            snr_per_db: 0.93367,
            snr_sigma_db: 7.66369,
            seen: -2.14575,
            seen_per_ten_db: -0.04645,
            seen_per_room: 2.33218,
        },
        // hidden
        Point {
            range_m: -0.00029,
            range_sigma_m: 0.002,
            across_m: 0.0,
            across_sigma_m: 0.0,
            across_per_width_m: 0.0,
            sigma_per_width_m: 0.05,
            snr_db: 12.69139,
            snr_per_db: 0.91537,
            snr_sigma_db: 8.74612,
            seen: 0.5,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
        // edge below
        Point {
            range_m: 0.00154,
            range_sigma_m: 0.002,
            across_m: -0.00496,
            across_sigma_m: 0.00654,
            across_per_width_m: -0.04389,
            sigma_per_width_m: 0.05,
            snr_db: 22.2211,
            snr_per_db: 0.83842,
            snr_sigma_db: 6.8922,
            seen: 2.0,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
        // edge above
        Point {
            range_m: -0.00372,
            range_sigma_m: 0.00331,
            across_m: -0.03054,
            across_sigma_m: 0.01265,
            across_per_width_m: -0.0232,
            sigma_per_width_m: 0.05001,
            snr_db: 17.56919,
            snr_per_db: 1.0879,
            snr_sigma_db: 10.65664,
            seen: 1.5,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
    ],
    extended: [
        // face
        Extended {
            rate: -1.92881,
            rate_per_ten_db: 0.00281,
            snr_db: 9.66732,
            snr_per_db: 0.76481,
            snr_sigma_db: 11.46763,
            off_sigma_m: 0.00754,
        },
        // tread
        Extended {
            rate: 0.58169,
            rate_per_ten_db: 0.20264,
            snr_db: -9.26808,
            snr_per_db: 0.2619,
            snr_sigma_db: 11.507,
            off_sigma_m: 0.003,
        },
        // floor
        Extended {
            rate: 1.80964,
            rate_per_ten_db: 0.147,
            snr_db: -0.3234,
            snr_per_db: 0.47549,
            snr_sigma_db: 10.27495,
            off_sigma_m: 0.003,
        },
        // air
        Extended {
            rate: -1.31502,
            rate_per_ten_db: 0.63845,
            snr_db: 10.57323,
            snr_per_db: 0.18595,
            snr_sigma_db: 5.23997,
            off_sigma_m: 0.0,
        },
        // inside
        Extended {
            rate: -3.15498,
            rate_per_ten_db: 0.84918,
            snr_db: 0.61921,
            snr_per_db: 0.60709,
            snr_sigma_db: 4.48254,
            off_sigma_m: 0.0,
        },
        // noise
        Extended {
            rate: 1.05691,
            rate_per_ten_db: 0.0,
            snr_db: 0.0,
            snr_per_db: 0.0,
            snr_sigma_db: 0.58032,
            off_sigma_m: 0.0,
        },
    ],
    hidden: Hidden {
        low: [0.41705, 0.00564, 0.004],
        top: [0.10056, -0.04332, 0.01161],
        nothing: [-3.05353, -0.94884, 1.13584, -0.25597],
    },
};
