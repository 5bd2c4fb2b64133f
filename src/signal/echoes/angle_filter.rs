//! Matched filter along the angle, fed row by row while the mirror turns.
//!
//! A point scatterer appears in neighbouring rows with the two-way beam's pattern. The optimal linear filter
//! against white noise has the same shape. Two running boxes in series (a triangle) come within 0.1 dB of it
//! and need a few additions per cell (a cascaded integrator-comb filter, Hogenauer 1981). All sums are
//! integers, so there is no drift, and both sweep directions give identical results. The delayed rows are read
//! from the map; only the sums are stored here.

use crate::math;
use crate::signal::grid::{EIGHTHS, Geometry, MAX_BINS, PolarMap};

/// Maximum length of each of the filter's two running boxes, rows: with it the sums over a uniform map of
/// maximum power stay below 2³².
pub const MAX_BOX: usize = 15;
/// Resolution of a filtered level: units per octave of power.
const UNITS_PER_OCTAVE: usize = 128;
/// Decibels per unit of a filtered level (1/128 octave): 0.024.
pub const LEVEL_DB: f32 = math::DB_PER_OCTAVE / UNITS_PER_OCTAVE as f32;
/// Number of bits by which a cell of the map (1/8 octave) is shifted to the finer unit of a filtered level
/// (1/128 octave).
pub const UNITS_PER_CELL_BITS: u32 = 4;

/// Cell value whose linear power is 1: 15 dB above the map's zero, and still below the noise of any receiver.
const UNIT_CELL: usize = 40;
/// Maximum cell value that is distinguished: -5 dB of full scale, more than any echo of a chirp without
/// clipping. [`MAX_BOX`]² of these still fit 32 bits.
const LARGEST_CELL: usize = 233;

/// Linear power of every cell value: 2^((cell - [`UNIT_CELL`]) / 8), rounded. Computed in Q32 and 24 octaves
/// higher, so that small powers keep their precision until they are rounded.
static POWER: [u32; 256] = {
    let mut table = [0; 256];
    let mut cell = 0;
    while cell < 256 {
        let octaves8 = if cell < LARGEST_CELL {
            cell
        } else {
            LARGEST_CELL
        } + 24 * 8
            - UNIT_CELL;
        let scaled = (EIGHTHS[octaves8 & 7] as u128) << (octaves8 >> 3);
        table[cell] = ((scaled + (1 << 55)) >> 56) as u32;
        cell += 1;
    }
    table
};

/// Returns the linear power of a cell's value; 1 at [`UNIT_CELL`].
#[inline]
fn power(cell: u8) -> u32 {
    POWER[usize::from(cell)]
}

/// Ratio of the one-way 3 dB width to the standard deviation of the two-way power pattern exp(-8 ln2
/// (t/width)²) over the angle t: sqrt(16 ln 2).
const WIDTH_PER_SIGMA: f32 = 3.330_218_4;

/// Returns the standard deviation of the two-way power pattern of a beam whose one-way 3 dB width is `width`,
/// in the same unit of angle.
pub fn two_way_sigma(width: f32) -> f32 {
    width / WIDTH_PER_SIGMA
}

/// Returns the standard deviation in angle of a point scatterer's lobe after the filter, radians.
pub fn lobe_sigma_rad(geometry: &Geometry) -> f32 {
    // Pattern and filter have the same shape.
    two_way_sigma(geometry.beamwidth_rad) * core::f32::consts::SQRT_2
}

/// Factor of 6 between n² - 1 and the variance of two boxes of n rows in series: one box has `(n² - 1) / 12`,
/// two have `(n² - 1) / 6`.
const BOXES_PER_VARIANCE: f32 = 6.0;

/// Returns the number of rows of each box, at most [`MAX_BOX`], for which two boxes in series have the variance
/// of the two-way beam; odd.
pub fn box_rows(geometry: &Geometry) -> usize {
    let sigma = two_way_sigma(geometry.beamwidth_rad) / geometry.step_rad.max(f32::MIN_POSITIVE);
    // The cast saturates.
    let rows = math::sqrt(BOXES_PER_VARIANCE * sigma * sigma + 1.0) + 0.5;
    ((rows as usize) | 1).min(MAX_BOX)
}

