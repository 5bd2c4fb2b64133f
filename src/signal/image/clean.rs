//! CLEAN (Högbom 1974): the strongest point of the image is located, its response in range and angle is subtracted, and
//! so on, until what is left is no stronger than the noise and the error of what was subtracted there.
//!
//! Local maxima wait in a queue, the strongest first. One that a subtraction has changed is looked at again where it now
//! is. Maxima that a subtraction uncovers join the queue.

use super::coherent::CoherentImage;
use super::response::{self, hann};
use crate::math;
use crate::params::image::{
    IMAGE_BINS, IQ_IMAGE, LEAST, PATTERN, PHASE_NOISE, SIDE_LOBES, SKIRT, SKIRT_BINS,
};
use crate::signal::range::packed::Packed;
use heapless::Vec;
use heapless::binary_heap::{BinaryHeap, Max};

/// Maximum number of points of an image.
pub const MAX_COMPONENTS: usize = 64;
/// Maximum number of local maxima that wait.
const MAX_WAITING: usize = 192;
/// Extent of a lobe to each side over which it is subtracted, nodes: 3.7 standard deviations.
const REACH_NODES: usize = 9;
/// Distance in bins behind which the response over the range is below the error of other terms.
const LOBE_BINS: f32 = 4.0;
/// Deviations from the middle of a lobe beyond which it is dark.
const DARK: f32 = 3.5;
/// Widening of the lobe's error over the angle, as its factor, and of that over the range, stored bins: a misplaced point's.
const ANGLE_MARGIN: f32 = 1.1;
const RANGE_MARGIN: f32 = 0.3;
/// Units of a waiting maximum's level per octave of power, and octave at which they begin.
const LEVELS_PER_OCTAVE: f32 = 256.0;
const FIRST_OCTAVE: f32 = -80.0;

/// A point of the image.
#[derive(Clone, Copy, Debug, Default)]
pub struct Component {
    /// Node of the point, fractional.
    pub node: f32,
    /// Stored bin of the point, fractional.
    pub bin: f32,
    /// Complex amplitude behind the filter.
    pub amplitude: [f32; 2],
    /// Power of the amplitude.
    pub power: f32,
    /// Power over noise and error of what was subtracted before, at the time when the point was found.
    pub contrast: f32,
    /// Width of the lobe over the angle, in units of a point's.
    pub width: f32,
}

/// Response over the range, on the grid of the bins.
#[derive(Clone, Copy, Debug)]
pub struct RangeResponse {
    /// Native bins per stored bin.
    pub native_per_bin: f32,
    /// Turn of the phase from bin to bin, radians: that of the window's middle.
    pub radians_per_bin: f32,
    /// Native bin of the first stored bin.
    pub first_native: f32,
    /// Sum of the native bins of an echo and of its I/Q image; infinite without images.
    pub image_sum: f32,
}

/// CLEAN at work on an image.
pub struct Clean<'a> {
    /// The image.
    pub image: &'a CoherentImage,
    /// Mean power of the noise in a cell.
    pub noise: f32,
    words: &'a mut [u32],
    range: RangeResponse,
    /// Points found so far.
    pub found: Vec<Component, MAX_COMPONENTS>,
    waiting: BinaryHeap<u32, Max, MAX_WAITING>,
}

impl<'a> Clean<'a> {
    /// Returns CLEAN before its first point, on a finished image in its memory `words`.
    pub fn new(
        image: &'a CoherentImage,
        words: &'a mut [u32],
        range: RangeResponse,
        noise: f32,
    ) -> Self {
        Self {
            image,
            noise,
            words,
            range,
            found: Vec::new(),
            waiting: BinaryHeap::new(),
        }
    }

    /// Finds the points of the image, which holds what is left afterwards.
    pub fn run(&mut self) {
        let (nodes, bins) = (self.image.nodes().count(), self.image.bins());
        self.queue((0, nodes), (0, bins));
        while let Some(word) = self.waiting.pop() {
            if self.found.is_full() {
                return;
            }
            let (level, cell) = ((word >> 16) as u16, (word & 0xffff) as usize);
            let (node, bin) = self.climb(cell / bins, cell % bins);
            let power = self.power(node, bin);
            if power < LEAST * self.noise {
                continue;
            }
            let now = self.level(power);
            if now < level {
                self.wait(now, node, bin);
                continue;
            }
            let background = self.noise + self.error(node, bin);
            if power < LEAST * background {
                continue;
            }
            let mut point = self.locate(node, bin);
            // Noise has peaks that are narrower than a point's response.
            point.contrast = point.power / background;
            if point.contrast < LEAST {
                continue;
            }
            self.subtract(&point);
            // There is room.
            let _ = self.found.push(point);
            let block = |at: usize, reach: usize, end: usize| {
                (at.saturating_sub(reach), (at + reach + 1).min(end))
            };
            self.queue(
                block(node, REACH_NODES, nodes),
                block(bin, response::REACH, bins),
            );
        }
    }

