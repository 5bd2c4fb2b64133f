//! Power of a surface in a finished image: at each place one complex value, to which the surface's own echoes, which CLEAN has
//! subtracted, are added again.

use super::clean::{DARK, LOBE_BINS, Taken};
use super::coherent::CoherentImage;
use super::response::{self, RangeResponse};
use crate::math;
use crate::params::image::{PATTERN, SKIRT};
use crate::signal::echoes::{FoundEchoes, MAX_ECHOES};
use crate::signal::grid::{PolarMap, UNITS_PER_OCTAVE};
use crate::signal::range::FULL_SCALE;
use heapless::Vec;

/// Maximum distance over the angle of an echo from a surface's line at which it is the surface's own, standard deviations
/// of a lobe behind the filter: half a deviation, 1.5 degrees at a beam of 5 degrees.
const OWN: f32 = 0.5;

/// Share of the noise below which an error is negligible: 0.1 dB.
const NEGLIGIBLE: f32 = 0.02;
/// Maximum power over the noise of an echo whose errors are negligible in every cell.
const WEAK: f32 = NEGLIGIBLE / PATTERN;
/// Minimum power over the noise of an echo whose errors count in cells away from its own range.
const STRONG: f32 = NEGLIGIBLE / SKIRT;

/// Power at a place of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Power over the background.
    pub power: f32,
    /// Background as a ratio to the noise: noise, and the error of other echoes' responses.
    pub background: f32,
}

/// An echo that was taken out of the image.
#[derive(Clone, Copy, Debug)]
struct TakenEcho {
    /// Node and stored bin, fractional.
    node: f32,
    bin: f32,
    /// Phasor of the bin.
    phasor: [f32; 2],
    /// Complex amplitude, and its power over the noise.
    amplitude: [f32; 2],
    power: f32,
}

/// A finished image behind CLEAN, with the echoes that were taken out of it.
#[derive(Debug)]
pub struct Cleaned<'a> {
    image: &'a CoherentImage,
    words: &'a [u32],
    range: RangeResponse,
    echoes: Vec<TakenEcho, MAX_ECHOES>,
    /// Mean power of the noise in a cell; a full-scale tone in one row has power 1.
    noise: f32,
    /// Gain in power of a point over one row's cell.
    gain: f32,
}

impl<'a> Cleaned<'a> {
    /// Returns what is left of an image with its cells in `words` and the shape of `map`, and the echoes found in it.
    #[inline(never)]
    pub(super) fn new(
        image: &'a CoherentImage,
        words: &'a [u32],
        range: RangeResponse,
        map: &PolarMap,
        found: &FoundEchoes,
    ) -> Self {
        let octaves = (found.noise - f32::from(FULL_SCALE)) / f32::from(UNITS_PER_OCTAVE);
        let noise = math::exp2(octaves);
        let gain = CoherentImage::gain(map);
        let geometry = map.geometry();
        let mut echoes = Vec::new();
        for echo in &found.echoes {
            let power = gain * math::power_ratio(echo.snr_db);
            let node = image.nodes().at(echo.angle_rad);
            let bin = (echo.range_m - geometry.first_range_m) / geometry.bin_m;
            // As CLEAN has found it.
            let bin = bin + image.walk(words, node);
            let taken = TakenEcho {
                node,
                bin,
                phasor: range.phasor(bin),
                amplitude: echo.phasor.map(|part| math::sqrt(noise * power) * part),
                power,
            };
            // There is room.
            let _ = echoes.push(taken);
        }
        Self {
            image,
            words,
            range,
            echoes,
            noise,
            gain,
        }
    }

    /// Returns the gain in power of a surface's look over one row's cell.
    pub fn gain(&self) -> f32 {
        self.gain
    }

    /// Returns the look at a stored bin of a row and the row's angle, radians; `None` outside of the scan.
    #[inline(never)]
    pub fn look(&self, bin: usize, angle_rad: f32) -> Option<Look> {
        let nodes = self.image.nodes();
        let at = nodes.at(angle_rad);
        if at < 0.0 || math::floor(at) + 1.0 >= nodes.count() as f32 || bin >= self.image.bins() {
            return None;
        }
        let bin = self.image.bin_of(self.words, at, bin);
        if bin >= self.image.bins() {
            return None;
        }
        let mut sum = self.image.between(self.words, at, bin);
        let mut background = 1.0;
        let place = bin as f32;
        let phasor = self.range.phasor(place);
        let per_sigma = 1.0 / nodes.lobe_sigma();
        for echo in &self.echoes {
            let off = place - echo.bin;
            let near = off.abs() <= LOBE_BINS;
            if !near && echo.power < STRONG {
                continue;
            }
            let turn = (at - echo.node) * per_sigma;
            if !near && turn.abs() > DARK {
                continue;
            }
            let taken = Taken {
                power: echo.power,
                turn,
                off,
            };
            if turn.abs() > OWN {
                // All of a weak one's errors together are negligible.
                if echo.power > WEAK {
                    background += taken.error(&self.range, place);
                }
                continue;
            }
            background += taken.sweep_error(&self.range, place);
            if off.abs() <= response::REACH as f32 {
                let lobe = math::exp(-0.5 * turn * turn);
                let [re, im] = self.range.at(off, phasor, echo.phasor);
                let ([a, b], [sum_re, sum_im]) = (echo.amplitude, &mut sum);
                *sum_re += lobe * (re * a - im * b);
                *sum_im += lobe * (re * b + im * a);
            }
        }
        let [re, im] = sum;
        let power = (re * re + im * im) / (self.noise * background);
        Some(Look { power, background })
    }
}
