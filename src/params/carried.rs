//! What one scan's word counts in the next one. `cargo sim sequences --fit` counts the hazards and the
//! correlations (`counted.rs`); the rest says where it comes from.

use super::hazard::Map;
use crate::math;

/// How alike two readings' errors are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correlation {
    /// From one and the same place …
    pub standing: f32,
    /// … and by what way it falls to 1/e of that, metres.
    pub way_m: f32,
}

impl Correlation {
    /// From places so many metres apart.
    pub fn after(&self, moved_m: f32) -> f32 {
        self.standing * math::exp(-moved_m.abs() / self.way_m)
    }
}

/// Number of features of a cell that earlier scans have seen; `src/infer/past/outlook.rs` says what each is.
pub const PAST_FEATURES: usize = 12;

/// What this scan and earlier ones know of a cell.
pub type PastFeatures = [f32; PAST_FEATURES];

/// The verdict's numbers where something was carried on.
#[derive(Clone, Debug, PartialEq)]
pub struct Carried {
    /// Log-odds of an error in a cell per unit of each feature.
    pub hazard: PastFeatures,
    /// From what the hazards add up to, of answers without steps and with steps.
    pub maps: [Map; 2],
    /// An answer without steps, or with steps, is `ok` from this probability on.
    pub ok_from: [f32; 2],
}

impl Carried {
    /// Log-odds of an error in a cell.
    pub fn log_odds(&self, features: &PastFeatures) -> f32 {
        let pairs = features.iter().zip(&self.hazard);
        pairs.map(|(feature, weight)| feature * weight).sum()
    }
}
