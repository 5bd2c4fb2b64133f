//! Which range bins of a transform the map keeps.

use crate::config::{CfarConfig, MountConfig, RadarConfig};
use crate::math;

/// Native range bins (c/2B) in which the radar's leakage stands, its window's main lobe included.
const LEAKAGE_BINS: f32 = 4.0;
/// Native range bins at the far end that the leakage, its I/Q image and the lobe of what stands
/// at zero wrap round to.
const WRAP_BINS: f32 = 5.0;

/// The range bins that the map keeps: beyond the mirror's own echo, short of what wraps round from
/// negative frequencies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BinWindow {
    /// First kept bin of the transform.
    pub first: u16,
    /// Number of kept bins.
    pub count: u16,
}

impl BinWindow {
    /// The window for a radar, behind a mirror or (offset 0) without one.
    pub fn new(radar: &RadarConfig, mount: &MountConfig, cfar: &CfarConfig) -> Self {
        let spacing = radar.bin_spacing_m();
        let native = radar.range_resolution_m();
        let margin = mount.mirror_offset_m() + cfar.near_margin as f32 * 1e-5;
        let near = margin.max(LEAKAGE_BINS * native);
        // `as` saturates.
        let first = math::ceil(near / spacing) as u16;
        let wrap = math::ceil(WRAP_BINS * native / spacing) as u16;
        let end = (radar.fft_len() as u16).saturating_sub(wrap);
        Self {
            first,
            count: end.saturating_sub(first),
        }
    }

    /// The kept part of something that has an entry for each bin of the transform.
    pub fn of<T>(self, bins: &[T]) -> &[T] {
        let first = usize::from(self.first);
        bins.get(first..first + usize::from(self.count))
            .unwrap_or(&[])
    }
}
