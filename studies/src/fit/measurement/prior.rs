//! Initial values and priors of the measurement model's parameters.
//!
//! Set by hand from the instrument and building practice: ranges within a centimetre, heights within
//! a few centimetres, levels that follow the scene's strongest echo, half of the features detected.
//! The priors are wide: a few dozen samples outweigh them.

use stairscan::params::generative::{Extended, Generative, Hidden, Point, TreadNumbers};

/// Initial SNR at 1 m of corners and specular reflections where the scene's strongest echo has 30 dB, dB.
const BRIGHT_DB: f32 = 25.0;
/// Initial SNR at 1 m of edges and hidden risers where the scene's strongest echo has 30 dB, dB.
const DIM_DB: f32 = 12.0;
/// Initial SNR at 1 m of edges of open treads, which have no stronger neighbour, where the scene's strongest echo has
/// 30 dB, dB.
const OPEN_DB: f32 = 15.0;

const fn point(range_mm: f32, across: [f32; 2], snr_db: f32, seen: f32, room: f32) -> Point {
    Point {
        range_m: 0.0,
        range_sigma_m: 0.001 * range_mm,
        across_m: across[0],
        across_sigma_m: across[1],
        across_per_width_m: 0.0,
        sigma_per_width_m: 0.1,
        snr_db,
        snr_per_db: 0.8,
        snr_sigma_db: 8.0,
        seen,
        seen_per_ten_db: 0.3,
        seen_per_room: room,
    }
}

const fn extended(rate: f32, snr_db: f32, snr_per_db: f32, off_sigma_m: f32) -> Extended {
    Extended {
        rate,
        rate_per_ten_db: 0.5,
        snr_db,
        snr_per_db,
        snr_sigma_db: 6.0,
        off_sigma_m,
    }
}

/// Initial parameters of the measurement model, from which the fit starts.
pub const START: Generative = Generative {
    points: [
        point(4.0, [0.0, 0.005], BRIGHT_DB, 1.5, 1.0),
        point(5.0, [-0.005, 0.015], DIM_DB, 0.5, 1.0),
        point(4.0, [0.0, 0.015], BRIGHT_DB, 1.5, 1.0),
        point(6.0, [-0.02, 0.025], DIM_DB, 0.0, 1.0),
        point(6.0, [0.0, 0.025], DIM_DB, 0.5, 0.0),
        point(6.0, [-0.01, 0.02], OPEN_DB, 2.0, 0.0),
        point(6.0, [-0.02, 0.025], OPEN_DB, 1.5, 0.0),
    ],
    extended: [
        extended(-2.3, 10.0, 0.7, 0.006),
        extended(0.5, 6.0, 0.4, 0.010),
        extended(1.5, 10.0, 0.6, 0.008),
        extended(-3.0, 8.0, 0.5, 0.0),
        extended(-2.0, 6.0, 0.3, 0.0),
        Extended {
            rate: 1.5,
            rate_per_ten_db: 0.0,
            snr_db: 0.0,
            snr_per_db: 0.0,
            snr_sigma_db: 1.0,
            off_sigma_m: 0.0,
        },
    ],
    hidden: Hidden {
        low: [0.4, 0.0, 0.015],
        top: [0.3, -0.015, 0.015],
        nothing: [-3.0, -1.0, 0.5, -0.5],
    },
    treads: TreadNumbers::NOTHING,
};

/// Standard deviations of the priors around [`START`]. Those of standard deviations apply to the
/// excess over their lower bounds.
pub mod sigma {
    /// Standard deviation of the priors of echoes' offsets in range, metres.
    pub const RANGE_M: f64 = 0.005;
    /// Standard deviation of the priors of offsets across the line of sight and in height, metres.
    pub const ACROSS_M: f64 = 0.03;
    /// Standard deviation of the priors of the lobe width's effect on the place across the line of sight, metres per
    /// unit of width.
    pub const WIDTH_M: f64 = 0.2;
    /// Standard deviation of the priors of the echoes' mean SNR, dB.
    pub const SNR_DB: f64 = 15.0;
    /// Standard deviation of the priors of the slopes of the echoes' mean SNR, dB per dB of the scene's strongest echo.
    pub const SNR_PER_DB: f64 = 0.3;
    /// Standard deviation of the prior of the natural logarithm of a rate of echoes.
    pub const RATE: f64 = 3.0;
    /// Standard deviation of the prior of a log-rate's slope, per 10 dB of the scene's strongest echo.
    pub const RATE_PER_TEN_DB: f64 = 1.0;
    /// Standard deviation of the priors of log-odds of detection and their slopes, around 0.
    pub const ODDS: f64 = 3.0;
}

/// Lower bounds of the fitted standard deviations. The labels underestimate the spread: the truth is known to a
/// millimetre, and simulated surfaces are smoother than real ones.
pub mod floor {
    /// Minimum standard deviation of an echo's offset in range, metres.
    pub const RANGE_M: f64 = 0.002;
    /// Minimum standard deviation of an echo's offset across the line of sight, metres.
    pub const ACROSS_M: f64 = 0.0015;
    /// Minimum contribution of a wide lobe to the standard deviation across the line of sight, metres per unit of
    /// width. Labelling truncates the tails, and with too small a value an echo in them supports a wrong height too
    /// strongly.
    pub const WIDTH_M: f64 = 0.05;
    /// Minimum standard deviation of the offsets of hidden risers' echoes, metres.
    pub const HIDDEN_M: f64 = 0.004;
    /// Minimum standard deviation of an extended feature's echoes about its surface, metres.
    pub const OFF_M: f64 = 0.003;
    /// Minimum standard deviation of the SNR of a point feature's echoes, dB.
    pub const POINT_DB: f64 = 3.0;
    /// Minimum standard deviation of the SNR of an extended feature's echoes, dB.
    pub const EXTENDED_DB: f64 = 2.0;
    /// Minimum of the mean SNR of noise echoes less the detection threshold, dB.
    pub const NOISE_DB: f64 = 0.3;
}
