//! CLEAN (Högbom 1974): the strongest point of the image is located, its response in range and angle is subtracted, and
//! so on, until what is left is no stronger than the noise and the error of what was subtracted there.

use super::coherent::CoherentImage;
use super::response::{self, RangeResponse};
use super::waiting::{Place, Waiting};
use crate::math;
use crate::params::image::{
    IMAGE_BINS, IQ_IMAGE, LEAST, PATTERN, PHASE_NOISE, SIDE_LOBES, SKIRT, SKIRT_BINS,
};
use crate::signal::echoes::MAX_ECHOES;
use crate::signal::range::packed::Packed;
use heapless::Vec;

/// Extent of a lobe to each side over which it is subtracted, nodes: 3.7 standard deviations.
const REACH_NODES: usize = 9;
/// Number of nodes over which a lobe is subtracted.
const LOBE_NODES: usize = 2 * REACH_NODES + 1;
/// Number of bins over which a response is subtracted.
const RESPONSE_BINS: usize = 2 * response::REACH + 1;
/// Distance in bins behind which the response over the range is below the error of other terms.
pub(super) const LOBE_BINS: f32 = 4.0;
/// Deviations from the middle of a lobe beyond which it is dark.
pub(super) const DARK: f32 = 3.5;
/// Widening of the lobe's error over the angle, as its factor, and of that over the range, stored bins: a misplaced point's.
const ANGLE_MARGIN: f32 = 1.1;
const RANGE_MARGIN: f32 = 0.3;
/// Amplitude, as a share of the noise's, below which a response is not subtracted.
const NEGLIGIBLE: f32 = 0.25;
/// Curvature of a lobe without a peak, as a share of a point's, and the width that it is given.
const FLAT: f32 = 0.02;
const FLAT_WIDTH: f32 = 9.0;
/// Share of the noise that keeps logarithms finite.
const FLOOR: f32 = 1e-6;

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

