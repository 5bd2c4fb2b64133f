//! The image, summed up row by row in fixed point.

use super::drift::Drift;
use super::nodes::{self, MAX_NODES, MAX_OPEN, Nodes};
use super::reference::CoherentRow;
use super::walk::{self, NodeWalk, aligned, moved};
use crate::config::RadarConfig;
use crate::drive::ExpectedTravel;
use crate::math;
use crate::signal::grid::PolarMap;
use crate::signal::range::packed::{Native, Packed, turn};

/// Bits of the sums below amplitude 1: a point of full scale gains less than 2³ (√2 · 5.5 with the default beam), and
/// the noise of a 16-bit converter is some 2¹⁴.
const FRACTION_BITS: i32 = 27;
/// Number of bits by which the product of a 32-bit weight and a 16-bit mantissa is shifted.
const PRODUCT_SHIFT: u32 = 16;
/// Levels of the histogram per octave of power.
const LEVELS_PER_OCTAVE: f32 = 4.0;
/// Number of words of the histogram, one a level: up to 2⁴⁸, 60 dB above a 16-bit converter's noise.
const HISTOGRAM: usize = 160;
/// Octaves of power in the sums' unit at which the histogram begins.
const FIRST_OCTAVE: i32 = 8;
/// Largest number in Q15.
const Q15: f32 = 32_767.0;
/// ln 2: the median of an exponential distribution is its mean times this.
const LN_2: f32 = core::f32::consts::LN_2;

/// Coherent image of a scan. Its cells are in the memory that is passed to each function, `nodes × bins` words with two
/// 16-bit parts, and behind them the sums of the nodes that are still open, two words a cell. At its end are the walk of each
/// node, the number of cells by level, in quarter octaves of power, and the row before.
#[derive(Clone, Debug)]
pub struct CoherentImage {
    nodes: Nodes,
    bins: usize,
    /// Nodes that are open: the first, and the one behind the last.
    open: (usize, usize),
    drift: Drift,
    /// Forward travel since the first row, metres, of a chair that may move, so that echoes turn and walk from row to row;
    /// `None` where it stands.
    travel_m: Option<f32>,
    /// Forward travel since the last row that was added, metres.
    step_m: f32,
    /// Bins by which a scatterer straight ahead walks a metre of travel; turns of the phase from bin to bin, and of a scatterer
    /// straight ahead a metre of travel, radians.
    bins_per_m: f32,
    radians_per_bin: f32,
    radians_per_m: f32,
    /// Whether a row has been added.
    begun: bool,
    /// Exponent of each node's cells: a mantissa of 1 is 2^exponent units of the sums.
    exponents: [u8; MAX_NODES],
    /// Seen bin of the first cells of the finished image.
    first: i32,
}

impl Default for CoherentImage {
    fn default() -> Self {
        Self::new()
    }
}

impl CoherentImage {
    /// Returns an image without nodes.
    pub const fn new() -> Self {
        Self {
            nodes: Nodes::EMPTY,
            bins: 0,
            open: (0, 0),
            drift: Drift::new(),
            travel_m: None,
            step_m: 0.0,
            bins_per_m: 0.0,
            radians_per_bin: 0.0,
            radians_per_m: 0.0,
            begun: false,
            exponents: [0; MAX_NODES],
            first: 0,
        }
    }

    /// Prepares for the first row of a scan by `radar` with the shape of `map`, in a memory of `words` words.
    pub fn begin(&mut self, map: &PolarMap, radar: &RadarConfig, words: usize) {
        (self.travel_m, self.step_m) = (None, 0.0);
        let bin_m = map.geometry().bin_m;
        self.bins_per_m = 1.0 / bin_m;
        self.radians_per_bin = core::f32::consts::PI * bin_m / radar.range_resolution_m();
        self.radians_per_m = -2.0 * core::f32::consts::TAU / radar.wavelength_m();
        let bins = map.bins().max(1);
        let cells = words.saturating_sub(HISTOGRAM + bins + 2 * MAX_OPEN * bins);
        let most = cells / bins.saturating_add(walk::WORDS);
        self.nodes = Nodes::of(map, most);
        self.bins = map.bins();
        self.open = (0, 0);
        self.begun = false;
        self.drift.begin();
        self.exponents.fill(0);
        self.first = 0;
    }

