//! The measurement model, counted from simulated scans: written by `cargo sim fit`.

use super::generative::{Extended, Generative, Hidden, Point};

/// In the depth plane.
pub static UP: Generative = Generative {
    points: [
        // corner
        Point {
            range_m: -0.00032,
            range_sigma_m: 0.002,
            across_m: -0.00054,
            across_sigma_m: 0.0015,
            across_per_width_m: 0.03443,
            sigma_per_width_m: 0.05,
            snr_db: 27.94341,
            snr_per_db: 0.98961,
            snr_sigma_db: 4.19404,
            seen: -0.54615,
            seen_per_ten_db: 0.4309,
            seen_per_room: 3.54679,
        },
        // nosing
        Point {
            range_m: 0.0016,
            range_sigma_m: 0.002,
            across_m: -0.00306,
            across_sigma_m: 0.00239,
            across_per_width_m: -0.04434,
            sigma_per_width_m: 0.05,
            snr_db: 14.37065,
            snr_per_db: 0.82291,
            snr_sigma_db: 6.24995,
            seen: -6.18908,
            seen_per_ten_db: 0.40119,
            seen_per_room: 7.97958,
        },
        // flash
        Point {
            range_m: -5e-5,
            range_sigma_m: 0.002,
            across_m: 0.00117,
            across_sigma_m: 0.00929,
            across_per_width_m: -0.06322,
            sigma_per_width_m: 0.10486,
            snr_db: 30.52316,
            snr_per_db: 0.9737,
            snr_sigma_db: 3.53631,
            seen: 0.75303,
            seen_per_ten_db: -0.03158,
            seen_per_room: 0.86343,
        },
        // top
        Point {
            range_m: -0.0017,
            range_sigma_m: 0.00226,
            across_m: -0.03143,
            across_sigma_m: 0.01054,
            across_per_width_m: 0.01668,
            sigma_per_width_m: 0.05001,
            snr_db: 24.16184,
            snr_per_db: 0.94525,
            snr_sigma_db: 6.61669,
            seen: -2.63916,
            seen_per_ten_db: -0.12262,
            seen_per_room: 2.51514,
        },
        // hidden
        Point {
            range_m: -0.00015,
            range_sigma_m: 0.002,
            across_m: 0.0,
            across_sigma_m: 0.0,
            across_per_width_m: 0.0,
            sigma_per_width_m: 0.05,
            snr_db: 14.67018,
            snr_per_db: 0.7959,
            snr_sigma_db: 8.48521,
            seen: 0.5,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
        // edge below
        Point {
            range_m: 0.0012,
            range_sigma_m: 0.002,
            across_m: -0.00448,
            across_sigma_m: 0.00588,
            across_per_width_m: -0.04005,
            sigma_per_width_m: 0.05,
            snr_db: 21.5873,
            snr_per_db: 0.85778,
            snr_sigma_db: 7.58065,
            seen: 2.0,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
        // edge above
        Point {
            range_m: -0.0036,
            range_sigma_m: 0.00329,
            across_m: -0.0317,
            across_sigma_m: 0.0144,
            across_per_width_m: -0.01571,
            sigma_per_width_m: 0.05,
            snr_db: 18.86169,
            snr_per_db: 0.98901,
            snr_sigma_db: 10.34729,
            seen: 1.5,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
    ],
    extended: [
        // face
        Extended {
            rate: -1.78233,
            rate_per_ten_db: -0.04889,
            snr_db: 11.39176,
            snr_per_db: 0.7247,
            snr_sigma_db: 10.32808,
            off_sigma_m: 0.00913,
        },
        // tread
        Extended {
            rate: 0.64798,
            rate_per_ten_db: 0.2252,
            snr_db: -9.56058,
            snr_per_db: 0.40794,
            snr_sigma_db: 11.36205,
            off_sigma_m: 0.003,
        },
        // floor
        Extended {
            rate: 1.9185,
            rate_per_ten_db: 0.11716,
            snr_db: -1.75669,
            snr_per_db: 0.4469,
            snr_sigma_db: 11.13403,
            off_sigma_m: 0.003,
        },
        // air
        Extended {
            rate: -1.34807,
            rate_per_ten_db: 0.74298,
            snr_db: 13.60836,
            snr_per_db: 0.03851,
            snr_sigma_db: 5.1934,
            off_sigma_m: 0.0,
        },
        // inside
        Extended {
            rate: -3.57532,
            rate_per_ten_db: 0.98509,
            snr_db: -3.5855,
            snr_per_db: 0.80401,
            snr_sigma_db: 5.09412,
            off_sigma_m: 0.0,
        },
        // noise
        Extended {
            rate: 0.94656,
            rate_per_ten_db: 0.0,
            snr_db: 0.0,
            snr_per_db: 0.0,
            snr_sigma_db: 0.56698,
            off_sigma_m: 0.0,
        },
    ],
    hidden: Hidden {
        low: [0.44351, 0.00644, 0.00488],
        top: [0.12164, -0.04021, 0.01002],
        nothing: [-2.94921, -0.89963, 1.08199, -0.52867],
    },
};
