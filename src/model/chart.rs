//! The polar map with the calibration and motion that relate its cells to places of the scene.

use crate::answer::Slope;
use crate::motion::MotionCompensation;
use crate::signal::grid::{PolarMap, two_way_sigma};
use crate::signal::image::Cleaned;

/// The polar map with its calibration and the chair's motion.
#[derive(Clone, Copy, Debug)]
pub struct Chart<'m> {
    /// Polar map.
    pub map: &'m PolarMap,
    /// Power of the noise, map units (levels of 1/8 octave of power, 0.376 dB): mean in one row's cell.
    pub noise: f32,
    /// Error of the shaft's angle, to be subtracted from the angles of the map's rows, radians.
    pub bias_rad: f32,
    /// Error of the configured mounting height (of the mirror above the ground), to be subtracted from it, metres.
    pub height_m: f32,
    /// Slope of the ground.
    pub bend: Slope,
    /// Coherent image of the scan, behind CLEAN; without it the map shows the surfaces.
    pub image: Option<&'m Cleaned<'m>>,
    /// Motion of the chair during the scan, if it is known.
    pub ride: Option<MotionCompensation<'m>>,
}

impl Chart<'_> {
    /// Returns the standard deviation of the two-way beam, radians.
    pub fn sigma_rad(&self) -> f32 {
        two_way_sigma(self.map.geometry().beamwidth_rad)
    }
}