/// Returns the width of a point scatterer's lobe after the filter, in units of [`lobe_sigma_rad`]: 1, or less
/// if the boxes are limited to [`MAX_BOX`] and therefore shorter than the beam is wide.
pub fn point_width(geometry: &Geometry) -> f32 {
    let rows = box_rows(geometry) as f32;
    let boxes = (rows * rows - 1.0) / BOXES_PER_VARIANCE * geometry.step_rad * geometry.step_rad;
    let sigma = two_way_sigma(geometry.beamwidth_rad);
    math::sqrt(0.5 * (1.0 + math::min(boxes / (sigma * sigma), 1.0)))
}

/// Number of low bits of a filtered level that count the fraction of an octave.
const FRACTION_BITS: u32 = UNITS_PER_OCTAVE.trailing_zeros();

/// Entry f: 128 log2(1 + x) for x = f / 128, approximated by 128 (x + 0.344 x (1 - x)), where 0.344 is 44/128.
static FRACTION: [u8; UNITS_PER_OCTAVE] = {
    let mut table = [0; UNITS_PER_OCTAVE];
    let mut fraction = 0;
    while fraction < UNITS_PER_OCTAVE {
        let bend = (fraction * (128 - fraction) * 44) >> 14;
        table[fraction] = (fraction + bend) as u8;
        fraction += 1;
    }
    table
};

/// Returns the binary logarithm of a filtered linear power, 1/128 octave (128 for each doubling of power); monotonic,
/// error below 0.01 octave.
#[inline]
pub fn level(power: u32) -> u16 {
    let power = power | 1;
    let zeros = power.leading_zeros();
    // Bits after the leading one.
    let fraction = (power << zeros << 1) >> (u32::BITS - FRACTION_BITS);
    let octaves = u32::BITS - 1 - zeros;
    (octaves << FRACTION_BITS | u32::from(FRACTION[fraction as usize])) as u16
}

/// State of the two running boxes in one range bin: the filter's output (`sum`, linear power), and its change
/// from row to row (`slope`).
#[derive(Clone, Copy, Debug)]
struct BinSums {
    slope: u32,
    sum: u32,
}

/// Matched filter over the rows for each range bin, with its running sums.
#[derive(Debug)]
pub struct AngleFilter {
    sums: [BinSums; MAX_BINS],
    rows: usize,
    fed: usize,
}

impl AngleFilter {
    /// Creates a filter that has received no row.
    pub const fn new() -> Self {
        Self {
            sums: [BinSums { slope: 0, sum: 0 }; MAX_BINS],
            rows: 1,
            fed: 0,
        }
    }

    /// Prepares for the first row of a scan with the beamwidth and angle step of `geometry`.
    pub fn begin(&mut self, geometry: &Geometry) {
        self.rows = box_rows(geometry);
        self.fed = 0;
    }

    /// Returns the number of rows by which the output lags the input.
    pub fn lag(&self) -> usize {
        self.rows - 1
    }

    /// Returns the filter's gain for uniform power, such as the mean noise, 1/128 octave of power: its output for a
    /// uniform map whose cells are 0, if powers were not rounded; 0 where that would be negative (boxes of up to 5
    /// rows).
    pub fn gain(&self) -> u16 {
        let unit = (UNIT_CELL as u16) << UNITS_PER_CELL_BITS;
        level((self.rows * self.rows) as u32).saturating_sub(unit)
    }

