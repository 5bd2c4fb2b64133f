//! The matched filter along the angle, fed row by row while the mirror turns.
//!
//! A point scatterer shows up in neighbouring rows with the two-way beam's pattern. The best linear
//! filter against white noise has that very shape; two running boxes in a row (a triangle) come
//! within 0.1 dB of it and cost a few additions a cell (a cascaded integrator-comb filter, Hogenauer
//! 1981). All sums are whole numbers, so that nothing drifts and both ways of sweeping give the same
//! result to the last bit. The delayed rows are read back from the map; only the sums are kept here.

use super::MAX_BINS;
use crate::math;
use crate::stairs::map::{Geometry, PolarMap};

/// Longest box in rows: with it the sums of a uniform map of the largest power stay below 2³².
const MAX_BOX: usize = 15;
/// Units of a level in one octave of power.
pub const UNITS_PER_OCTAVE: f32 = 128.0;
/// Decibels of one unit of a level.
pub const LEVEL_DB: f32 = 3.010_3 / UNITS_PER_OCTAVE;

/// 2^(k/8) in Q32.
const EIGHTHS: [u64; 8] = [
    4_294_967_296,
    4_683_695_048,
    5_107_605_667,
    5_569_883_475,
    6_074_001_000,
    6_623_745_065,
    7_223_245_205,
    7_877_004_772,
];

/// Cell whose linear power counts 1: 15 dB above the map's zero, and still below the noise of any
/// receiver.
const UNIT_CELL: usize = 40;
/// Cells above this count as this: -5 dB of full scale, more than any echo has in a chirp that the
/// converter takes without clipping; then [`MAX_BOX`]² of them still fit 32 bits.
const LARGEST_CELL: usize = 233;

/// Linear power of every possible cell.
static POWER: [u32; 256] = power_table();

const fn power_table() -> [u32; 256] {
    let mut table = [0; 256];
    let mut cell = 0;
    while cell < 256 {
        let octaves8 = if cell < LARGEST_CELL {
            cell
        } else {
            LARGEST_CELL
        } + 24 * 8
            - UNIT_CELL;
        // Q32 times 2^24, rounded off again.
        let scaled = (EIGHTHS[octaves8 & 7] as u128) << (octaves8 >> 3);
        table[cell] = ((scaled + (1 << 55)) >> 56) as u32;
        cell += 1;
    }
    table
}

/// Linear power of a cell.
#[inline]
fn power(cell: u8) -> u32 {
    POWER[usize::from(cell)]
}

/// Standard deviation of the two-way power pattern exp(-8 ln2 (t/width)²) of a beam whose one-way
/// 3 dB width is `width`.
pub fn two_way_sigma(width: f32) -> f32 {
    // sqrt(16 ln 2)
    width / 3.330_218_4
}

/// Rows of one box so that two of them have the variance of the two-way beam; odd.
pub fn box_rows(geometry: &Geometry) -> usize {
    let sigma = two_way_sigma(geometry.beamwidth_rad) / math::max(geometry.step_rad, 1e-6);
    let rows = math::sqrt(6.0 * sigma * sigma + 1.0) + 0.5;
    ((rows as usize) | 1).min(MAX_BOX)
}

/// 128 log2(1 + f/128), rounded off.
static FRACTION: [u8; 128] = fraction_table();

const fn fraction_table() -> [u8; 128] {
    let mut table = [0; 128];
    let mut fraction = 0;
    while fraction < 128 {
        // log2(1 + f) ≈ f + 0.344 f (1 - f)
        let bend = (fraction * (128 - fraction) * 44) >> 14;
        table[fraction] = (fraction + bend) as u8;
        fraction += 1;
    }
    table
}

/// Binary logarithm of a filtered power in 1/128 octave; monotone, error below 0.01 octave.
#[inline]
pub fn level(power: u32) -> u16 {
    let power = power | 1;
    let zeros = power.leading_zeros();
    let fraction = ((power << zeros) >> 24) & 127;
    ((31 - zeros) << 7 | u32::from(FRACTION[fraction as usize])) as u16
}

/// The running sums of one range bin.
#[derive(Clone, Copy, Debug)]
struct Sums {
    slope: u32,
    sum: u32,
}

/// The running sums of all range bins.
#[derive(Debug)]
pub struct BeamFilter {
    sums: [Sums; MAX_BINS],
    rows: usize,
    fed: usize,
}

