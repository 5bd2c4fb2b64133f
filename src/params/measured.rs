//! The measurement model, counted from simulated scans: written by `cargo sim fit`.

use super::generative::{Extended, Generative, Hidden, Point};

/// In the depth plane.
pub static UP: Generative = Generative {
    points: [
        // corner
        Point {
            range_m: -0.00032,
            range_sigma_m: 0.002,
            across_m: -0.00059,
            across_sigma_m: 0.0015,
            across_per_width_m: 0.03468,
            sigma_per_width_m: 0.05,
            snr_db: 27.88416,
            snr_per_db: 0.99276,
            snr_sigma_db: 4.24016,
            seen: -0.61286,
            seen_per_ten_db: 0.45994,
            seen_per_room: 3.47554,
        },
        // nosing
        Point {
            range_m: 0.0016,
            range_sigma_m: 0.002,
            across_m: -0.00325,
            across_sigma_m: 0.00269,
            across_per_width_m: -0.04208,
            sigma_per_width_m: 0.05,
            snr_db: 14.3632,
            snr_per_db: 0.82432,
            snr_sigma_db: 6.27428,
            seen: -5.69464,
            seen_per_ten_db: 0.37775,
            seen_per_room: 7.44764,
        },
        // flash
        Point {
            range_m: -4e-5,
            range_sigma_m: 0.002,
            across_m: 0.00117,
            across_sigma_m: 0.00898,
            across_per_width_m: -0.06247,
            sigma_per_width_m: 0.10425,
            snr_db: 30.55307,
            snr_per_db: 0.97017,
            snr_sigma_db: 3.54273,
            seen: 0.7606,
            seen_per_ten_db: -0.03305,
            seen_per_room: 0.8741,
        },
        // top
        Point {
            range_m: -0.00173,
            range_sigma_m: 0.00226,
            across_m: -0.0314,
            across_sigma_m: 0.01041,
            across_per_width_m: 0.01683,
            sigma_per_width_m: 0.05001,
            snr_db: 23.90164,
            snr_per_db: 0.95043,
            snr_sigma_db: 6.82625,
            seen: -2.61742,
            seen_per_ten_db: -0.12284,
            seen_per_room: 2.50586,
        },
        // hidden
        Point {
            range_m: -0.00014,
            range_sigma_m: 0.002,
            across_m: 0.0,
            across_sigma_m: 0.0,
            across_per_width_m: 0.0,
            sigma_per_width_m: 0.05,
            snr_db: 14.61828,
            snr_per_db: 0.79888,
            snr_sigma_db: 8.51852,
            seen: 0.5,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
        // edge below
        Point {
            range_m: 0.0012,
            range_sigma_m: 0.002,
            across_m: -0.0045,
            across_sigma_m: 0.00577,
            across_per_width_m: -0.03998,
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
            range_m: -0.00357,
            range_sigma_m: 0.0032,
            across_m: -0.03154,
            across_sigma_m: 0.01428,
            across_per_width_m: -0.01581,
            sigma_per_width_m: 0.05,
            snr_db: 18.8295,
            snr_per_db: 0.99013,
            snr_sigma_db: 10.36778,
            seen: 1.5,
            seen_per_ten_db: 0.3,
            seen_per_room: 0.0,
        },
    ],
    extended: [
        // face
        Extended {
            rate: -1.80279,
            rate_per_ten_db: -0.0276,
            snr_db: 11.47843,
            snr_per_db: 0.72356,
            snr_sigma_db: 10.40201,
            off_sigma_m: 0.00919,
        },
        // tread
        Extended {
            rate: 0.62642,
            rate_per_ten_db: 0.22791,
            snr_db: -9.53757,
            snr_per_db: 0.40822,
            snr_sigma_db: 11.44348,
            off_sigma_m: 0.003,
        },
        // floor
        Extended {
            rate: 1.90558,
            rate_per_ten_db: 0.11825,
            snr_db: -1.82835,
            snr_per_db: 0.45017,
            snr_sigma_db: 11.12755,
            off_sigma_m: 0.003,
        },
        // air
        Extended {
            rate: -1.23755,
            rate_per_ten_db: 0.69877,
            snr_db: 14.23603,
            snr_per_db: 0.02207,
            snr_sigma_db: 5.33494,
            off_sigma_m: 0.0,
        },
        // inside
        Extended {
            rate: -3.44889,
            rate_per_ten_db: 0.94061,
            snr_db: -3.46873,
            snr_per_db: 0.80036,
            snr_sigma_db: 5.20751,
            off_sigma_m: 0.0,
        },
        // noise
        Extended {
            rate: 0.93858,
            rate_per_ten_db: 0.0,
            snr_db: 0.0,
            snr_per_db: 0.0,
            snr_sigma_db: 0.57034,
            off_sigma_m: 0.0,
        },
    ],
    hidden: Hidden {
        low: [0.45226, 0.00654, 0.0049],
        top: [0.11784, -0.03943, 0.00865],
        nothing: [-2.76631, -0.82757, 0.98545, -0.48824],
    },
};
