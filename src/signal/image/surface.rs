//! What a finished image shows of a surface: one complex look a place, with what CLEAN took out of it there.

use super::clean::Taken;
use super::coherent::CoherentImage;
use super::response::{self, RangeResponse};
use crate::math;
use crate::signal::echoes::FoundEchoes;
use crate::signal::grid::{PolarMap, UNITS_PER_OCTAVE};
use crate::signal::range::FULL_SCALE;

/// Maximum distance over the angle of an echo from a surface's line at which it is the surface's own, standard deviations
/// of a lobe behind the filter: half a deviation, 1.5 degrees at a beam of 5 degrees.
const OWN: f32 = 0.5;

/// Power at a place of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Power over the background.
    pub power: f32,
    /// Background as a ratio to the noise: noise, and the error of other echoes' responses.
    pub background: f32,
}

/// A finished image behind CLEAN, with the echoes that were taken out of it.
#[derive(Clone, Copy, Debug)]
pub struct Cleaned<'a> {
    pub(super) image: &'a CoherentImage,
    pub(super) words: &'a [u32],
    pub(super) range: RangeResponse,
    pub(super) map: &'a PolarMap,
    pub(super) found: &'a FoundEchoes,
}

impl Cleaned<'_> {
    /// Returns the gain in power of a surface's look over one row's cell.
    pub fn gain(&self) -> f32 {
        CoherentImage::gain(self.map)
    }

    /// Returns the mean power of the noise in a cell; a full-scale tone in one row has power 1.
    fn noise(&self) -> f32 {
        math::exp2((self.found.noise - f32::from(FULL_SCALE)) / f32::from(UNITS_PER_OCTAVE))
    }

    /// Returns the look at a stored bin and an angle, radians; `None` outside of the scan.
    #[inline(never)]
    pub fn look(&self, bin: usize, angle_rad: f32) -> Option<Look> {
        let nodes = self.image.nodes();
        let at = nodes.at(angle_rad);
        let node = math::floor(at);
        if node < 0.0 || node + 1.0 >= nodes.count() as f32 || bin >= self.image.bins() {
            return None;
        }
        let share = at - node;
        let [a, b] = [0, 1].map(|k| self.image.cell(self.words, node as usize + k, bin));
        let mut sum = [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])];
        let noise = self.noise();
        let gain = self.gain();
        let geometry = self.map.geometry();
        let mut error = 0.0;
        for echo in &self.found.echoes {
            let off = bin as f32 - (echo.range_m - geometry.first_range_m) / geometry.bin_m;
            let turn = (at - nodes.at(echo.angle_rad)) / nodes.lobe_sigma();
            let power = noise * gain * math::power_ratio(echo.snr_db);
            let taken = Taken { power, turn, off };
            if turn.abs() > OWN {
                error += taken.error(&self.range, bin as f32);
                continue;
            }
            error += taken.sweep_error(&self.range, bin as f32);
            if off.abs() <= response::REACH as f32 {
                let mut along = [[0.0; 2]];
                self.range.along(off, &mut along);
                let [[re, im]] = along;
                let size = math::sqrt(power) * math::exp(-0.5 * turn * turn);
                let (sin, cos) = math::sin_cos(echo.phase_rad);
                sum[0] += size * (re * cos - im * sin);
                sum[1] += size * (re * sin + im * cos);
            }
        }
        let background = 1.0 + error / noise;
        let power = (sum[0] * sum[0] + sum[1] * sum[1]) / (noise * background);
        Some(Look { power, background })
    }
}
