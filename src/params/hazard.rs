//! Shape of the verdict's fitted numbers.

use crate::math;

/// Number of features of a cell; `src/infer/horizon.rs` says what each is.
pub const FEATURES: usize = 50;

/// What the estimator knows of a cell.
pub type Features = [f32; FEATURES];

/// From the hazards' log-odds of being right to how often answers are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map {
    /// Log-odds of being right per unit of those that the hazards add up to …
    pub slope: f32,
    /// … and where these are 0.
    pub offset: f32,
}

impl Map {
    /// Takes the hazards at their word.
    pub const IDENTITY: Self = Self {
        slope: 1.0,
        offset: 0.0,
    };

    /// Probability of something to which the particles give the share `share` (Platt scaling).
    pub fn of_share(&self, share: f32) -> f32 {
        self.at(share_log_odds(share))
    }

    /// Probability of being right at log-odds of `log_odds`.
    fn at(&self, log_odds: f32) -> f32 {
        1.0 / (1.0 + math::exp(-(self.slope * log_odds + self.offset)))
    }
}

/// The verdict's numbers for one plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    /// Log-odds of an error in a cell per unit of each feature.
    pub hazard: Features,
    /// From what the hazards add up to, of answers without steps and with steps: what is not seen at
    /// all is another matter than what is seen and may be wrong.
    pub maps: [Map; 2],
    /// From the particles' share of what the answer leaves out to how often it stands there.
    pub maybe: Map,
    /// An answer without steps, or with steps, is `ok` from this probability on. Above 1 if none is.
    pub ok_from: [f32; 2],
}

impl Weights {
    /// Logarithm of the probability that nothing goes wrong in a cell: -ln(1 + e^x) of the weighted
    /// features.
    pub fn log_survival(&self, features: &Features) -> f32 {
        log_survival(self.log_odds(features))
    }

    /// Log-odds of an error in a cell.
    pub fn log_odds(&self, features: &Features) -> f32 {
        let pairs = features.iter().zip(&self.hazard);
        pairs.map(|(feature, weight)| feature * weight).sum()
    }

    /// Probability of being right where the cells' log survivals add up to `log_right`.
    pub fn probability(&self, log_right: f32, stairs: bool) -> f32 {
        probability(&self.maps, log_right, stairs)
    }
}

/// Shares nearer to 0 or 1 count as this near: of those the few that are wrong would decide on the map's slope.
const LEAST_SHARE: f32 = 0.05;

/// Log-odds of the particles' share of something.
pub fn share_log_odds(share: f32) -> f32 {
    let share = share.clamp(LEAST_SHARE, 1.0 - LEAST_SHARE);
    math::ln(share) - math::ln(1.0 - share)
}

/// Logarithm of the probability of no error whose log-odds are `x`.
pub fn log_survival(x: f32) -> f32 {
    let rest = math::log2(1.0 + math::exp(-x.abs()));
    -(math::max(x, 0.0) + core::f32::consts::LN_2 * rest)
}

/// Probability of being right where log survivals add up to `log_right`, by the map of answers without
/// steps or by that of answers with steps.
pub fn probability([clear, steps]: &[Map; 2], log_right: f32, stairs: bool) -> f32 {
    let map = if stairs { steps } else { clear };
    let wrong = 1.0 - math::exp(log_right);
    // ln p/(1 - p); no cell is without any hazard.
    let log_wrong = math::ln(wrong.max(f32::EPSILON));
    map.at(log_right - log_wrong)
}
