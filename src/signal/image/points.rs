//! Points of the coherent image as echoes, with the standard deviations of their positions.

use super::{Clean, CoherentImage, CoherentRow, Component, RangeResponse, WORDS};
use crate::config::Config;
use crate::math;
use crate::params::image::PATTERN;
use crate::signal::echoes::{Echo, Echoes};
use crate::signal::grid::PolarMap;

/// Standard deviation of a point's range at a power ratio of 1 to the noise of the image, native bins: of the vertex of the
/// parabola through three bins behind a Hann window. The bound of Cramér and Rao is 0.32.
const RANGE_SIGMA: f32 = 0.55;

/// An image with a memory of its own, as it was before its echoes were detected.
#[derive(Clone, Debug)]
pub struct KeptImage {
    image: CoherentImage,
    words: [u32; WORDS],
}

impl Default for KeptImage {
    fn default() -> Self {
        Self::new()
    }
}

impl KeptImage {
    /// Returns an image without nodes.
    pub const fn new() -> Self {
        Self {
            image: CoherentImage::new(),
            words: [0; WORDS],
        }
    }

    /// Prepares for the first row of a scan with the shape of `map`.
    pub fn begin(&mut self, map: &PolarMap) {
        self.image.begin(map, self.words.len());
    }

    /// Adds a row seen at `angle_rad`.
    pub fn add(&mut self, angle_rad: f32, row: &mut CoherentRow<'_>) {
        self.image.add(&mut self.words, angle_rad, row);
    }

    /// Closes the image after the last row; returns the mean power of its noise, a full-scale tone in one row having power
    /// 1, or `None` without rows.
    pub fn finish(&mut self) -> Option<f32> {
        self.image.finish(&mut self.words);
        self.image.noise()
    }

    /// Returns the power of a finished image at an angle and a stored bin, interpolated between the nodes; 0 outside.
    pub fn power(&self, angle_rad: f32, bin: usize) -> f32 {
        let at = self.image.nodes().at(angle_rad);
        if at < 0.0 {
            return 0.0;
        }
        let node = at as usize;
        let share = at - node as f32;
        let words = &self.words;
        let [a, b] = [node, node + 1].map(|node| self.image.cell(words, node, bin));
        let [re, im] = core::array::from_fn(|k| {
            let [a, b] = [a, b].map(|cell| cell.get(k).copied().unwrap_or(0.0));
            a + share * (b - a)
        });
        re * re + im * im
    }

    /// Detects the echoes of a finished image and writes them to `echoes`, strongest first; the image then holds what is
    /// left.
    #[inline(never)]
    pub fn detect(&mut self, map: &PolarMap, config: &Config, echoes: &mut Echoes) {
        echoes.clear();
        let Some(noise) = self.image.noise() else {
            return;
        };
        let offset_m = config.mount.mirror_offset_m();
        let native_per_bin = map.geometry().bin_m / config.radar.range_resolution_m();
        let range = RangeResponse {
            native_per_bin,
            radians_per_bin: core::f32::consts::PI * native_per_bin,
            first_native: (map.geometry().first_range_m + offset_m)
                / config.radar.range_resolution_m(),
            image_sum: match config.radar.real {
                false => f32::from(config.radar.samples),
                // Real samples have no negative frequencies and no I/Q imbalance.
                true => f32::INFINITY,
            },
        };
        let mut clean = Clean::new(&self.image, &mut self.words, range, noise);
        clean.run();
        for point in &clean.found {
            let mut echo = echo(point, map, &clean, native_per_bin);
            echo.native_bin = (echo.range_m + offset_m) / config.radar.range_resolution_m();
            // There is room.
            let _ = echoes.push(echo);
        }
        crate::sort::shell_sort(echoes, |a, b| a.snr_db > b.snr_db);
    }
}

/// Returns the echo of a point, without its native bin.
fn echo(point: &Component, map: &PolarMap, clean: &Clean<'_>, native_per_bin: f32) -> Echo {
    let (geometry, nodes) = (map.geometry(), clean.image.nodes());
    let range_m = geometry.range_m(point.bin);
    let angle_rad = nodes.angle_rad(point.node);
    let (x_m, y_m) = geometry.point(range_m, angle_rad);
    let ratio = point.power / clean.noise;
    let snr_db = math::DB_PER_OCTAVE * math::log2(ratio / CoherentImage::gain(map));
    let share = math::sqrt(1.0 / point.contrast + PATTERN);
    Echo {
        snr_db,
        range_m,
        angle_rad,
        x_m,
        y_m,
        width: point.width,
        angle_sigma_rad: nodes.sigma_rad() * share,
        range_sigma_m: RANGE_SIGMA / native_per_bin * geometry.bin_m * share,
        native_bin: 0.0,
    }
}
