//! Range bins of a transform that the map keeps.

use crate::config::{CfarConfig, Config, MountConfig, RadarConfig};
use crate::math;

/// Maximum number of cells of a map.
pub const MAX_CELLS: usize = 64 * 1024;
/// Range up to which the radar's leakage extends with the window's main lobe, native range bins (c/2B).
const LEAKAGE_BINS: f32 = 4.0;
/// Number of native range bins at the far end that contain wrap-around: leakage, its I/Q image, and the main
/// lobe of an echo at range zero.
const WRAP_BINS: f32 = 5.0;

/// Minimum range to which a map must extend, metres from the mirror, unless the range axis ends before: twice
/// the minimum horizon of an `ok`.
const MIN_RANGE_M: f32 = 2.0;

/// Range bins that the map keeps: from beyond the mirror's own echo to the wrap-around from negative
/// frequencies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BinWindow {
    /// First kept bin of the transform.
    pub first: u16,
    /// Number of kept bins.
    pub count: u16,
}

impl BinWindow {
    /// Returns the range bins that are kept for a radar behind a mirror, or for one without a mirror (offset
    /// 0).
    pub fn new(radar: &RadarConfig, mount: &MountConfig, cfar: &CfarConfig) -> Self {
        let spacing = radar.bin_spacing_m();
        let native = radar.range_resolution_m();
        let margin = mount.mirror_offset_m() + cfar.near_margin as f32 * 1e-5;
        let near = margin.max(LEAKAGE_BINS * native);
        // The cast saturates.
        let first = math::ceil(near / spacing) as u16;
        let wrap = math::ceil(WRAP_BINS * native / spacing) as u16;
        let end = (radar.fft_len() as u16).saturating_sub(wrap);
        Self {
            first,
            count: end.saturating_sub(first),
        }
    }

    /// Returns the range bins that the map of a scan keeps: if the map cannot hold as many bins in each row,
    /// the farthest are left out, but none within 2 m of the mirror.
    pub fn of_scan(config: &Config) -> Self {
        let whole = Self::new(&config.radar, &config.mount, &config.cfar);
        let rows = usize::from(config.sweep.angle_count).max(1);
        // Limited by the cells of the map.
        let room = (MAX_CELLS / rows).min(usize::from(u16::MAX)) as u16;
        let spacing = config.radar.bin_spacing_m();
        let end_m = f32::from(whole.first.saturating_add(room)) * spacing;
        let enough = end_m >= config.mount.mirror_offset_m() + MIN_RANGE_M;
        Self {
            count: if enough {
                whole.count.min(room)
            } else {
                whole.count
            },
            ..whole
        }
    }

    /// As [`BinWindow::of`], for a slice that may be changed.
    pub fn of_mut<T>(self, bins: &mut [T]) -> &mut [T] {
        let (first, count) = (usize::from(self.first), usize::from(self.count));
        let rest = bins.get_mut(first..).unwrap_or(&mut []);
        let end = count.min(rest.len());
        rest.get_mut(..end).unwrap_or(&mut [])
    }

    /// Returns the kept part of a slice with an entry for each bin of the transform.
    pub fn of<T>(self, bins: &[T]) -> &[T] {
        let first = usize::from(self.first);
        bins.get(first..first + usize::from(self.count))
            .unwrap_or(&[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_map_cannot_hold_is_left_out_at_the_far_end() {
        let mut config = Config::default();
        let whole = BinWindow::new(&config.radar, &config.mount, &config.cfar);
        assert_eq!(BinWindow::of_scan(&config), whole);
        // 150 samples of 6.67 GHz in 297 rows: 3.4 m in bins of 1.3 cm.
        config.radar.samples = 150;
        config.radar.bandwidth_khz = 6_670_000;
        config.mount.mirror_offset = 13_700;
        config.sweep.angle_count = 297;
        let whole = BinWindow::new(&config.radar, &config.mount, &config.cfar);
        let kept = BinWindow::of_scan(&config);
        assert_eq!(kept.first, whole.first);
        assert_eq!(kept.count, (65_536_u32 / 297) as u16);
        assert!(kept.count < whole.count);
        // A range below 2 m is not accepted: the window is not reduced, and `PolarMap::begin` refuses it.
        config.sweep.angle_count = 500;
        let whole = BinWindow::new(&config.radar, &config.mount, &config.cfar);
        assert_eq!(BinWindow::of_scan(&config), whole);
    }
}