    /// Adds the next row, and writes the levels (1/128 octave) of the row [`AngleFilter::lag`] before it to
    /// `levels`. Rows before the first one are assumed to be equal to it. `delayed(n)` returns the cells of the
    /// row that was fed n rows before this one.
    pub fn feed<'m>(
        &mut self,
        row: &[u8],
        delayed: impl Fn(usize) -> &'m [u8],
        levels: &mut [u16],
    ) {
        if self.fed == 0 {
            let rows = self.rows as u32;
            for (sums, &cell) in self.sums.iter_mut().zip(row) {
                *sums = BinSums {
                    slope: 0,
                    sum: power(cell) * rows * rows,
                };
            }
        }
        let mut one = delayed(self.fed.min(self.rows)).iter();
        let mut two = delayed(self.fed.min(2 * self.rows)).iter();
        // A zip of all five would be unrolled and slower by a sixth.
        for ((&new, sums), level_out) in row.iter().zip(&mut self.sums).zip(levels) {
            let (Some(&one), Some(&two)) = (one.next(), two.next()) else {
                break;
            };
            let change = power(new)
                .wrapping_add(power(two))
                .wrapping_sub(power(one) << 1);
            let slope = sums.slope.wrapping_add(change);
            let sum = sums.sum.wrapping_add(slope);
            *sums = BinSums { slope, sum };
            *level_out = level(sum);
        }
        self.fed += 1;
    }
}

/// Offsets of a [`Patch`]'s rows from its middle one. With steps of 0.25° they extend 0.75° to each side, half
/// the standard deviation of the two-way beam.
pub const PATCH_ROWS: [i8; 5] = [-3, -2, 0, 2, 3];
/// Offsets of a [`Patch`]'s range bins from its middle one.
pub const PATCH_BINS: [i8; 3] = [-1, 0, 1];
/// Extent of a patch to each side of its middle, rows.
const REACH: usize = 3;
/// Number of double sums that [`patch`] holds: one for each row that the longest filter needs, after two zeros.
const SEEN: usize = 2 * (MAX_BOX + REACH) + 1;
/// Filtered levels around a cell, 1/128 octave: `[b][r]` is at bin offset `PATCH_BINS[b]` and row offset
/// `PATCH_ROWS[r]`.
pub type Patch = [[u16; PATCH_ROWS.len()]; PATCH_BINS.len()];

/// Returns the filtered levels around the cell (`row`, `bin`), computed anew from the unfiltered cells of
/// `map`.
#[inline(never)]
pub fn patch(map: &PolarMap, row: usize, bin: usize) -> Patch {
    let rows = box_rows(map.geometry());
    let first = row as i32 - (rows - 1 + REACH) as i32;
    let last = map.rows().saturating_sub(1) as i32;
    let mut patch = Patch::default();
    // A maximum has a bin on each side.
    let start = bin.saturating_sub(1);
    let Some(cells) = map.from(first.min(last).max(0) as usize, start) else {
        return patch;
    };
    // Two boxes in series are the second difference, at distances of a box, of the double sum.
    let mut twice = [[0u32; PATCH_BINS.len()]; SEEN];
    let mut slopes = [0u32; PATCH_BINS.len()];
    let mut sums = [0u32; PATCH_BINS.len()];
    let mut k = 0;
    let seen = 2 * (rows + REACH) - 1;
    for (at, twice) in (first..).zip(twice.iter_mut().skip(2).take(seen)) {
        let cells = cells.get(k..).unwrap_or(&[]);
        for ((&cell, slope), sum) in cells.iter().zip(&mut slopes).zip(&mut sums) {
            *slope = slope.wrapping_add(power(cell));
            *sum = sum.wrapping_add(*slope);
        }
        *twice = sums;
        // Rows beyond the first and the last one are assumed to be equal to it.
        if (0..last).contains(&at) {
            k += map.bins();
        }
    }
    for (k, offset) in PATCH_ROWS.into_iter().enumerate() {
        let from = REACH.wrapping_add_signed(offset.into());
        let at = |boxes: usize| twice.get(from + boxes * rows).copied().unwrap_or_default();
        let ends = at(2).into_iter().zip(at(1)).zip(at(0));
        for (levels, ((end, middle), start)) in patch.iter_mut().zip(ends) {
            if let Some(out) = levels.get_mut(k) {
                *out = level(end.wrapping_sub(middle << 1).wrapping_add(start));
            }
        }
    }
    patch
}
