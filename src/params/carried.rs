//! Types of the numbers that weigh the evidence of earlier scans. `cargo study sequences --fit` counts hazards and
//! correlations into `counted.rs`.

use super::hazard::PlattMap;
use crate::math;

/// Correlation of two readings' errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correlation {
    /// Correlation without displacement.
    pub at_rest: f32,
    /// Displacement at which the correlation falls to 1/e of that, metres.
    pub length_m: f32,
}

impl Correlation {
    /// Returns the correlation after a displacement of `moved_m` metres.
    pub fn after(&self, moved_m: f32) -> f32 {
        self.at_rest * math::exp(-moved_m.abs() / self.length_m)
    }
}

/// Number of features of a cell with evidence of earlier scans; `src/past/outlook.rs` defines each.
pub const PAST_FEATURES: usize = 12;

/// Features of a cell by this scan and earlier ones.
pub type PastFeatures = [f32; PAST_FEATURES];

/// Fitted weights of the horizon where evidence was carried on.
#[derive(Clone, Debug, PartialEq)]
pub struct Carried {
    /// Log-odds of an error in a cell per unit of each feature.
    pub hazard: PastFeatures,
    /// Calibration maps of the summed hazards, of answers without steps and with steps.
    pub maps: [PlattMap; 2],
    /// Minimum probability of being correct for `ok`, of answers without steps and with steps.
    pub ok_from: [f32; 2],
}

impl Carried {
    /// Returns the log-odds of an error in a cell.
    pub fn log_odds(&self, features: &PastFeatures) -> f32 {
        let pairs = features.iter().zip(&self.hazard);
        pairs.map(|(feature, weight)| feature * weight).sum()
    }
}
