//! Noise of the filtered map, and the level to which the antenna's side lobes raise it in each range bin.

use crate::signal::grid::MAX_BINS;

use super::angle_filter::UNITS_PER_CELL_BITS;

/// Maximum number of sampled rows: with them the lower third of a bin's samples is accurate to a decibel, and
/// they fit the memory.
pub const MAX_SAMPLES: usize = 12;
/// Reciprocal of the quantile of a range bin's samples that is its noise floor: a third, since echoes fill up
/// to two thirds of the angles at the range of a wall or a strong riser.
const SHARE: usize = 3;
/// Number of the smallest samples of a range bin that are kept; its noise floor is among them.
const LEAST: usize = MAX_SAMPLES / SHARE + 1;
/// Number of sampled rows from which one more moves the median of all samples by less than a decibel.
const SETTLED: usize = MAX_SAMPLES / 2;
/// Half a map unit (1/8 octave) in units of a filtered level (1/128 octave), for rounding.
const HALF_CELL: u16 = 1 << (UNITS_PER_CELL_BITS - 1);

/// Sampled levels of the filtered map at evenly spaced rows, without the filter's gain, map units (1/8 octave).
/// They are sorted during the scan, because time is short after the last row. Only every second bin is sampled:
/// neighbouring bins share most of their echo.
#[derive(Debug)]
pub struct NoiseSamples {
    /// Entry k: smallest samples of range bin 2k, which stand also for bin 2k + 1, ascending, map units.
    least: [[u8; LEAST]; MAX_BINS / 2],
    /// Number of samples of all bins and rows by their level: index k counts those of k map units.
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

    /// Adds a row's `levels` minus the filter's `gain`, both in 1/128 octave; no more than [`MAX_SAMPLES`]
    /// rows.
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

    /// Returns whether enough rows have been sampled for a stable median.
    pub fn settled(&self) -> bool {
        self.count >= SETTLED
    }

    /// Returns the noise floor of range bin `bin`, the quantile at one third of its sampled levels, map units; 0
    /// without samples.
    pub fn floor(&self, bin: usize) -> u8 {
        let least = self.least.get(bin / 2).filter(|_| self.count > 0);
        let floor = least.and_then(|least| least.get(self.count / SHARE));
        floor.copied().unwrap_or(0)
    }

    /// Returns the median of all sampled levels, map units, interpolated within a unit; `None` without samples.
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