    /// Returns the level of a power as it waits.
    fn level(&self, power: f32) -> u16 {
        let octaves = math::log2(math::max(power, f32::MIN_POSITIVE)) - FIRST_OCTAVE;
        // The cast saturates.
        (octaves * LEVELS_PER_OCTAVE) as u16
    }

    fn wait(&mut self, level: u16, node: usize, bin: usize) {
        let cell = (node * self.image.bins() + bin) as u32;
        // The queue is longer than the number of points that it is for.
        let _ = self.waiting.push(u32::from(level) << 16 | cell & 0xffff);
    }

    /// Returns a cell's value, 0 outside.
    fn cell(&self, node: usize, bin: usize) -> [f32; 2] {
        self.image.cell(self.words, node, bin)
    }

    fn power(&self, node: usize, bin: usize) -> f32 {
        let [re, im] = self.cell(node, bin);
        re * re + im * im
    }

    /// Queues the local maxima of a block that are stronger than the noise.
    fn queue(&mut self, nodes: (usize, usize), bins: (usize, usize)) {
        let least = LEAST * self.noise;
        for node in nodes.0..nodes.1 {
            let (mut before, mut here) = (0.0, 0.0);
            if bins.0 > 0 {
                before = self.power(node, bins.0 - 1);
            }
            for bin in bins.0..=bins.1 {
                let next = self.power(node, bin);
                if bin > bins.0 && here >= least && here > before && here >= next {
                    let above = node.checked_sub(1).map_or(0.0, |n| self.power(n, bin - 1));
                    if here > above && here >= self.power(node + 1, bin - 1) {
                        self.wait(self.level(here), node, bin - 1);
                    }
                }
                if bin > bins.0 {
                    before = here;
                }
                here = next;
            }
        }
    }

    /// Returns the local maximum next to a cell.
    fn climb(&self, mut node: usize, mut bin: usize) -> (usize, usize) {
        for _ in 0..4 {
            let mut best = (self.power(node, bin), node, bin);
            for n in node.saturating_sub(1)..=node + 1 {
                for b in bin.saturating_sub(1)..=bin + 1 {
                    let power = self.power(n, b);
                    if power > best.0 {
                        best = (power, n, b);
                    }
                }
            }
            if (best.1, best.2) == (node, bin) {
                break;
            }
            (node, bin) = (best.1, best.2);
        }
        (node, bin)
    }

    /// Returns the power of the error that the points found so far leave in a cell.
    pub fn error(&self, node: usize, bin: usize) -> f32 {
        let sigma = self.image.nodes().lobe_sigma();
        let range = &self.range;
        let native = range.first_native + bin as f32 * range.native_per_bin;
        let errors = self.found.iter().map(|p| {
            let turn = (node as f32 - p.node) / (ANGLE_MARGIN * sigma);
            let off = (bin as f32 - p.bin).abs();
            let dark = turn.abs() > DARK;
            if dark && off > LOBE_BINS {
                return 0.0;
            }
            let along = if off > LOBE_BINS {
                0.0
            } else {
                let w = hann(math::max(off - RANGE_MARGIN, 0.0) * range.native_per_bin);
                w * w
            };
            let mut share = SIDE_LOBES * along;
            if !dark {
                let own = range.first_native + p.bin * range.native_per_bin;
                let mut beam = PATTERN * along + PHASE_NOISE;
                if off * range.native_per_bin <= SKIRT_BINS {
                    beam += SKIRT;
                }
                if (native + own - range.image_sum).abs() <= IMAGE_BINS {
                    beam += IQ_IMAGE;
                }
                share += math::exp(-turn * turn) * beam;
            }
            p.power * share
        });
        errors.sum()
    }

