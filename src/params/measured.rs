//! The measurement model, counted from simulated scans: written by `cargo study fit`.

use super::generative::{Extended, Generative, Hidden, Point, TreadEnd, TreadNumbers};

/// Parameters of both planes.
pub static MODEL: Generative = Generative {
    points: [
        // corner
        Point {
            range_m: -0.00026,
            range_sigma_m: 0.002,
            across_m: -0.00054,
            across_sigma_m: 0.0015,
            across_per_width_m: 0.03405,
            sigma_per_width_m: 0.05,
            snr_db: 27.75838,
            snr_per_db: 1.00125,
            snr_sigma_db: 4.42271,
            seen: -0.44719,
            seen_per_ten_db: 0.37288,
            seen_per_room: 3.16429,
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
            seen: -6.53507,
            seen_per_ten_db: 0.33616,
            seen_per_room: 8.37491,
        },
        // flash
        Point {
            range_m: -3e-5,
            range_sigma_m: 0.002,
            across_m: 0.00217,
            across_sigma_m: 0.00963,
            across_per_width_m: -0.07589,
            sigma_per_width_m: 0.08365,
            snr_db: 30.69914,
            snr_per_db: 0.95752,
            snr_sigma_db: 3.47911,
            seen: 0.5285,
            seen_per_ten_db: 0.1312,
            seen_per_room: 0.66337,
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
            seen: -2.73608,
            seen_per_ten_db: -0.10725,
            seen_per_room: 2.92631,
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
            rate: -1.726,
            rate_per_ten_db: -0.07566,
            snr_db: 9.78659,
            snr_per_db: 0.72709,
            snr_sigma_db: 10.66765,
            off_sigma_m: 0.00792,
        },
        // tread
        Extended {
            rate: 0.65243,
            rate_per_ten_db: 0.1918,
            snr_db: -9.17951,
            snr_per_db: 0.3448,
            snr_sigma_db: 11.36642,
            off_sigma_m: 0.003,
        },
        // floor
        Extended {
            rate: 1.92639,
            rate_per_ten_db: 0.11539,
            snr_db: -4.60638,
            snr_per_db: 0.4083,
            snr_sigma_db: 12.82727,
            off_sigma_m: 0.003,
        },
        // air
        Extended {
            rate: -1.26789,
            rate_per_ten_db: 0.67946,
            snr_db: 12.95969,
            snr_per_db: 0.06179,
            snr_sigma_db: 5.13013,
            off_sigma_m: 0.0,
        },
        // inside
        Extended {
            rate: -3.3778,
            rate_per_ten_db: 0.9253,
            snr_db: 0.1231,
            snr_per_db: 0.60645,
            snr_sigma_db: 5.74595,
            off_sigma_m: 0.0,
        },
        // noise
        Extended {
            rate: 0.98449,
            rate_per_ten_db: 0.0,
            snr_db: 0.0,
            snr_per_db: 0.0,
            snr_sigma_db: 0.56758,
            off_sigma_m: 0.0,
        },
    ],
    hidden: Hidden {
        low: [0.50516, 0.00667, 0.00627],
        top: [0.08942, -0.03924, 0.00638],
        nothing: [-2.74193, -0.78891, 0.92164, -0.45602],
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
