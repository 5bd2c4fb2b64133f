//! What the map holds where there is nothing: the noise, and per range bin what beam side lobes add.

use super::MAX_BINS;

/// Most sampled rows.
pub const MAX_SAMPLES: usize = 12;

/// The filtered map at evenly spaced rows, in map units.
#[derive(Debug)]
pub struct NoiseSamples {
    rows: [[u8; MAX_BINS]; MAX_SAMPLES],
    count: usize,
}

impl NoiseSamples {
    /// Without samples.
    pub const fn new() -> Self {
        Self {
            rows: [[0; MAX_BINS]; MAX_SAMPLES],
            count: 0,
        }
    }

    /// Ready for a scan's first row.
    pub fn begin(&mut self) {
        self.count = 0;
    }

    /// Keeps a row's levels less the filter's `gain`.
    pub fn add(&mut self, levels: &[u16], gain: u16) {
        if let Some(row) = self.rows.get_mut(self.count) {
            for (kept, &level) in row.iter_mut().zip(levels) {
                let units = (level.saturating_sub(gain) + 8) >> 4;
                *kept = units.min(255) as u8;
            }
            self.count += 1;
        }
    }

    /// Medians over the angles, map units: per range bin into `floors`; returns the one over all.
    #[inline(never)]
    pub fn medians(&self, bins: usize, floors: &mut [u8; MAX_BINS]) -> f32 {
        let mut histogram = [0u16; 256];
        // Neighbouring bins share most of their echo: every second one will do.
        for (pair, floors) in floors.chunks_mut(2).enumerate().take(bins.div_ceil(2)) {
            let mut column = [0u8; MAX_SAMPLES];
            for (value, row) in column.iter_mut().zip(&self.rows) {
                *value = row.get(2 * pair).copied().unwrap_or(0);
            }
            let column = column.get_mut(..self.count).unwrap_or(&mut []);
            for &level in column.iter() {
                histogram[usize::from(level)] += 1;
            }
            column.sort_unstable();
            floors.fill(column.get(self.count / 3).copied().unwrap_or(0));
        }
        median(&histogram)
    }
}

/// Median of a histogram, interpolated within its bin; 0 for an empty one.
fn median(histogram: &[u16; 256]) -> f32 {
    let total: u32 = histogram.iter().map(|&n| u32::from(n)).sum();
    let half = total as f32 * 0.5;
    let mut below = 0.0;
    for (value, &n) in histogram.iter().enumerate() {
        let n = f32::from(n);
        if n > 0.0 && below + n >= half {
            return value as f32 - 0.5 + ((half - below) / n).clamp(0.0, 1.0);
        }
        below += n;
    }
    0.0
}
