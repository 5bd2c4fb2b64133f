//! Point features: of which class, and where one is expected.

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
    /// What can be seen of a riser whose foot the tread before it hides.
    Hidden,
    /// Edge of a floating tread below the mirror.
    EdgeBelow,
    /// The same above it.
    EdgeAbove,
}

/// Where a point feature is expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeaturePlace {
    /// Of which class.
    pub class: Class,
    /// Distance from the mirror, metres.
    pub x_m: f32,
    /// Height above the ground, metres.
    pub y_m: f32,
    /// Range from the mirror, metres.
    pub range_m: f32,
    /// Distance to what it may melt into one echo with, in resolution cells.
    pub room: f32,
}

/// Tens of dB by which the riser before outshines a faint one, from its level in dB.
pub fn before(shown_db: f32) -> f32 {
    number::PER_TEN_DB * (math::min(shown_db, number::OUTSHINES_DB) - number::FAINT_DB)
}