impl BeamFilter {
    /// Without any row yet.
    pub const fn new() -> Self {
        Self {
            sums: [Sums { slope: 0, sum: 0 }; MAX_BINS],
            rows: 1,
            fed: 0,
        }
    }

    /// Ready for a scan's first row.
    pub fn begin(&mut self, geometry: &Geometry) {
        self.rows = box_rows(geometry);
        self.fed = 0;
    }

    /// Rows by which the output lags the input.
    pub fn lag(&self) -> usize {
        self.rows - 1
    }

    /// Level of a uniform map whose cells are 0, were it not rounded off.
    pub fn gain(&self) -> u16 {
        let unit = (UNIT_CELL as u16) << 4;
        level((self.rows * self.rows) as u32).saturating_sub(unit)
    }

    /// Adds the next row and writes the levels of the row `lag` before it to `levels`; what lies
    /// before the first row is taken to be like it. `delayed` looks rows back.
    pub fn feed<'m>(
        &mut self,
        row: &[u8],
        delayed: impl Fn(usize) -> &'m [u8],
        levels: &mut [u16],
    ) {
        if self.fed == 0 {
            let rows = self.rows as u32;
            for (sums, &cell) in self.sums.iter_mut().zip(row) {
                *sums = Sums {
                    slope: 0,
                    sum: power(cell) * rows * rows,
                };
            }
        }
        let one = delayed(self.fed.min(self.rows));
        let two = delayed(self.fed.min(2 * self.rows));
        let cells = row.iter().zip(one).zip(two);
        for ((((&new, &one), &two), sums), level_out) in cells.zip(&mut self.sums).zip(levels) {
            let change = power(new)
                .wrapping_add(power(two))
                .wrapping_sub(power(one) << 1);
            let slope = sums.slope.wrapping_add(change);
            let sum = sums.sum.wrapping_add(slope);
            *sums = Sums { slope, sum };
            *level_out = level(sum);
        }
        self.fed += 1;
    }
}

/// Rows of a [`Patch`], relative to its middle.
pub const PATCH_ROWS: [i8; 5] = [-3, -2, 0, 2, 3];
/// Bins of a [`Patch`], relative to its middle.
pub const PATCH_BINS: [i8; 3] = [-1, 0, 1];
/// Rows to each side of a patch's middle.
const REACH: usize = 3;
/// Levels of the filtered map around a place, [bin][row].
pub type Patch = [[u16; PATCH_ROWS.len()]; PATCH_BINS.len()];

/// The filtered map around one place, worked out again from the map itself.
#[inline(never)]
pub fn patch(map: &PolarMap, row: u16, bin: u8) -> Patch {
    /// Rows that the longest filter sees from a patch, and the two empty sums before them.
    const SEEN: usize = 2 * (MAX_BOX + REACH) + 1;
    let rows = box_rows(map.geometry());
    let first = i32::from(row) - (rows - 1 + REACH) as i32;
    let last = map.rows().saturating_sub(1) as i32;
    let mut patch = Patch::default();
    // A maximum has a bin to each side.
    let start = usize::from(bin).saturating_sub(1);
    let Some(cells) = map.from(first.min(last).max(0) as usize, start) else {
        return patch;
    };
    // Two boxes are the second difference, a box apart, of what is summed up twice.
    let mut twice = [[0u32; PATCH_BINS.len()]; SEEN];
    let ([mut slope0, mut slope1, mut slope2], [mut sum0, mut sum1, mut sum2]) =
        ([0u32; 3], [0u32; 3]);
    let mut k = 0;
    let seen = 2 * (rows + REACH) - 1;
    for (at, twice) in (first..).zip(twice.iter_mut().skip(2).take(seen)) {
        let Some(&[near, middle, far]) = cells.get(k..).and_then(|rest| rest.first_chunk()) else {
            break;
        };
        slope0 = slope0.wrapping_add(power(near));
        slope1 = slope1.wrapping_add(power(middle));
        slope2 = slope2.wrapping_add(power(far));
        sum0 = sum0.wrapping_add(slope0);
        sum1 = sum1.wrapping_add(slope1);
        sum2 = sum2.wrapping_add(slope2);
        *twice = [sum0, sum1, sum2];
        // What lies beyond the first and the last row is like them.
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
