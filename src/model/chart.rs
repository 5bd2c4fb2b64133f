//! The map with what it takes to read it at places of the scene.

use crate::motion::Ride;
use crate::signal::echoes::two_way_sigma;
use crate::signal::grid::PolarMap;

/// What the map is read with.
#[derive(Clone, Copy, Debug)]
pub struct Chart<'m> {
    /// The map.
    pub map: &'m PolarMap,
    /// Mean noise, map units.
    pub noise: f32,
    /// Error of the shaft's angle, taken off, radians.
    pub bias_rad: f32,
    /// Error of heights, taken off, metres.
    pub height_m: f32,
    /// How the chair went meanwhile, if it is known.
    pub ride: Option<Ride<'m>>,
}

impl Chart<'_> {
    /// Standard deviation of the two-way beam, radians.
    pub fn sigma_rad(&self) -> f32 {
        two_way_sigma(self.map.geometry().beamwidth_rad)
    }
}
