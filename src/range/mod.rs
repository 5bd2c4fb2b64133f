//! From chirp to one row of the map: DC removal, window, FFT, power, CA-CFAR (paper II-A, III-C).

use crate::config::{CfarConfig, MountConfig, RadarConfig};

/// The range bins that the map keeps: beyond the mirror's own echo, short of what wraps round from
/// negative frequencies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BinWindow {
    /// First kept bin of the transform.
    pub first: u16,
    /// Number of kept bins.
    pub count: u16,
}

/// Native range bins (c/2B) at the far end that negative frequencies leak into through the window.
const WRAP_BINS: f32 = 3.0;

impl BinWindow {
    /// The window for a radar behind a mirror.
    pub fn new(radar: &RadarConfig, mount: &MountConfig, cfar: &CfarConfig) -> Self {
        let spacing = radar.bin_spacing_m();
        let near = mount.mirror_offset_m() + cfar.near_margin as f32 * 1e-5;
        let first = libm::ceilf(near / spacing) as u16;
        let wrap = WRAP_BINS * radar.range_resolution_m() / spacing;
        let end = (radar.fft_len() as u16).saturating_sub(libm::ceilf(wrap) as u16);
        Self {
            first,
            count: end.saturating_sub(first),
        }
    }
}

/// What one chirp tells beside its row: the health of radar and mirror.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RowStats {
    /// Samples whose I or Q stands at full scale.
    pub saturated: u16,
    /// Logarithmic power of all samples, map units (1/8 octave).
    pub power: u8,
    /// Logarithmic power at the mirror's own echo, map units.
    pub mirror_echo: u8,
}