    /// Returns the point at the local maximum (`node`, `bin`).
    fn locate(&self, node: usize, bin: usize) -> Component {
        let log = |n: Option<usize>, b: Option<usize>| match (n, b) {
            (Some(n), Some(b)) => math::ln(self.power(n, b) + 1e-6 * self.noise),
            _ => f32::NEG_INFINITY,
        };
        let here = log(Some(node), Some(bin));
        let (less, more) = (
            log(node.checked_sub(1), Some(bin)),
            log(Some(node + 1), Some(bin)),
        );
        let inside = node > 0 && node + 1 < self.image.nodes().count();
        let (turn, bend) = if inside {
            vertex(less, here, more)
        } else {
            (0.0, 0.0)
        };
        let sigma = self.image.nodes().lobe_sigma();
        let point = 1.0 / (sigma * sigma);
        let width = if bend > 0.02 * point {
            math::sqrt(point / bend)
        } else {
            9.0
        };
        let (less, more) = (
            log(Some(node), bin.checked_sub(1)),
            log(Some(node), Some(bin + 1)),
        );
        let (shift, _) = if bin > 0 && bin + 1 < self.image.bins() {
            vertex(less, here, more)
        } else {
            (0.0, 0.0)
        };
        let mut found = Component {
            node: node as f32 + turn,
            bin: bin as f32 + shift,
            width,
            ..Component::default()
        };
        found.amplitude = self.amplitude(&found, node, bin);
        let [re, im] = found.amplitude;
        found.power = re * re + im * im;
        found
    }

    /// Returns the least-squares amplitude of a point from the cells around (`node`, `bin`).
    fn amplitude(&self, point: &Component, node: usize, bin: usize) -> [f32; 2] {
        let (mut sum, mut norm) = ([0.0f32; 2], 0.0);
        for b in bin.saturating_sub(1)..=bin + 1 {
            let (along, [cos, sin]) = self.along(point, b);
            for n in node.saturating_sub(1)..=node + 1 {
                let r = along * self.lobe(point, n);
                let [re, im] = self.cell(n, b);
                sum[0] += r * (re * cos + im * sin);
                sum[1] += r * (im * cos - re * sin);
                norm += r * r;
            }
        }
        let per = 1.0 / math::max(norm, f32::MIN_POSITIVE);
        [sum[0] * per, sum[1] * per]
    }

    /// Returns the response of a point in bin `b`: size, and phasor.
    fn along(&self, point: &Component, b: usize) -> (f32, [f32; 2]) {
        let off = b as f32 - point.bin;
        let (sin, cos) = math::sin_cos(-self.range.radians_per_bin * off);
        (hann(off * self.range.native_per_bin), [cos, sin])
    }

    /// Returns the lobe of a point in node `n`, in voltage.
    fn lobe(&self, point: &Component, n: usize) -> f32 {
        let t = (n as f32 - point.node) / self.image.nodes().lobe_sigma();
        math::exp(-0.5 * t * t)
    }

    /// Subtracts a point's response.
    fn subtract(&mut self, point: &Component) {
        let bins = self.image.bins();
        let (node, bin) = (
            math::round(point.node) as usize,
            math::round(point.bin) as usize,
        );
        let first = bin.saturating_sub(response::REACH);
        let end = (bin + response::REACH + 1).min(bins);
        let mut responses = [[0.0f32; 2]; 2 * response::REACH + 1];
        for (r, b) in responses.iter_mut().zip(first..end) {
            let (along, [cos, sin]) = self.along(point, b);
            let [re, im] = point.amplitude;
            *r = [along * (re * cos - im * sin), along * (re * sin + im * cos)];
        }
        let last = (node + REACH_NODES + 1).min(self.image.nodes().count());
        for n in node.saturating_sub(REACH_NODES)..last {
            let scale = self.lobe(point, n) / self.image.unit(n);
            let Some(cells) = self.words.get_mut(n * bins + first..n * bins + end) else {
                return;
            };
            for (word, [re, im]) in cells.iter_mut().zip(responses) {
                let x = Packed(*word);
                // The casts saturate.
                let part = |x: i16, r: f32| math::round(f32::from(x) - scale * r) as i16;
                *word = Packed::new(part(x.re(), re), part(x.im(), im)).0;
            }
        }
    }
}

/// Returns vertex (at most 0.6 from the middle) and curvature of the parabola through three logarithms.
fn vertex(less: f32, here: f32, more: f32) -> (f32, f32) {
    let bend = here - 0.5 * (less + more);
    if bend <= 0.0 {
        return (0.0, bend);
    }
    ((0.25 * (more - less) / bend).clamp(-0.6, 0.6), bend)
}
