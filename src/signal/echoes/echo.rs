//! One point scatterer of a scan.

use heapless::Vec;

/// Maximum number of echoes of a scan.
pub const MAX_ECHOES: usize = 32;

/// Echoes of a scan, strongest first.
pub type Echoes = Vec<Echo, MAX_ECHOES>;

/// One echo, interpreted as a point scatterer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Echo {
    /// SNR: power in one row's cell over the noise, dB.
    pub snr_db: f32,
    /// Range from the mirror, metres.
    pub range_m: f32,
    /// Angle of the beam, radians: down from the horizontal (depth plane), or forward from straight down
    /// (height plane).
    pub angle_rad: f32,
    /// Horizontal distance from the mirror, forward, metres.
    pub x_m: f32,
    /// Height above the ground, metres.
    pub y_m: f32,
    /// Width of the lobe over the angle, in units of a point scatterer's.
    pub width: f32,
    /// Standard deviation of `angle_rad`, radians.
    pub angle_sigma_rad: f32,
    /// Standard deviation of `range_m`, metres.
    pub range_sigma_m: f32,
    /// Range from the radar (not from the mirror), native range bins of c/2B.
    pub native_bin: f32,
    /// Phase relative to the mirror's echo, as cosine and sine.
    pub phasor: [f32; 2],
}

/// Echoes and noise of a scan.
#[derive(Clone, Debug, Default)]
pub struct FoundEchoes {
    /// Echoes as the rows show them: neither calibrated on the ground nor compensated for motion.
    pub echoes: Echoes,
    /// Mean power of the noise in one row's cell, map units (1/8 octave).
    pub noise: f32,
}

impl FoundEchoes {
    /// Nothing, before the first scan.
    pub const NONE: Self = Self {
        echoes: Echoes::new(),
        noise: 0.0,
    };
}
