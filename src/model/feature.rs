//! Point features: their classes and expected places.

use crate::math;
use crate::params::posterior as number;

/// Classes of point features.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Foot of a riser, or of a wall.
    Corner,
    /// Edge of a tread below the mirror.
    Nosing,
    /// Face at the mirror's height.
    Flash,
    /// Edge of a tread above a flash.
    Top,
    /// Visible part of a riser whose foot is hidden by the tread before it.
    Hidden,
    /// Edge of an open tread below the mirror.
    EdgeBelow,
    /// Edge of an open tread above the mirror.
    EdgeAbove,
}

/// Expected place of a point feature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeaturePlace {
    /// Class of the feature.
    pub class: Class,
    /// Horizontal distance from the mirror, metres.
    pub x_m: f32,
    /// Height above the ground, metres.
    pub y_m: f32,
    /// Range from the mirror, metres.
    pub range_m: f32,
    /// Distance to the neighbouring feature with which it may merge into one echo, in resolution cells.
    pub separation_cells: f32,
}

/// Returns the level of the riser before above that of a faint one, tens of dB. `shown_db` is its level, dB.
pub fn excess_level(shown_db: f32) -> f32 {
    number::PER_TEN_DB * (math::min(shown_db, number::OUTSHINES_DB) - number::FAINT_DB)
}
