//! One point scatterer of a scan.

use heapless::Vec;

/// Maximum number of echoes of a scan.
pub const MAX_ECHOES: usize = 64;

/// Echoes of a scan, strongest first.
pub type Echoes = Vec<Echo, MAX_ECHOES>;

/// One echo, interpreted as a point scatterer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Echo {
    /// Filtered power above the noise, dB.
    pub snr_db: f32,
    /// Range from the mirror, metres.
    pub range_m: f32,
    /// Angle, radians.
    pub angle_rad: f32,
    /// Horizontal distance from the mirror, metres.
    pub x_m: f32,
    /// Height above the ground, metres.
    pub y_m: f32,
    /// Width of the filtered lobe in angle, relative to that of a point scatterer.
    pub width: f32,
    /// Standard deviation of the angle, radians.
    pub angle_sigma_rad: f32,
    /// Standard deviation of the range, metres.
    pub range_sigma_m: f32,
    /// Native range bin (c/2B) from the radar.
    pub native_bin: f32,
}
