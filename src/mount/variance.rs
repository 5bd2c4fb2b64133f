//! Variance of the height of a ground echo.

use crate::math;
use crate::params::Params;
use crate::signal::echoes::Echo;

/// Returns the variance of a ground echo's height at `range_m` metres from the mirror, square metres. Corners,
/// which are strong and narrow, have a smaller variance in angle and height than speckle.
pub fn floor_variance(e: &Echo, range_m: f32, p: &Params) -> f32 {
    let clean = e.snr_db > p.floor_corner_db && e.width < p.floor_corner_width;
    let (fixed_rad, rough_m) = if clean {
        (p.floor_corner_rad, p.floor_corner_m)
    } else {
        (p.floor_speckle_rad, p.floor_speckle_m)
    };
    let noise = range_m * (fixed_rad + p.floor_noise_rad * math::amplitude(-e.snr_db));
    rough_m * rough_m + noise * noise
}