    /// Returns the angles of the nodes.
    pub fn nodes(&self) -> &Nodes {
        &self.nodes
    }

    /// Returns the number of range bins.
    pub fn bins(&self) -> usize {
        self.bins
    }

    /// States that from the next row on the chair may move, and its travel.
    pub fn expect(&mut self, travel: ExpectedTravel) {
        self.travel_m = Some(travel.since_first_m);
        self.step_m += travel.step_m;
    }

    /// Adds a row seen at `angle_rad`, whose beam points forward by the share `ahead`. Rows come in either direction; a lost
    /// one is left out.
    pub fn add(
        &mut self,
        words: &mut [u32],
        (angle_rad, ahead): (f32, f32),
        row: &mut CoherentRow<'_>,
    ) {
        let around = self.nodes.around(angle_rad);
        let walk = self.travel_m.unwrap_or(0.0) * ahead * self.bins_per_m;
        // The cast saturates.
        let whole = math::round(walk) as i32;
        self.advance(words, around, whole);
        if self.travel_m.is_some() || !row.referenced {
            turn_back(row.bins, (whole as f32 - walk) * self.radians_per_bin);
            let step_m = core::mem::take(&mut self.step_m);
            let expected_rad = step_m * ahead * self.radians_per_m;
            let before = last(words, self.bins);
            let turned_rad = self.drift.row(row, (whole, expected_rad), before);
            turn_back(row.bins, turned_rad);
        }
        let scale = row.unit * math::exp2((FRACTION_BITS + PRODUCT_SHIFT as i32) as f32);
        for j in around.0..around.1 {
            let weight = self.nodes.weight(j, angle_rad);
            let mut walked = self.node_walk(words, j);
            walked.add(walk, weight);
            self.set_walk(words, j, walked);
            let (first_bin, first_sum) = aligned(whole.wrapping_sub(walked.first));
            // Weights are below 1 and mantissas of 1 below 2⁻¹⁴, so that this fits. The cast saturates.
            let weight = math::round(weight * scale) as i32;
            let Some(sums) = self.sums(words, j) else {
                return;
            };
            let sums = sums.get_mut(2 * first_sum..).unwrap_or_default();
            let bins = row.bins.get(first_bin..).unwrap_or_default();
            for (sum, x) in sums.as_chunks_mut().0.iter_mut().zip(bins) {
                let [re, im] = sum;
                *re = re.wrapping_add_signed(scaled(weight, x.re()));
                *im = im.wrapping_add_signed(scaled(weight, x.im()));
            }
        }
    }

    /// Returns the walk of node `j`; none without memory.
    #[inline(never)]
    fn node_walk(&self, words: &[u32], j: usize) -> NodeWalk {
        let at = self.walk_at(words.len(), j);
        let known = words.get(at..).and_then(|words| words.first_chunk());
        known.map_or_else(NodeWalk::default, |known| NodeWalk::from_words(*known))
    }

    fn set_walk(&self, words: &mut [u32], j: usize, walk: NodeWalk) {
        let at = self.walk_at(words.len(), j);
        let place = words.get_mut(at..);
        if let Some(place) = place.and_then(|words| words.first_chunk_mut()) {
            *place = walk.to_words();
        }
    }

    /// Returns the number of words at the memory's end: histogram and the row before.
    fn tail(&self) -> usize {
        HISTOGRAM + self.bins
    }

    /// Returns the index of the first word of the walk of node `j` in a memory of `words` words.
    fn walk_at(&self, words: usize, j: usize) -> usize {
        let nodes = self.nodes.count().saturating_sub(j);
        words.saturating_sub(self.tail() + walk::WORDS * nodes)
    }

