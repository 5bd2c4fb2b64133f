//! Noise of the filtered map, and the level to which the antenna's side lobes raise it in each range bin.

use crate::signal::grid::MAX_BINS;

use super::angle_filter::UNITS_PER_CELL_BITS;

/// Maximum number of sampled rows: with these their lower third is accurate to a decibel, and they fit the
/// memory.
pub const MAX_SAMPLES: usize = 12;
/// Reciprocal of the quantile of a bin's samples that is its floor: a third, since echoes fill up to two thirds
/// of the angles at the range of a wall or a strong riser.
const SHARE: usize = 3;
/// Number of the smallest samples of a bin that are kept; its floor is among them.
const LEAST: usize = MAX_SAMPLES / SHARE + 1;
/// Number of samples from which one more moves their median by less than a decibel.
const SETTLED: usize = MAX_SAMPLES / 2;
/// Half a map unit in the unit of a level, for rounding.
const HALF_CELL: u16 = 1 << (UNITS_PER_CELL_BITS - 1);

/// Samples of the filtered map at evenly spaced rows, map units. They are sorted during the scan, because time
/// is short after the last row. Only every second bin is sampled: neighbouring bins share most of their echo.
#[derive(Debug)]
pub struct NoiseSamples {
    /// Smallest samples of each pair of bins, in ascending order.
    least: [[u8; LEAST]; MAX_BINS / 2],
    /// Histogram of all samples, by map units.
    histogram: [u16; 1 << u8::BITS],
    count: usize,
}

impl NoiseSamples {
    /// Empty, without samples.
    pub const fn new() -> Self {
        Self {
            least: [[0; LEAST]; MAX_BINS / 2],
            histogram: [0; 1 << u8::BITS],
            count: 0,
        }
    }

    /// Prepares for the first row of a scan.
    pub fn begin(&mut self) {
        self.least.as_flattened_mut().fill(u8::MAX);
        self.histogram.fill(0);
        self.count = 0;
    }

    /// Adds a row's levels minus the filter's `gain`.
    pub fn add(&mut self, levels: &[u16], gain: u16) {
        if self.count == MAX_SAMPLES {
            return;
        }
        for (least, &level) in self.least.iter_mut().zip(levels.iter().step_by(2)) {
            let units = (level.saturating_sub(gain) + HALF_CELL) >> UNITS_PER_CELL_BITS;
            let mut units = units.min(u8::MAX.into()) as u8;
            if let Some(number) = self.histogram.get_mut(usize::from(units)) {
                *number += 1;
            }
            for kept in least {
                if units < *kept {
                    core::mem::swap(kept, &mut units);
                }
            }
        }
        self.count += 1;
    }

    /// Returns whether there are enough samples for a stable median.
    pub fn settled(&self) -> bool {
        self.count >= SETTLED
    }

    /// Returns the lower third of the sampled levels in range bin `bin`, map units.
    pub fn floor(&self, bin: usize) -> u8 {
        let least = self.least.get(bin / 2).filter(|_| self.count > 0);
        let floor = least.and_then(|least| least.get(self.count / SHARE));
        floor.copied().unwrap_or(0)
    }

    /// Returns the median of all samples, interpolated within its map unit; `None` without samples.
    pub fn median(&self) -> Option<f32> {
        let total: u32 = self.histogram.iter().map(|&n| u32::from(n)).sum();
        let half = total as f32 * 0.5;
        let mut below = 0.0;
        for (value, &n) in self.histogram.iter().enumerate() {
            let n = f32::from(n);
            if n > 0.0 && below + n >= half {
                return Some(value as f32 - 0.5 + ((half - below) / n).clamp(0.0, 1.0));
            }
            below += n;
        }
        None
    }
}
