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
            across_per_width_m: 0.03268,
            sigma_per_width_m: 0.05,
            snr_db: 27.91558,
            snr_per_db: 0.99142,
            snr_sigma_db: 4.21993,
            seen: -0.61355,
            seen_per_ten_db: 0.46711,
            seen_per_room: 3.45159,
        },
        // nosing
        Point {
            range_m: 0.0016,
            range_sigma_m: 0.002,
            across_m: -0.00305,
            across_sigma_m: 0.00233,
            across_per_width_m: -0.04414,
            sigma_per_width_m: 0.05,
            snr_db: 14.33221,
            snr_per_db: 0.82567,
            snr_sigma_db: 6.26758,
            seen: -5.54678,
            seen_per_ten_db: 0.37474,
            seen_per_room: 7.29184,
        },
        // flash
        Point {
            range_m: -4e-5,
            range_sigma_m: 0.002,
            across_m: 0.00122,
            across_sigma_m: 0.00923,
            across_per_width_m: -0.06303,
            sigma_per_width_m: 0.10399,
            snr_db: 30.56458,
            snr_per_db: 0.9706,
            snr_sigma_db: 3.53018,
            seen: 0.76006,
            seen_per_ten_db: -0.03577,
            seen_per_room: 0.88466,
        },
        // top
        Point {
            range_m: -0.00172,
            range_sigma_m: 0.00226,
            across_m: -0.03146,
            across_sigma_m: 0.01052,
            across_per_width_m: 0.01734,
            sigma_per_width_m: 0.05001,
            snr_db: 23.90164,
            snr_per_db: 0.95043,
            snr_sigma_db: 6.82625,
            seen: -2.61568,
            seen_per_ten_db: -0.12388,
            seen_per_room: 2.50683,
        },
        // hidden
        Point {
            range_m: -0.00016,
            range_sigma_m: 0.002,
            across_m: 0.0,
            across_sigma_m: 0.0,
            across_per_width_m: 0.0,
            sigma_per_width_m: 0.05,
            snr_db: 14.67911,
            snr_per_db: 0.79664,
            snr_sigma_db: 8.50694,
            seen: 0.5,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
        // edge below
        Point {
            range_m: 0.0012,
            range_sigma_m: 0.002,
            across_m: -0.00447,
            across_sigma_m: 0.00584,
            across_per_width_m: -0.04008,
            sigma_per_width_m: 0.05,
            snr_db: 21.59888,
            snr_per_db: 0.85721,
            snr_sigma_db: 7.55704,
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
            rate: -1.79792,
            rate_per_ten_db: -0.03522,
            snr_db: 11.56276,
            snr_per_db: 0.71558,
            snr_sigma_db: 10.32107,
            off_sigma_m: 0.00923,
        },
        // tread
        Extended {
            rate: 0.62712,
            rate_per_ten_db: 0.22736,
            snr_db: -9.5284,
            snr_per_db: 0.40773,
            snr_sigma_db: 11.44098,
            off_sigma_m: 0.003,
        },
        // floor
        Extended {
            rate: 1.90621,
            rate_per_ten_db: 0.11774,
            snr_db: -1.90133,
            snr_per_db: 0.4494,
            snr_sigma_db: 11.16949,
            off_sigma_m: 0.003,
        },
        // air
        Extended {
            rate: -1.24189,
            rate_per_ten_db: 0.70139,
            snr_db: 14.25254,
            snr_per_db: 0.02199,
            snr_sigma_db: 5.33949,
            off_sigma_m: 0.0,
        },
        // inside
        Extended {
            rate: -3.44714,
            rate_per_ten_db: 0.94191,
            snr_db: -3.44386,
            snr_per_db: 0.79981,
            snr_sigma_db: 5.18909,
            off_sigma_m: 0.0,
        },
        // noise
        Extended {
            rate: 0.93885,
            rate_per_ten_db: 0.0,
            snr_db: 0.0,
            snr_per_db: 0.0,
            snr_sigma_db: 0.57116,
            off_sigma_m: 0.0,
        },
    ],
    hidden: Hidden {
        low: [0.44737, 0.00661, 0.00507],
        top: [0.11647, -0.0394, 0.00871],
        nothing: [-2.74865, -0.83261, 0.9326, -0.50722],
    },
};
