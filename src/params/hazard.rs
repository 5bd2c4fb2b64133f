//! Types of the horizon's fitted weights, and limits of the features, tuned by hand, with which they were fitted.

use crate::math;

/// Number of features of a cell; `src/infer/horizon.rs` defines each.
pub const FEATURES: usize = 50;

/// Features of a cell.
pub type Features = [f32; FEATURES];

/// Calibration map (Platt scaling) from the log-odds that the model computes to those of the measured frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlattMap {
    /// Change of the calibrated log-odds per unit of the computed ones.
    pub slope: f32,
    /// Calibrated log-odds where the computed ones are 0.
    pub offset: f32,
}

impl PlattMap {
    /// The map that changes nothing.
    pub const IDENTITY: Self = Self {
        slope: 1.0,
        offset: 0.0,
    };

    /// Returns the calibrated probability of something with the share `share` of the particles' weight.
    pub fn calibrated(&self, share: f32) -> f32 {
        self.at(share_log_odds(share))
    }

    /// Returns the calibrated probability at computed log-odds of `log_odds`.
    fn at(&self, log_odds: f32) -> f32 {
        1.0 / (1.0 + math::exp(-(self.slope * log_odds + self.offset)))
    }
}

/// Fitted weights of the horizon for one plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    /// Log-odds of an error in a cell per unit of each feature.
    pub hazard: Features,
    /// Calibration maps of the summed hazards, of answers without steps and with steps. They differ, since a missed
    /// step and a mismeasured one are different errors.
    pub maps: [PlattMap; 2],
    /// Calibration map of the particles' share for things that the answer leaves out.
    pub maybe_map: PlattMap,
    /// Minimum probability of being correct for `ok`, of answers without steps and with steps; above 1 if none is
    /// `ok`.
    pub ok_from: [f32; 2],
}

impl Weights {
    /// Returns the log-probability of no error in a cell: -ln(1 + e^x), where x are the weighted features.
    pub fn log_survival(&self, features: &Features) -> f32 {
        log_survival(self.log_odds(features))
    }

    /// Returns the log-odds of an error in a cell.
    pub fn log_odds(&self, features: &Features) -> f32 {
        let pairs = features.iter().zip(&self.hazard);
        pairs.map(|(feature, weight)| feature * weight).sum()
    }

    /// Returns the probability of being correct where the cells' log-probabilities add up to `log_right`.
    pub fn probability(&self, log_right: f32, stairs: bool) -> f32 {
        probability(&self.maps, log_right, stairs)
    }
}

/// Minimum distance of a share from 0 and 1. Beyond, a few wrong cases would dominate the slope of the map.
const MIN_SHARE: f32 = 0.05;

/// Returns the log-odds of a share of the particles' weight.
pub fn share_log_odds(share: f32) -> f32 {
    let share = share.clamp(MIN_SHARE, 1.0 - MIN_SHARE);
    math::ln(share) - math::ln(1.0 - share)
}

/// Returns the log-probability of no error, where `x` are the log-odds of one.
pub fn log_survival(x: f32) -> f32 {
    let rest = math::log2(1.0 + math::exp(-x.abs()));
    -(math::max(x, 0.0) + core::f32::consts::LN_2 * rest)
}

/// Returns the probability of being correct where log-probabilities add up to `log_right`, by the map of answers
/// without or with steps.
pub fn probability([clear, steps]: &[PlattMap; 2], log_right: f32, stairs: bool) -> f32 {
    let map = if stairs { steps } else { clear };
    let wrong = 1.0 - math::exp(log_right);
    // ln p/(1 - p); no cell has a hazard of exactly 0.
    let log_wrong = math::ln(wrong.max(f32::EPSILON));
    map.at(log_right - log_wrong)
}

// Limits of features.

/// Upper limit of the echoes' SNR in features, dB: that of a corner at half a metre.
pub const MAX_FEATURE_DB: f32 = 50.0;
/// Limit of margins and log-odds in features, nats, of either sign: odds of e^10 count as certain.
pub const MAX_FEATURE_NATS: f32 = 10.0;
/// Upper limit of the feature `model::MIN_EXPANDED_M` divided by the standard deviation of a step's distance.
pub const MAX_FEATURE_SIGMAS: f32 = 4.0;
/// Lower limit, as a feature of an answer without steps, of the margin by the search's scores: best flight less level
/// ground, nats.
pub const MIN_FEATURE_MARGIN: f32 = -2.0;
/// Upper limit, as a feature, of the SNR that a further riser behind the last step would have at least, tens of dB; the
/// lower limit is -1.
pub const MAX_NEXT_FACE: f32 = 3.0;
/// Minimum distance of a way cell's far end from the mirror, metres, at which a scan can show that the ground ends in
/// the cell.
pub const NEAREST_END_M: f32 = 0.45;
/// Going of stairs of which only one step is known, metres: by Blondel's rule for a rise of 17 cm.
pub const TYPICAL_GOING_M: f32 = 0.29;