/// CLEAN at work on an image.
pub struct Clean<'a> {
    /// The image.
    pub image: &'a CoherentImage,
    /// Mean power of the noise in a cell.
    pub noise: f32,
    words: &'a mut [u32],
    /// Response over the range.
    pub range: RangeResponse,
    /// Points found so far.
    pub found: Vec<Component, MAX_ECHOES>,
    waiting: Waiting,
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
            waiting: Waiting::new(),
        }
    }

    /// Returns the image's memory.
    pub fn words(&self) -> &[u32] {
        self.words
    }

    /// Finds the points of the image, which holds what is left afterwards.
    #[inline(never)]
    pub fn run(&mut self) {
        let (nodes, bins) = (self.image.nodes().count(), self.image.bins());
        self.queue((0, nodes), (0, bins));
        while !self.found.is_full()
            && let Some((level, place)) = self.waiting.pop()
        {
            let place = self.climb(place);
            let power = self.power(place);
            let now = Waiting::level(power);
            if now < level && power >= LEAST * self.noise {
                // What was subtracted has changed it: it waits for its turn.
                self.waiting.push(now, place);
                continue;
            }
            if let Some(point) = self.point(place, power) {
                self.subtract(&point);
                // There is room.
                let _ = self.found.push(point);
                self.queue_around(place);
            }
        }
    }

    /// Queues the local maxima that the subtraction of a point at `place` has uncovered.
    fn queue_around(&mut self, place: Place) {
        let block = |at: usize, reach: usize, end: usize| {
            (at.saturating_sub(reach), (at + reach + 1).min(end))
        };
        self.queue(
            block(place.node, REACH_NODES, self.image.nodes().count()),
            block(place.bin, response::REACH, self.image.bins()),
        );
    }

    /// Returns the point at a local maximum; `None` if noise or the error of what was subtracted explains it.
    fn point(&self, place: Place, power: f32) -> Option<Component> {
        let background = self.noise + self.error(place);
        if power < LEAST * background {
            return None;
        }
        let mut point = self.locate(place);
        // Noise has peaks that are narrower than a point's response.
        point.contrast = point.power / background;
        (point.contrast >= LEAST).then_some(point)
    }

    /// Returns a cell's value, 0 outside.
    fn cell(&self, place: Place) -> [f32; 2] {
        self.image.cell(self.words, place.node, place.bin)
    }

    fn power(&self, place: Place) -> f32 {
        let [re, im] = self.cell(place);
        re * re + im * im
    }

    /// Queues the local maxima of a block, from its first node and bin to before its last, that are stronger than the
    /// noise.
    #[inline(never)]
    fn queue(&mut self, nodes: (usize, usize), bins: (usize, usize)) {
        let width = self.image.bins();
        let (from, to) = (bins.0.saturating_sub(1), (bins.1 + 1).min(width));
        for node in nodes.0..nodes.1 {
            let unit = self.image.unit(node);
            // The cast saturates.
            let least = (LEAST * self.noise / (unit * unit)) as u32;
            let Some(row) = self.words.get(node * width + from..node * width + to) else {
                return;
            };
            let mut before = 0;
            for (k, &word) in row.iter().enumerate() {
                let here = squared(word);
                // Most cells are noise.
                if here >= least && here > before {
                    let bin = from + k;
                    let next = row.get(k + 1).map_or(0, |&x| squared(x));
                    let place = Place { node, bin };
                    if here >= next
                        && (bins.0..bins.1).contains(&bin)
                        && let Some(level) = peak_level(self.image, self.words, place)
                    {
                        self.waiting.push(level, place);
                    }
                }
                before = here;
            }
        }
    }

    /// Returns the local maximum next to a cell.
    fn climb(&self, mut place: Place) -> Place {
        for _ in 0..4 {
            let mut best = (self.power(place), place);
            for node in place.node.saturating_sub(1)..=place.node + 1 {
                for bin in place.bin.saturating_sub(1)..=place.bin + 1 {
                    let near = Place { node, bin };
                    let power = self.power(near);
                    if power > best.0 {
                        best = (power, near);
                    }
                }
            }
            if best.1 == place {
                break;
            }
            place = best.1;
        }
        place
    }

    /// Returns the power of the error that the points found so far leave in a cell.
    fn error(&self, place: Place) -> f32 {
        let per_sigma = 1.0 / self.image.nodes().lobe_sigma();
        let bin = place.bin as f32;
        let errors = self.found.iter().map(|p| {
            let taken = Taken {
                power: p.power,
                turn: (place.node as f32 - p.node) * per_sigma,
                off: bin - p.bin,
            };
            taken.error(&self.range, bin)
        });
        errors.sum()
    }

    /// Returns the point at a local maximum, without its contrast.
    fn locate(&self, place: Place) -> Component {
        let Place { node, bin } = place;
        let log = |node: usize, bin: usize| {
            math::ln(self.power(Place { node, bin }) + FLOOR * self.noise)
        };
        let here = log(node, bin);
        // Beyond the first and the last node and bin it is dark: there the peak stays in its cell.
        let (turn, bend) = match node > 0 && node + 1 < self.image.nodes().count() {
            true => vertex(log(node - 1, bin), here, log(node + 1, bin)),
            false => (0.0, 0.0),
        };
        let (shift, _) = match bin > 0 && bin + 1 < self.image.bins() {
            true => vertex(log(node, bin - 1), here, log(node, bin + 1)),
            false => (0.0, 0.0),
        };
        let sigma = self.image.nodes().lobe_sigma();
        let share = bend * sigma * sigma;
        let mut found = Component {
            node: node as f32 + turn,
            bin: bin as f32 + shift,
            width: match share > FLAT {
                true => 1.0 / math::sqrt(share),
                false => FLAT_WIDTH,
            },
            ..Component::default()
        };
        found.amplitude = self.amplitude(&found, place);
        let [re, im] = found.amplitude;
        found.power = re * re + im * im;
        found
    }

    /// Returns the least-squares amplitude of a point from the cells around a place.
    fn amplitude(&self, point: &Component, place: Place) -> [f32; 2] {
        let (mut sum, mut norm) = ([0.0f32; 2], 0.0);
        let first = place.node.saturating_sub(1);
        let lobes: [f32; 3] = core::array::from_fn(|k| self.lobe(point, first + k));
        let nearest = place.bin.saturating_sub(1);
        let mut along = [[0.0; 2]; 3];
        self.range.along(nearest as f32 - point.bin, &mut along);
        for (bin, [along_re, along_im]) in (nearest..=place.bin + 1).zip(along) {
            for (k, lobe) in lobes.into_iter().enumerate() {
                let node = first + k;
                let [re, im] = self.cell(Place { node, bin });
                let [r, i] = [along_re * lobe, along_im * lobe];
                sum = [sum[0] + re * r + im * i, sum[1] + im * r - re * i];
                norm += r * r + i * i;
            }
        }
        let per = 1.0 / math::max(norm, f32::MIN_POSITIVE);
        sum.map(|part| part * per)
    }

    /// Returns the lobe of a point in a node, in voltage.
    fn lobe(&self, point: &Component, node: usize) -> f32 {
        let t = (node as f32 - point.node) / self.image.nodes().lobe_sigma();
        math::exp(-0.5 * t * t)
    }

    /// Subtracts a point's response, as far as it exceeds the noise.
    #[inline(never)]
    fn subtract(&mut self, point: &Component) {
        let width = self.image.bins();
        // The casts saturate.
        let (node, bin) = (
            math::round(point.node) as usize,
            math::round(point.bin) as usize,
        );
        let size = math::sqrt(point.power);
        let least = NEGLIGIBLE * math::sqrt(self.noise) / size;
        let first = bin.saturating_sub(response::REACH);
        let end = (bin + response::REACH + 1).min(width);
        let mut responses = [Response::default(); RESPONSE_BINS];
        let mut along = [[0.0; 2]; RESPONSE_BINS];
        self.range.along(first as f32 - point.bin, &mut along);
        let [a, b] = point.amplitude.map(|part| part / size);
        for (response, [re, im]) in responses.iter_mut().zip(along).take(end - first) {
            *response = Response::new(re * a - im * b, re * b + im * a);
        }
        // Below the noise from the same bin on at both ends.
        let seen = |response: &Response| !response.is_below(least);
        let begin = responses.iter().position(seen).unwrap_or(0);
        let end = responses.iter().rposition(seen).map_or(0, |last| last + 1);
        let responses = responses.get(begin..end).unwrap_or(&[]);
        let first = first + begin;
        let from = node.saturating_sub(REACH_NODES);
        for n in (from..self.image.nodes().count()).take(LOBE_NODES) {
            let lobe = self.lobe(point, n);
            if lobe < least {
                continue;
            }
            // A mantissa has 15 bits, so that this fits. The cast saturates.
            let scale = (lobe * size * Response::SCALE / self.image.unit(n)) as i32;
            let cells = self.words.get_mut(n * width + first..).unwrap_or(&mut []);
            for (word, response) in cells.iter_mut().zip(responses) {
                *word = response.subtracted(Packed(*word), scale).0;
            }
        }
    }
}

