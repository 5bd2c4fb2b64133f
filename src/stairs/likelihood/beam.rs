//! The matched filter along the angle, fed row by row while the mirror turns.
//!
//! A point scatterer shows up in neighbouring rows with the two-way beam's pattern. The best linear
//! filter against white noise has that very shape; two running boxes in a row (a triangle) come
//! within 0.1 dB of it and cost a few additions a cell (a cascaded integrator-comb filter, Hogenauer
//! 1981). All sums are whole numbers, so that nothing drifts and both ways of sweeping give the same
//! result to the last bit. The delayed rows are read back from the map; only the sums are kept here.

use super::MAX_BINS;
use crate::stairs::map::Geometry;

/// Longest box in rows: bounds the sums to 2⁴⁴.
const MAX_BOX: usize = 63;
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

/// Linear power of every possible cell, in units of the map's reference.
static POWER: [u32; 256] = power_table();

const fn power_table() -> [u32; 256] {
    let mut table = [0; 256];
    let mut cell = 1;
    while cell < 256 {
        let scaled = EIGHTHS[cell & 7] << (cell >> 3);
        table[cell] = ((scaled + (1 << 31)) >> 32) as u32;
        cell += 1;
    }
    table
}

/// Linear power of a cell, in units of the map's reference.
#[inline]
pub fn power(cell: u8) -> u32 {
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
    let sigma = two_way_sigma(geometry.beamwidth_rad) / geometry.step_rad.max(1e-6);
    let rows = crate::math::sqrt(6.0 * sigma * sigma + 1.0) + 0.5;
    ((rows as usize) | 1).min(MAX_BOX)
}

/// Binary logarithm of a filtered power in 1/128 octave; monotone, error below 0.01 octave.
#[inline]
pub fn level(power: u64) -> u16 {
    let power = power | 1;
    let exponent = 63 - power.leading_zeros();
    let fraction = ((power << (63 - exponent)) >> 56) as u32 & 127;
    // log2(1 + f) ≈ f + 0.344 f (1 - f)
    let bend = (fraction * (128 - fraction) * 44) >> 14;
    ((exponent << 7) + fraction + bend) as u16
}

/// The running sums of all range bins.
#[derive(Debug)]
pub struct BeamFilter {
    slope: [u64; MAX_BINS],
    sum: [u64; MAX_BINS],
    rows: usize,
    fed: usize,
}

impl BeamFilter {
    /// Without any row yet.
    pub const fn new() -> Self {
        Self {
            slope: [0; MAX_BINS],
            sum: [0; MAX_BINS],
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

    /// Level that the filter adds to a uniform map of the level 0.
    pub fn gain(&self) -> u16 {
        level((self.rows * self.rows) as u64)
    }

    /// Adds the next row and writes the levels of the row `lag` before it to `levels`; what lies
    /// before the first row is taken to be like it. `delayed` looks rows back.
    pub fn feed<'m>(
        &mut self,
        row: &[u8],
        delayed: impl Fn(usize) -> &'m [u8],
        levels: &mut [u16],
    ) {
        let (slope, sum) = (self.slope.iter_mut(), self.sum.iter_mut());
        if self.fed == 0 {
            let rows = self.rows as u64;
            for (((&cell, slope), sum), level_out) in row.iter().zip(slope).zip(sum).zip(levels) {
                let power = u64::from(power(cell));
                *slope = 0;
                *sum = power * rows * rows;
                *level_out = level(*sum);
            }
        } else {
            let one = delayed(self.fed.min(self.rows));
            let two = delayed(self.fed.min(2 * self.rows));
            let cells = row.iter().zip(one).zip(two);
            for ((((new, one), two), (slope, sum)), level_out) in
                cells.zip(slope.zip(sum)).zip(levels)
            {
                let change = u64::from(power(*new))
                    .wrapping_add(u64::from(power(*two)))
                    .wrapping_sub(2 * u64::from(power(*one)));
                *slope = slope.wrapping_add(change);
                *sum = sum.wrapping_add(*slope);
                *level_out = level(*sum);
            }
        }
        self.fed += 1;
    }
}
