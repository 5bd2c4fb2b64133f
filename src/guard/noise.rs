//! The noise of a sweep: of few rows, nearly all of which see ground.

use crate::math;
use crate::signal::grid::{PolarMap, UNITS_PER_OCTAVE};

/// Cells so near to the line of the ground may show it, radians: 7°, three standard deviations of the paper's beam and more.
const OFF_RAD: f32 = 0.122;
/// Ranges that are looked at, metres: nearer the mirror shines, farther the receiver's filter falls.
const RANGES_M: core::ops::RangeInclusive<f32> = 0.45..=2.6;
/// Noise is told by this quantile of the cells off the ground, which echoes of other things do not reach …
const QUANTILE: f32 = 0.35;
/// … and which is this share of its mean: exponential, -ln(1 - 0.35).
const OF_MEAN: f32 = 0.4308;

/// Returns the mean noise of a sweep, map units; that of no power where all cells see ground.
#[inline(never)]
pub fn level(map: &PolarMap) -> f32 {
    let geometry = map.geometry();
    let mut counts = [0_u16; 256];
    let mut all = 0.0;
    for bin in 0..map.bins() {
        let range_m = geometry.range_m(bin as f32);
        if !RANGES_M.contains(&range_m) {
            continue;
        }
        let (first, end) = ground(map, range_m);
        for row in (0..first).chain(end..map.rows()) {
            // A row that was lost is all 0, which noise is not.
            if let Some(level) = map.row(row).get(bin).filter(|l| **l > 0)
                && let Some(count) = counts.get_mut(usize::from(*level))
            {
                *count = count.saturating_add(1);
                all += 1.0;
            }
        }
    }
    quantile(&counts, QUANTILE * all) - f32::from(UNITS_PER_OCTAVE) * math::log2(OF_MEAN)
}

/// The rows that see the ground at a range: the first, and the one behind the last.
fn ground(map: &PolarMap, range_m: f32) -> (usize, usize) {
    let geometry = map.geometry();
    let down = geometry.mount_height_m / range_m;
    // The ground is not seen as near as this.
    if down >= 1.0 {
        return (0, 0);
    }
    let line_rad = math::atan2(down, math::sqrt(1.0 - down * down)) - map.angle_rad(0);
    let step_rad = math::max(geometry.step_rad, f32::MIN_POSITIVE);
    // `as` saturates.
    let first = math::ceil((line_rad - OFF_RAD) / step_rad) as usize;
    let end = math::ceil((line_rad + OFF_RAD) / step_rad) as usize;
    (first.min(map.rows()), end.min(map.rows()))
}

/// The level below which so many of the cells are.
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
