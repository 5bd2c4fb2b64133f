//! Mean noise power of a guard sweep, estimated from the cells that do not see ground. They are few: nearly every row
//! sees ground at some range.

use crate::math;
use crate::params::guard::QUANTILE;
use crate::signal::grid::{PolarMap, UNITS_PER_OCTAVE};

/// Maximum angle between a cell's line of sight and that to the ground at the same range at which the cell may still
/// show ground, radians: 7°, more than three standard deviations of the paper's beam.
const OFF_RAD: f32 = 0.122;
/// Ranges of the cells from which the noise is estimated, metres: nearer, the mirror's own echo dominates; farther, the
/// receiver's filter attenuates the noise.
const RANGES_M: core::ops::RangeInclusive<f32> = 0.45..=2.6;
/// Step between the counted range bins of a row, bins: the noise of neighbouring bins is alike, because they share the
/// window's main lobe.
const STRIDE: usize = 2;
/// Ratio of the 35 % quantile ([`QUANTILE`]) to the mean, for noise whose power is exponentially distributed:
/// -ln(1 - 0.35).
const OF_MEAN: f32 = 0.4308;

/// Returns the mean noise power of a sweep, map units; about 10, lower than any receiver's noise, if all cells see
/// ground.
#[inline(never)]
pub fn level(map: &PolarMap) -> f32 {
    let mut counts = [0_u16; 256];
    let (near, far) = (bin(map, *RANGES_M.start()), bin(map, *RANGES_M.end()));
    for row in 0..map.rows() {
        let (cells, angle_rad) = (map.row(row), map.angle_rad(row));
        // The ground shows between these ranges: nowhere where the row looks too far up, to the end where it does so partly.
        let first = meets(map, angle_rad + OFF_RAD).max(near).min(far);
        let end = meets(map, angle_rad - OFF_RAD).max(first).min(far);
        let before = cells.get(near..first).unwrap_or(&[]);
        let behind = cells.get(end..far.min(cells.len())).unwrap_or(&[]);
        let cells = before.iter().step_by(STRIDE);
        for level in cells.chain(behind.iter().step_by(STRIDE)) {
            if let Some(count) = counts.get_mut(usize::from(*level)) {
                *count = count.saturating_add(1);
            }
        }
    }
    // A row that was lost is all 0, which noise is not.
    let [lost, ..] = &mut counts;
    *lost = 0;
    let all: u32 = counts.iter().map(|n| u32::from(*n)).sum();
    quantile(&counts, QUANTILE * all as f32) - f32::from(UNITS_PER_OCTAVE) * math::log2(OF_MEAN)
}

/// Returns the first range bin of the map at or beyond a range from the mirror, metres.
#[inline(never)]
fn bin(map: &PolarMap, range_m: f32) -> usize {
    let geometry = map.geometry();
    // `as` saturates.
    math::ceil((range_m - geometry.first_range_m) / geometry.bin_m) as usize
}

/// Returns the range bin in which the line of sight at a beam angle, radians below the horizontal, meets level ground;
/// a bin beyond the map if it never does.
#[inline(never)]
fn meets(map: &PolarMap, angle_rad: f32) -> usize {
    let (sin, _) = math::sin_cos(angle_rad);
    let range_m = map.geometry().mount_height_m / math::max(sin, f32::MIN_POSITIVE);
    bin(map, range_m)
}

/// Returns the level, map units, below which the weakest `cells` of the counted cells lie, interpolated within a level;
/// `counts[k]` is the number of cells with level k.
fn quantile(counts: &[u16; 256], cells: f32) -> f32 {
    let mut below = 0.0;
    for (level, count) in counts.iter().enumerate() {
        let here = f32::from(*count);
        if here > 0.0 && below + here >= cells {
            // Within the level cells are spread evenly.
            return level as f32 - 0.5 + (cells - below) / here;
        }
        below += here;
    }
    0.0
}
