//! Points of the coherent image as echoes, with the standard deviations of their positions.

use super::clean::{Clean, Component};
use super::coherent::CoherentImage;
use super::memory::ImageMemory;
use super::reference::CoherentRow;
use super::response::RangeResponse;
use super::surface::Cleaned;
use crate::config::{Config, RadarConfig};
use crate::drive::ExpectedTravel;
use crate::math;
use crate::params::image::PATTERN;
use crate::signal::echoes::{Echo, FoundEchoes, forward};
use crate::signal::grid::{PolarMap, UNITS_PER_OCTAVE};
use crate::signal::range::FULL_SCALE;

/// Standard deviation of a point's range at a power ratio of 1 to the noise of the image, native bins: of the vertex of the
/// parabola through three bins behind a Hann window. The bound of Cramér and Rao is 0.32.
const RANGE_SIGMA: f32 = 0.55;

/// An image with its memory.
#[derive(Debug, Default)]
#[cfg_attr(not(target_os = "none"), derive(Clone))]
pub struct KeptImage {
    image: CoherentImage,
    memory: ImageMemory,
}

impl KeptImage {
    /// Returns an image without nodes; on the chip it has no memory yet.
    pub const fn new() -> Self {
        Self {
            image: CoherentImage::new(),
            memory: ImageMemory::new(),
        }
    }

    /// Returns the memory.
    pub fn memory_mut(&mut self) -> &mut ImageMemory {
        &mut self.memory
    }

    /// Returns whether there is a memory for images.
    pub fn is_possible(&self) -> bool {
        !self.memory.words().is_empty()
    }

    /// Prepares for the first row of a scan by `radar` with the shape of `map`, of a chair that stands.
    pub fn begin(&mut self, map: &PolarMap, radar: &RadarConfig) {
        self.image.begin(map, radar, self.memory.words().len());
    }

    /// States that from the next row on the chair may move, and its travel. Where it
    /// stands, the phases of rows with a reference stay as they are: a wide face turns the phase of what stands, too.
    pub fn expect_motion(&mut self, travel: ExpectedTravel) {
        self.image.expect(travel);
    }

    /// Adds row `k` of `map`.
    pub fn add(&mut self, map: &PolarMap, k: usize, row: &mut CoherentRow<'_>) {
        let angle_rad = map.angle_rad(k);
        let ahead = forward(map.geometry(), angle_rad);
        let words = self.memory.words_mut();
        self.image.add(words, (angle_rad, ahead), row);
    }

    /// Closes the image after the last row.
    pub fn finish(&mut self) {
        self.image.finish(self.memory.words_mut());
    }

    /// Returns the mean power of a finished image's noise, a full-scale tone in one row having power 1; `None` without rows.
    pub fn noise(&self) -> Option<f32> {
        self.image.noise(self.memory.words())
    }

    /// Returns the power of a finished image at an angle and a stored bin of its row, interpolated between the nodes; 0
    /// outside.
    pub fn power(&self, angle_rad: f32, bin: usize) -> f32 {
        let at = self.image.nodes().at(angle_rad);
        if at < 0.0 {
            return 0.0;
        }
        let words = self.memory.words();
        let bin = self.image.bin_of(words, at, bin);
        let [re, im] = self.image.between(words, at, bin);
        re * re + im * im
    }

    /// Returns what is left of the image with the echoes that [`KeptImage::detect`] found.
    pub fn cleaned<'a>(
        &'a self,
        map: &PolarMap,
        config: &Config,
        found: &FoundEchoes,
    ) -> Cleaned<'a> {
        let words = self.memory.words();
        Cleaned::new(&self.image, words, range_response(map, config), map, found)
    }

    /// Detects the echoes of a finished image and writes them to `found`, strongest first; the image then holds what is
    /// left.
    #[inline(never)]
    pub fn detect(&mut self, map: &PolarMap, config: &Config, found: &mut FoundEchoes) {
        let echoes = &mut found.echoes;
        echoes.clear();
        let Some(noise) = self.noise() else {
            found.noise = 0.0;
            return;
        };
        found.noise = f32::from(FULL_SCALE) + f32::from(UNITS_PER_OCTAVE) * math::log2(noise);
        let range = range_response(map, config);
        let mut clean = Clean::new(&self.image, self.memory.words_mut(), range, noise);
        clean.run();
        for point in &clean.found {
            let bin = point.bin - self.image.walk(clean.words(), point.node);
            let mut echo = echo(point, bin, map, &clean);
            echo.native_bin = range.native(bin);
            // There is room.
            let _ = echoes.push(echo);
        }
        crate::sort::shell_sort(echoes, |a, b| a.snr_db > b.snr_db);
    }
}

/// Returns the response over the range of a scan with the shape of `map`.
fn range_response(map: &PolarMap, config: &Config) -> RangeResponse {
    let native_m = config.radar.range_resolution_m();
    let native_per_bin = map.geometry().bin_m / native_m;
    RangeResponse {
        native_per_bin,
        radians_per_bin: core::f32::consts::PI * native_per_bin,
        first_native: (map.geometry().first_range_m + config.mount.mirror_offset_m()) / native_m,
        image_sum: match config.radar.real {
            false => f32::from(config.radar.samples),
            // Real samples have no negative frequencies and no I/Q imbalance.
            true => f32::INFINITY,
        },
    }
}

/// Returns the echo of a point, which was in stored bin `bin` in its row, without its native bin.
fn echo(point: &Component, bin: f32, map: &PolarMap, clean: &Clean<'_>) -> Echo {
    let (geometry, nodes) = (map.geometry(), clean.image.nodes());
    let range_m = geometry.range_m(bin);
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
        range_sigma_m: RANGE_SIGMA / clean.range.native_per_bin * geometry.bin_m * share,
        native_bin: 0.0,
        phasor: point.amplitude.map(|part| part / math::sqrt(point.power)),
    }
}
