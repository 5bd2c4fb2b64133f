//! Types of the numbers that weigh the evidence of earlier scans, and the constants tuned by hand beside them. `cargo study sequences --fit` counts hazards and
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

// Features of a cell.

/// Limit of the log-odds that the answer is first wrong in a way cell, nats, of either sign: odds of e^9 count as
/// certain.
pub const MAX_CARRIED_ODDS: f32 = 9.0;
/// Distance from the mirror beyond which objects behind a landing are mostly too faint to be detected, metres.
pub const FAR_M: f32 = 2.0;
/// Unit of the feature that states how far a way cell lies beyond [`FAR_M`], metres.
pub const FAR_CELLS_M: f32 = 0.5;
/// Upper limit of the feature `model::MIN_EXPANDED_M` divided by the standard deviation of a step's height.
pub const MAX_STEP_SIGMAS: f32 = 4.0;
/// Maximum number of earlier scans that are counted for a way cell.
pub const MAX_SCANS: f32 = 4.0;

// Views and readings.

/// Length by which the maximum range of the scan before's field of view is reduced, metres: near that limit it is
/// uncertain whether the earlier scan could see an edge.
pub const VIEW_MARGIN_M: f32 = 0.15;
/// Factor on the slope (tangent of the angle) of the upper limit of the scan before's field of view, since near that
/// limit it is uncertain whether the earlier scan could see an edge.
pub const VIEW_MARGIN_SHARE: f32 = 0.9;

/// Difference of a reading from the mean of earlier ones, in standard deviations, beyond which both variances are
/// enlarged.
pub const MAX_READING_SIGMAS: f32 = 2.0;
