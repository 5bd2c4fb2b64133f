//! The measurement model, counted from simulated scans: written by `cargo sim fit`.

use super::generative::{Extended, Generative, Hidden, Point};

/// In the depth plane.
pub static UP: Generative = Generative {
    points: [
        // corner
        Point {
            range_m: -0.00031,
            range_sigma_m: 0.002,
            across_m: -0.00053,
            across_sigma_m: 0.0015,
            across_per_width_m: 0.03357,
            sigma_per_width_m: 0.05,
            snr_db: 27.93405,
            snr_per_db: 0.99067,
            snr_sigma_db: 4.19638,
            seen: -0.54773,
            seen_per_ten_db: 0.4308,
            seen_per_room: 3.5273,
        },
        // nosing
        Point {
            range_m: 0.0016,
            range_sigma_m: 0.002,
            across_m: -0.00307,
            across_sigma_m: 0.00235,
            across_per_width_m: -0.04399,
            sigma_per_width_m: 0.05,
            snr_db: 14.35292,
            snr_per_db: 0.82488,
            snr_sigma_db: 6.24475,
            seen: -6.21099,
            seen_per_ten_db: 0.40856,
            seen_per_room: 8.00404,
        },
        // flash
        Point {
            range_m: -4e-5,
            range_sigma_m: 0.002,
            across_m: 0.00121,
            across_sigma_m: 0.00926,
            across_per_width_m: -0.06272,
            sigma_per_width_m: 0.10323,
            snr_db: 30.53493,
            snr_per_db: 0.97238,
            snr_sigma_db: 3.53206,
            seen: 0.77969,
            seen_per_ten_db: -0.0491,
            seen_per_room: 0.89027,
        },
        // top
        Point {
            range_m: -0.00172,
            range_sigma_m: 0.00226,
            across_m: -0.03146,
            across_sigma_m: 0.01051,
            across_per_width_m: 0.01734,
            sigma_per_width_m: 0.05001,
            snr_db: 23.90164,
            snr_per_db: 0.95043,
            snr_sigma_db: 6.82625,
            seen: -2.60977,
            seen_per_ten_db: -0.12855,
            seen_per_room: 2.50597,
        },
        // hidden
        Point {
            range_m: -0.00015,
            range_sigma_m: 0.002,
            across_m: 0.0,
            across_sigma_m: 0.0,
            across_per_width_m: 0.0,
            sigma_per_width_m: 0.05,
            snr_db: 14.65156,
            snr_per_db: 0.79756,
            snr_sigma_db: 8.49961,
            seen: 0.5,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
        // edge below
        Point {
            range_m: 0.0012,
            range_sigma_m: 0.002,
            across_m: -0.00448,
            across_sigma_m: 0.00586,
            across_per_width_m: -0.03995,
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
            range_m: -0.00359,
            range_sigma_m: 0.00323,
            across_m: -0.03163,
            across_sigma_m: 0.01433,
            across_per_width_m: -0.01589,
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
            rate: -1.7855,
            rate_per_ten_db: -0.04676,
            snr_db: 11.41025,
            snr_per_db: 0.72426,
            snr_sigma_db: 10.32434,
            off_sigma_m: 0.00909,
        },
        // tread
        Extended {
            rate: 0.63417,
            rate_per_ten_db: 0.2256,
            snr_db: -9.4957,
            snr_per_db: 0.4152,
            snr_sigma_db: 11.37194,
            off_sigma_m: 0.003,
        },
        // floor
        Extended {
            rate: 1.90976,
            rate_per_ten_db: 0.1178,
            snr_db: -2.05466,
            snr_per_db: 0.44693,
            snr_sigma_db: 11.2661,
            off_sigma_m: 0.003,
        },
        // air
        Extended {
            rate: -1.35502,
            rate_per_ten_db: 0.74208,
            snr_db: 13.64385,
            snr_per_db: 0.04257,
            snr_sigma_db: 5.11074,
            off_sigma_m: 0.0,
        },
        // inside
        Extended {
            rate: -3.54943,
            rate_per_ten_db: 0.97571,
            snr_db: -3.53127,
            snr_per_db: 0.80223,
            snr_sigma_db: 5.10007,
            off_sigma_m: 0.0,
        },
        // noise
        Extended {
            rate: 0.93698,
            rate_per_ten_db: 0.0,
            snr_db: 0.0,
            snr_per_db: 0.0,
            snr_sigma_db: 0.56935,
            off_sigma_m: 0.0,
        },
    ],
    hidden: Hidden {
        low: [0.44425, 0.0065, 0.00494],
        top: [0.12083, -0.04013, 0.00979],
        nothing: [-2.94934, -0.89914, 1.0825, -0.52849],
    },
};