    /// Returns the walk at a (fractional) node that is not negative, in bins: by how much a scatterer was nearer in its row
    /// than in the finished image.
    pub fn walk(&self, words: &[u32], node: f32) -> f32 {
        if self.travel_m.is_none() {
            return 0.0;
        }
        // The cast saturates.
        let j = node as usize;
        let mean = |j: usize| self.node_walk(words, j).mean();
        mean(j) + (node - j as f32) * (mean(j + 1) - mean(j)) - self.first as f32
    }

    /// Returns the bin of the finished image in which a bin of a row at a (fractional) node that is not negative lies, beyond the
    /// last if in none.
    pub fn bin_of(&self, words: &[u32], node: f32, bin: usize) -> usize {
        let walked = math::round(bin as f32 + self.walk(words, node));
        // The cast saturates.
        if walked < 0.0 {
            usize::MAX
        } else {
            walked as usize
        }
    }

    /// Moves the cells of all nodes so that they begin at the same seen bin, in the middle between the first and the last.
    #[inline(never)]
    fn align(&mut self, words: &mut [u32]) {
        let firsts = (0..self.nodes.count()).map(|j| self.node_walk(words, j).first);
        let (least, most) = firsts.fold((0, 0), |(least, most), first| {
            (least.min(first), most.max(first))
        });
        self.first = least.midpoint(most);
        for j in 0..self.nodes.count() {
            let by = self.node_walk(words, j).first - self.first;
            if let Some(cells) = words.get_mut(j * self.bins..(j + 1) * self.bins) {
                moved(cells, by);
            }
        }
    }

    /// Closes all nodes after the last row.
    pub fn finish(&mut self, words: &mut [u32]) {
        let end = self.open.1;
        self.advance(words, (end, end), 0);
        if self.travel_m.is_some() {
            self.align(words);
        }
    }

    /// Closes the open nodes outside of `around`, and opens those within that are not open, with their first cells at the seen
    /// bin `seen`.
    fn advance(&mut self, words: &mut [u32], around: (usize, usize), seen: i32) {
        let (first, end) = core::mem::replace(&mut self.open, around);
        let within = |j: usize, of: (usize, usize)| (of.0..of.1).contains(&j);
        for j in (first..end).filter(|&j| !within(j, around)) {
            self.close(words, j);
        }
        if !self.begun {
            // Nodes that no row reaches stay dark.
            self.begun = true;
            words.fill(0);
        }
        for j in (around.0..around.1).filter(|&j| !within(j, (first, end))) {
            if let Some(sums) = self.sums(words, j) {
                sums.fill(0);
            }
            self.set_walk(words, j, NodeWalk::new(seen));
        }
    }

