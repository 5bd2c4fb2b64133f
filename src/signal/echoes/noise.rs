//! The noise of the filtered map, and per range bin the level to which the antenna's side lobes raise
//! it.

use crate::signal::grid::MAX_BINS;

use super::angle_filter::UNITS_PER_CELL_BITS;

/// Most sampled rows: enough that a third of them is known to a decibel, few enough to keep.
pub const MAX_SAMPLES: usize = 12;
/// One in so many samples of a bin is below its floor: a third, since echoes fill up to two thirds
/// of the angles at the range of a wall or a bright riser.
const SHARE: usize = 3;
/// Least samples of a bin that are kept: its floor is among them.
const LEAST: usize = MAX_SAMPLES / SHARE + 1;
/// From so many samples on one more moves their median by less than a decibel.
const SETTLED: usize = MAX_SAMPLES / 2;
/// Half a unit of a cell, to round a level to cells.
const HALF_CELL: u16 = 1 << (UNITS_PER_CELL_BITS - 1);

/// The filtered map at evenly spaced rows, in map units, sorted as it comes: after the last row
/// there is no time for it. Neighbouring bins share most of their echo: every second one will do.
#[derive(Debug)]
pub struct NoiseSamples {
    /// Per pair of bins its least samples, in ascending order.
    least: [[u8; LEAST]; MAX_BINS / 2],
    /// How often each level came up.
    histogram: [u16; 1 << u8::BITS],
    count: usize,
}

impl NoiseSamples {
    /// Without samples.
    pub const fn new() -> Self {
        Self {
            least: [[0; LEAST]; MAX_BINS / 2],
            histogram: [0; 1 << u8::BITS],
            count: 0,
        }
    }

    /// Ready for a scan's first row.
    pub fn begin(&mut self) {
        self.least.as_flattened_mut().fill(u8::MAX);
        self.histogram.fill(0);
        self.count = 0;
    }

    /// Keeps a row's levels less the filter's `gain`.
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

    /// Whether there are enough samples for their median to stay about where it is.
    pub fn settled(&self) -> bool {
        self.count >= SETTLED
    }

    /// The level that a third of the sampled angles stay below in range bin `bin`, map units.
    pub fn floor(&self, bin: usize) -> u8 {
        let least = self.least.get(bin / 2).filter(|_| self.count > 0);
        let floor = least.and_then(|least| least.get(self.count / SHARE));
        floor.copied().unwrap_or(0)
    }

    /// Median of all samples, interpolated within its level, map units; none without any.
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
