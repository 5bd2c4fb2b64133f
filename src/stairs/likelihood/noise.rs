//! What the map holds where there is nothing: the noise, and per range bin what beam side lobes add.

use super::MAX_BINS;

/// Most sampled rows.
pub const MAX_SAMPLES: usize = 12;
/// Of so many samples of a bin, this share is what its floor leaves below.
const SHARE: usize = 3;
/// Least samples of a bin that are kept: its floor is among them.
const LEAST: usize = MAX_SAMPLES / SHARE + 1;

/// The filtered map at evenly spaced rows, in map units, sorted as it comes: after the last row
/// there is no time for it. Neighbouring bins share most of their echo: every second one will do.
#[derive(Debug)]
pub struct NoiseSamples {
    /// Per pair of bins its least samples, in ascending order.
    least: [[u8; LEAST]; MAX_BINS / 2],
    /// How often each level came up.
    histogram: [u16; 256],
    count: usize,
}

impl NoiseSamples {
    /// Without samples.
    pub const fn new() -> Self {
        Self {
            least: [[0; LEAST]; MAX_BINS / 2],
            histogram: [0; 256],
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
            let units = (level.saturating_sub(gain) + 8) >> 4;
            let mut units = units.min(255) as u8;
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

    /// Medians over the angles, map units: per range bin into `floors`; returns the one over all.
    #[inline(never)]
    pub fn medians(&self, floors: &mut [u8; MAX_BINS]) -> f32 {
        if self.count > 0 {
            for (floors, least) in floors.chunks_mut(2).zip(&self.least) {
                floors.fill(least.get(self.count / SHARE).copied().unwrap_or(0));
            }
        }
        self.median().unwrap_or(0.0)
    }

    /// Median of all samples, interpolated within its level; none without any.
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