/// A point that was subtracted, as seen from a cell.
pub(super) struct Taken {
    /// Power of the point.
    pub power: f32,
    /// Angle from the point to the cell, standard deviations of a lobe.
    pub turn: f32,
    /// Distance from the point to the cell, stored bins.
    pub off: f32,
}

impl Taken {
    /// Returns the power of the error that the point leaves in the cell, which lies in stored bin `bin`: of its response, and
    /// of what the sweep adds.
    pub fn error(&self, range: &RangeResponse, bin: f32) -> f32 {
        let turn = self.turn * (1.0 / ANGLE_MARGIN);
        let off = self.off.abs();
        let dark = turn.abs() > DARK;
        if dark && off > LOBE_BINS {
            return 0.0;
        }
        let along = match off > LOBE_BINS {
            true => 0.0,
            false => range.power(math::max(off - RANGE_MARGIN, 0.0)),
        };
        if dark {
            return self.power * SIDE_LOBES * along;
        }
        let beam = math::exp(-turn * turn);
        self.power * along * (SIDE_LOBES + PATTERN * beam) + beam * self.sweep_error(range, bin)
    }

    /// Returns the power that errors of the sweep and of the receiver put into the cell beside the point's response.
    pub fn sweep_error(&self, range: &RangeResponse, bin: f32) -> f32 {
        let mut share = PHASE_NOISE;
        if self.off.abs() * range.native_per_bin <= SKIRT_BINS {
            share += SKIRT;
        }
        if (range.native(bin) + range.native(bin - self.off) - range.image_sum).abs() <= IMAGE_BINS
        {
            share += IQ_IMAGE;
        }
        self.power * share
    }
}

/// Response of a point in one bin, relative to the point's amplitude, in units of 2⁻¹⁴.
#[derive(Clone, Copy, Default)]
struct Response {
    re: i32,
    im: i32,
}

impl Response {
    /// Bits of the parts.
    const BITS: u32 = 14;
    /// Factor of a scale: with it, the product of scale and part is in mantissas times 2¹⁶.
    const SCALE: f32 = 4.0;

    fn new(re: f32, im: f32) -> Self {
        let part = |x: f32| (x * (1 << Self::BITS) as f32) as i32;
        Self {
            re: part(re),
            im: part(im),
        }
    }

    /// Whether both parts are below a share of the point's amplitude.
    fn is_below(&self, least: f32) -> bool {
        // The cast saturates.
        let least = (least * (1 << Self::BITS) as f32) as i32;
        self.re.abs() < least && self.im.abs() < least
    }

    /// Returns a cell less this response times a scale.
    #[inline(always)]
    fn subtracted(&self, x: Packed, scale: i32) -> Packed {
        let part = |x: i16, r: i32| {
            let product = (i64::from(scale) * i64::from(r) + (1 << 15)) >> 16;
            let left = i32::from(x) - product as i32;
            left.clamp(i16::MIN.into(), i16::MAX.into()) as i16
        };
        Packed::new(part(x.re(), self.re), part(x.im(), self.im))
    }
}

/// Returns the level of a maximum over the bins if it is one over the nodes, too.
fn peak_level(image: &CoherentImage, words: &[u32], place: Place) -> Option<u16> {
    let power = |node: usize| {
        let [re, im] = image.cell(words, node, place.bin);
        re * re + im * im
    };
    let here = power(place.node);
    let above = place.node.checked_sub(1).map_or(0.0, power);
    (here > above && here >= power(place.node + 1)).then(|| Waiting::level(here))
}

/// Returns the power of a cell's mantissas.
#[inline(always)]
fn squared(word: u32) -> u32 {
    let x = Packed(word);
    let (re, im) = (i32::from(x.re()), i32::from(x.im()));
    (re * re) as u32 + (im * im) as u32
}

/// Returns vertex (at most 0.6 from the middle) and curvature of the parabola through three logarithms.
fn vertex(less: f32, here: f32, more: f32) -> (f32, f32) {
    let bend = here - 0.5 * (less + more);
    if bend <= 0.0 {
        return (0.0, bend);
    }
    ((0.25 * (more - less) / bend).clamp(-0.6, 0.6), bend)
}
