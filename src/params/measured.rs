//! The measurement model, counted from simulated scans: written by `cargo sim fit`.

use super::generative::{Extended, Generative, Hidden, Point, TreadEnd, TreadNumbers};

/// Of both planes.
pub static MODEL: Generative = Generative {
    points: [
        // corner
        Point {
            range_m: -0.00026,
            range_sigma_m: 0.002,
            across_m: -0.00054,
            across_sigma_m: 0.0015,
            across_per_width_m: 0.03395,
            sigma_per_width_m: 0.05,
            snr_db: 27.73512,
            snr_per_db: 1.00145,
            snr_sigma_db: 4.42931,
            seen: -0.46767,
            seen_per_ten_db: 0.37594,
            seen_per_room: 3.18838,
        },
        // nosing
        Point {
            range_m: 0.00159,
            range_sigma_m: 0.002,
            across_m: -0.00324,
            across_sigma_m: 0.0028,
            across_per_width_m: -0.0431,
            sigma_per_width_m: 0.05,
            snr_db: 14.36054,
            snr_per_db: 0.83166,
            snr_sigma_db: 6.49903,
            seen: -6.5343,
            seen_per_ten_db: 0.33613,
            seen_per_room: 8.37507,
        },
        // flash
        Point {
            range_m: -3e-5,
            range_sigma_m: 0.002,
            across_m: 0.00219,
            across_sigma_m: 0.00962,
            across_per_width_m: -0.0763,
            sigma_per_width_m: 0.08401,
            snr_db: 30.6991,
            snr_per_db: 0.95752,
            snr_sigma_db: 3.47753,
            seen: 0.52535,
            seen_per_ten_db: 0.13171,
            seen_per_room: 0.66806,
        },
        // top
        Point {
            range_m: -0.00137,
            range_sigma_m: 0.00222,
            across_m: -0.02835,
            across_sigma_m: 0.00905,
            across_per_width_m: -0.01322,
            sigma_per_width_m: 0.05,
            snr_db: 24.11015,
            snr_per_db: 0.94293,
            snr_sigma_db: 6.83303,
            seen: -2.73835,
            seen_per_ten_db: -0.10723,
            seen_per_room: 2.92662,
        },
        // hidden
        Point {
            range_m: -0.00014,
            range_sigma_m: 0.002,
            across_m: 0.0,
            across_sigma_m: 0.0,
            across_per_width_m: 0.0,
            sigma_per_width_m: 0.05,
            snr_db: 15.05239,
            snr_per_db: 0.78695,
            snr_sigma_db: 8.27236,
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
            rate: -1.72681,
            rate_per_ten_db: -0.07518,
            snr_db: 9.77865,
            snr_per_db: 0.72727,
            snr_sigma_db: 10.66389,
            off_sigma_m: 0.00792,
        },
        // tread
        Extended {
            rate: 0.65483,
            rate_per_ten_db: 0.19128,
            snr_db: -9.16991,
            snr_per_db: 0.34606,
            snr_sigma_db: 11.36693,
            off_sigma_m: 0.003,
        },
        // floor
        Extended {
            rate: 1.94117,
            rate_per_ten_db: 0.10829,
            snr_db: -4.34702,
            snr_per_db: 0.41608,
            snr_sigma_db: 12.65065,
            off_sigma_m: 0.003,
        },
        // air
        Extended {
            rate: -1.26655,
            rate_per_ten_db: 0.67879,
            snr_db: 12.95434,
            snr_per_db: 0.06187,
            snr_sigma_db: 5.11987,
            off_sigma_m: 0.0,
        },
        // inside
        Extended {
            rate: -3.37711,
            rate_per_ten_db: 0.92562,
            snr_db: 0.13143,
            snr_per_db: 0.60635,
            snr_sigma_db: 5.74026,
            off_sigma_m: 0.0,
        },
        // noise
        Extended {
            rate: 0.98409,
            rate_per_ten_db: 0.0,
            snr_db: 0.0,
            snr_per_db: 0.0,
            snr_sigma_db: 0.56762,
            off_sigma_m: 0.0,
        },
    ],
    hidden: Hidden {
        low: [0.50516, 0.00667, 0.00627],
        top: [0.08942, -0.03924, 0.00638],
        nothing: [-2.73507, -0.78794, 0.91494, -0.45661],
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