    /// Returns the sums of an open node, real and imaginary parts in turn; `None` without memory.
    fn sums<'w>(&self, words: &'w mut [u32], j: usize) -> Option<&'w mut [u32]> {
        let row = 2 * self.bins;
        let first = self.nodes.count() * self.bins + j % MAX_OPEN * row;
        words.get_mut(first..first + row)
    }

    /// Turns the sums of node `j` into cells with a common exponent.
    fn close(&mut self, words: &mut [u32], j: usize) {
        let behind = words.len().saturating_sub(self.tail());
        let (words, histogram) = words.split_at_mut(behind);
        let histogram = histogram.get_mut(..HISTOGRAM).unwrap_or_default();
        let (cells, sums) = words
            .split_at_mut_checked(self.nodes.count() * self.bins)
            .unwrap_or_default();
        let Some(cells) = cells.get_mut(j * self.bins..(j + 1) * self.bins) else {
            return;
        };
        let row = 2 * self.bins;
        let Some(sums) = sums
            .get(j % MAX_OPEN * row..)
            .and_then(|sums| sums.get(..row))
        else {
            return;
        };
        let all = sums
            .iter()
            .fold(0, |all, &sum| all | (sum as i32).unsigned_abs());
        // The largest part fits 15 bits and the sign, also when it is rounded up.
        let exponent = (u32::BITS + 1 - all.leading_zeros()).saturating_sub(15);
        if let Some(place) = self.exponents.get_mut(j) {
            *place = exponent as u8;
        }
        let half = (1 << exponent) >> 1;
        let rounded = |sum: u32| (sum as i32).saturating_add(half) >> exponent;
        let octaves = 2 * exponent as i32 - FIRST_OCTAVE;
        for (cell, &[re, im]) in cells.iter_mut().zip(sums.as_chunks().0) {
            let (re, im) = (rounded(re), rounded(im));
            *cell = Packed::new(re as i16, im as i16).0;
            let power = (re * re) as u32 + (im * im) as u32;
            let level = level(power) + LEVELS_PER_OCTAVE as i32 * octaves;
            let level = level.clamp(0, HISTOGRAM as i32 - 1);
            if let Some(count) = histogram.get_mut(level as usize) {
                *count += 1;
            }
        }
    }

    /// Returns the mean power of the noise in a cell, by the median of all cells; a full-scale tone in one row has power 1.
    /// `None` without cells.
    pub fn noise(&self, words: &[u32]) -> Option<f32> {
        let first = words.len().checked_sub(self.tail())?;
        let histogram = words.get(first..first + HISTOGRAM)?;
        let total: u32 = histogram.iter().sum();
        let half = total as f32 * 0.5;
        let mut below = 0.0;
        for (level, &n) in histogram.iter().enumerate() {
            let n = n as f32;
            if n > 0.0 && below + n >= half {
                let level = level as f32 + (half - below) / n;
                let octaves = level / LEVELS_PER_OCTAVE + (FIRST_OCTAVE - 2 * FRACTION_BITS) as f32;
                return Some(math::exp2(octaves) / LN_2);
            }
            below += n;
        }
        None
    }

    /// Returns a cell of a finished image, `[re, im]`; a full-scale tone in one row has amplitude 1. 0 outside.
    pub fn cell(&self, words: &[u32], node: usize, bin: usize) -> [f32; 2] {
        if bin >= self.bins || node >= self.nodes.count() {
            return [0.0; 2];
        }
        let x = Packed(words.get(node * self.bins + bin).copied().unwrap_or(0));
        let unit = self.unit(node);
        [f32::from(x.re()) * unit, f32::from(x.im()) * unit]
    }

    /// Returns the value of a finished image at a (fractional) node that is not negative, interpolated between two nodes.
    #[inline(always)]
    pub fn between(&self, words: &[u32], at: f32, bin: usize) -> [f32; 2] {
        // The cast saturates.
        let node = at as usize;
        let share = at - node as f32;
        let [a, b] = [node, node + 1].map(|node| self.cell(words, node, bin));
        [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
    }

    /// Returns the amplitude of a mantissa of 1 in node `j`.
    pub fn unit(&self, j: usize) -> f32 {
        let exponent = self.exponents.get(j).copied().unwrap_or(0);
        // 2^(exponent - FRACTION_BITS).
        f32::from_bits(((i32::from(exponent) - FRACTION_BITS + 127) as u32) << 23)
    }

    /// Returns the gain in power of a point over one cell of the map.
    pub fn gain(map: &PolarMap) -> f32 {
        nodes::energy(map.geometry())
    }
}

/// Turns all bins back by an angle.
fn turn_back(bins: &mut [Packed], angle_rad: f32) {
    if angle_rad != 0.0 {
        let (sin, cos) = math::sin_cos(-angle_rad);
        turn::<Native>(bins, Packed::new((cos * Q15) as i16, (sin * Q15) as i16));
    }
}

/// Returns the last `count` words.
fn last(words: &mut [u32], count: usize) -> &mut [u32] {
    let first = words.len().saturating_sub(count);
    words.get_mut(first..).unwrap_or_default()
}

/// Returns ⌊weight · x / 2¹⁶⌋.
#[inline(always)]
fn scaled(weight: i32, x: i16) -> i32 {
    ((i64::from(weight) * i64::from(x)) >> PRODUCT_SHIFT) as i32
}

/// Returns ⌊4 log2(power)⌋ to a quarter octave, with the fraction interpolated linearly; 0 for no power.
#[inline(always)]
fn level(power: u32) -> i32 {
    let power = power | 1;
    let zeros = power.leading_zeros();
    let fraction = power << zeros << 1 >> 30;
    (4 * (31 - zeros) + fraction) as i32
}
