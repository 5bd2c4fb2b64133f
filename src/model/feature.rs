//! Point features: their classes and expected places.

use crate::math;
use crate::params::posterior;

/// Classes of point features: features of a staircase that give one echo each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Inner corner at the foot of a riser, or of a wall.
    Corner,
    /// Front edge of a tread that lies below the mirror, above a closed riser.
    Nosing,
    /// Specular reflection of a riser's face, or of a wall, at the mirror's height, where it meets the line of sight at
    /// a right angle.
    Flash,
    /// Front edge of a tread above the mirror, at the top of a riser that flashes.
    Top,
    /// Visible part of a riser whose foot is hidden by the tread before it.
    Hidden,
    /// Edge of an open tread below the mirror.
    EdgeBelow,
    /// Edge of an open tread above the mirror.
    EdgeAbove,
}

/// A place in the sagittal plane.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// Horizontal distance from the mirror, metres.
    pub x_m: f32,
    /// Height above the ground, metres.
    pub y_m: f32,
}

impl Spot {
    /// Returns a place from its distance and height, metres.
    pub fn new(x_m: f32, y_m: f32) -> Self {
        Self { x_m, y_m }
    }
}

/// Expected place of a point feature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeaturePlace {
    /// Class of the feature.
    pub class: Class,
    /// Horizontal distance of the feature from the mirror, metres.
    pub x_m: f32,
    /// Height of the feature above the ground, metres.
    pub y_m: f32,
    /// Range of the feature from the mirror, metres.
    pub range_m: f32,
    /// Distance to the neighbouring feature with which it may merge into one echo, in resolution cells.
    pub separation_cells: f32,
}

/// Returns `shown_db`, the SNR of the riser before, limited to 35 dB, less that of a faint riser, 15 dB; in tens of dB.
pub fn excess_level(shown_db: f32) -> f32 {
    posterior::PER_TEN_DB * (math::min(shown_db, posterior::OUTSHINES_DB) - posterior::FAINT_DB)
}
