//! Check that the mirror turns as commanded: echoes change with the angle as the beamwidth makes them.
//!
//! A scatterer's level follows the beam. Two rows two fifths of a beamwidth apart differ by several decibels,
//! neighbouring rows by little. A map that stays equal over this lag for longer than a main lobe's peak lasts
//! shows a mirror that stands still. A change between neighbouring rows that is too large shows rows at wrong
//! angles. A line at one range through all angles does not come by way of the mirror: something transmits, or
//! stands right before it.
//!
//! Rows are compared as they arrive, cell by cell where CA-CFAR has a detection in either.

use super::check::{CheckResult, units};
use crate::config::Config;
use crate::math;
use crate::params::image::SKIRT;
use crate::params::{Numbers, Params};
use crate::signal::grid::{Geometry, PolarMap};
use crate::verdict::Reason;

/// Distance in rows at which the rows around a compared pair are looked up. A null of the antenna pattern is narrower,
/// so cells that are much stronger there lie in a null.
const AROUND: usize = 4;
/// Beamwidth for which the limit `jump_db` is given, rows.
const REFERENCE_BEAM: f32 = 20.0;
/// Row interval of the standstill check: every other row. These are not the rows of the noise histogram.
const STILL_ROWS: u16 = 2;
/// Number of steps per beamwidth in which the length of a standstill is reported.
const PER_BEAM: f32 = 100.0;
/// Row interval of the search for lines: range bins whose level is the same at all angles.
const LINE_ROWS: usize = 8;
/// Row interval of the quick test whether a bin can have a line, ahead of the search over more rows.
const FEW_LINE_ROWS: usize = 32;
/// Factor from fractions to per cent.
const PER_CENT: usize = 100;

/// Checks of the mirror's turning: state gathered from the rows of one scan so far.
#[derive(Clone, Debug)]
pub struct Turning {
    /// Number of rows that arrived (modulo 65536), and index of the row before.
    rows: u16,
    before: u16,
    /// Number of consecutive rows that have nearly the same levels as the row `still_lag_beams` beamwidths before them,
    /// and its maximum in this scan.
    still_rows: u16,
    max_still_rows: u16,
    /// Maximum over the scan of the level difference of two neighbouring rows beyond the usual one, summed over cells,
    /// map units for a beamwidth of [`REFERENCE_BEAM`].
    max_difference: u16,
    /// Range bin of the strongest cell of the two neighbouring rows that were compared last.
    strongest: u8,
    numbers: Numbers,
}

/// A cell (range bin) compared between two rows, which exceeds the noise clearly in at least one of them: its bin, the
/// stronger level and the difference of levels, clipped at `jump_clip_db`, map units.
#[derive(Clone, Copy)]
struct Pair {
    bin: u8,
    stronger: u8,
    difference: u8,
}

/// Maximum number of compared cells of two rows: a row shows a dozen echoes of four cells; further cells are left out.
const MAX_PAIRS: usize = 32;

/// Compared cells of two rows.
struct Pairs {
    list: heapless::Vec<Pair, MAX_PAIRS>,
    /// Sum of the level differences of all pairs, map units.
    sum: u32,
    strongest: Pair,
}

impl Pairs {
    /// Collects the cells whose level exceeds `floor`, map units, in at least one of two rows; `cells` gives bin, level
    /// in the one row and level in the other.
    fn of(cells: impl Iterator<Item = (usize, u8, u8)>, floor: u8, p: &Params) -> Self {
        let mut pairs = Self {
            list: heapless::Vec::new(),
            sum: 0,
            strongest: Pair {
                bin: 0,
                stronger: 0,
                difference: 0,
            },
        };
        for (bin, a, b) in cells {
            let stronger = a.max(b);
            if stronger <= floor {
                continue;
            }
            let pair = Pair {
                bin: bin as u8,
                stronger,
                difference: a.abs_diff(b).min(units(p.jump_clip_db) as u8),
            };
            if pairs.list.push(pair).is_err() {
                break;
            }
            pairs.sum += u32::from(pair.difference);
            if stronger > pairs.strongest.stronger {
                pairs.strongest = pair;
            }
        }
        pairs
    }
}

/// Returns whether row `k` was received and was not left out of the map.
fn has_cells(map: &PolarMap, k: usize) -> bool {
    map.present(k) && map.row(k).iter().any(|&cell| cell > 0)
}

/// Returns the beamwidth, rows.
fn beam(geometry: &Geometry) -> f32 {
    geometry.beamwidth_rad / geometry.step_rad.max(f32::MIN_POSITIVE)
}

impl Turning {
    pub const fn new(numbers: Numbers) -> Self {
        Self {
            rows: 0,
            before: 0,
            still_rows: 0,
            max_still_rows: 0,
            max_difference: 0,
            strongest: 0,
            numbers,
        }
    }

    /// Adds row `k` of `map` to the checks; `noise` is the running mean of the rows' lower quartiles, and `skirt` the level
    /// of the mirror's own echo in other bins, which no turning changes, map units. Returns the range bin of the strongest
    /// cell of the two neighbouring rows that were compared last.
    #[inline(never)]
    pub fn row(&mut self, map: &PolarMap, k: u16, [noise, skirt]: [i32; 2]) -> u8 {
        let p = self.numbers.get();
        let up = k >= self.before;
        self.before = k;
        let back = |rows: usize| {
            let k = usize::from(k);
            let at = if up {
                k.checked_sub(rows)
            } else {
                k.checked_add(rows)
            };
            at.filter(|&at| has_cells(map, at))
        };
        let Some(here) = back(0) else {
            return self.strongest;
        };
        let floor = (noise + units(p.turning_db)).max(skirt);
        let floor = floor.clamp(0, u8::MAX.into()) as u8;
        let beam = beam(map.geometry());
        self.rows = self.rows.wrapping_add(1);
        // The cast saturates.
        let lag = ((p.still_lag_beams * beam + 0.5) as usize).max(2);
        // Every other row suffices for a standstill.
        if let Some(old) = back(lag).filter(|_| self.rows % STILL_ROWS == 1) {
            let before = map.row(old);
            // Every other cell suffices, too.
            let hits = map.detections(here).step_by(2);
            let both = hits.filter_map(|(bin, now)| Some((bin, *before.get(bin)?, now)));
            let Pairs { list, sum, .. } = Pairs::of(both, floor, p);
            let unmoved = list.len() >= p.still_cells as usize
                && sum < units(p.still_db) as u32 * list.len() as u32;
            self.still_rows = if unmoved {
                self.still_rows + STILL_ROWS
            } else {
                0
            };
            self.max_still_rows = self.max_still_rows.max(self.still_rows);
        }
        if let (Some(a), Some(b)) = (back(AROUND + 1), back(AROUND)) {
            self.compare_neighbours(map, [a, b], floor, beam);
        }
        self.strongest
    }

    /// Updates the maximum difference from two neighbouring rows `a` and `b`, whose surrounding rows have arrived as
    /// well: cells above `floor`, map units, that do not lie in a null. `beam` is the beamwidth, rows.
    fn compare_neighbours(&mut self, map: &PolarMap, [a, b]: [usize; 2], floor: u8, beam: f32) {
        let p = self.numbers.get();
        // The flanks of a narrow beam are steeper.
        let scale = (REFERENCE_BEAM / beam.max(1.0)).max(1.0);
        let steepest = (f32::from(self.max_difference) * scale) as u32;
        let found = Pairs::of(map.detections_of(a, b), floor, p);
        if found.sum > 0 {
            self.strongest = found.strongest.bin;
        }
        // Only a difference above the maximum so far needs the surrounding rows.
        if found.sum <= steepest {
            return;
        }
        let near = units(p.jump_near_db) as u8;
        let around = [
            a.min(b).checked_sub(AROUND).map_or(&[][..], |k| map.row(k)),
            map.row(a.max(b) + AROUND),
        ];
        let (mut cells, mut differ) = (0u32, 0u32);
        for pair in &found.list {
            // A cell in a null changes in any case.
            let limit = pair.stronger.saturating_add(near);
            let below = |row: &&[u8]| row.get(usize::from(pair.bin)).is_none_or(|&x| x <= limit);
            if around.iter().all(below) {
                cells += 1;
                differ += u32::from(pair.difference);
            }
        }
        if cells >= p.jump_cells as u32 {
            let usual = units(p.jump_usual_db) as u32 * cells;
            let beyond = (differ as f32 / scale) as u32;
            self.max_difference = self.max_difference.max(beyond.saturating_sub(usual) as u16);
        }
    }

    /// Calls `each` with the results of two checks: the longest standstill, 1/100 beamwidth, and the largest jump of
    /// the angle, map units.
    pub fn report_checks(&self, map: &PolarMap, each: &mut dyn FnMut(CheckResult)) {
        let p = self.numbers.get();
        let beam = beam(map.geometry());
        let max_still = ((p.still_beams * beam) as i32).max(p.still_rows as i32);
        each(CheckResult {
            reason: Reason::MirrorStuck,
            value: (f32::from(self.max_still_rows) * PER_BEAM / beam.max(1.0)) as i32,
            limit: (max_still as f32 * PER_BEAM / beam.max(1.0)) as i32,
        });
        each(CheckResult {
            reason: Reason::AngleJump,
            value: self.max_difference.into(),
            limit: units(p.jump_db),
        });
    }
}

/// Returns the level of the mirror's own echo in other bins, from its own level, map units.
pub fn skirt(mirror: i32) -> i32 {
    mirror - units(-math::DB_PER_OCTAVE * math::log2(SKIRT))
}

/// Searches lines: bins with the same level in nearly all rows. Calls `each` with the largest share of rows, per cent,
/// at the level of one bin: one check for ranges below `blocked_m` (blocked view), one for those beyond (interference).
/// `noise` is the map's median cell, and `mirror` the mean level of the mirror's own echo, map units: its skirt over the
/// range is a line, too.
#[inline(never)]
pub fn lines(
    map: &PolarMap,
    config: &Config,
    p: &Params,
    [noise, mirror]: [i32; 2],
    each: &mut dyn FnMut(CheckResult),
) {
    let (geometry, radar) = (map.geometry(), &config.radar);
    // From this range on lie the I/Q images of mirror and leakage.
    let axis_m = radar.fft_len() as f32 * geometry.bin_m;
    let lobe_m = p.range_lobe_bins * radar.range_resolution_m();
    let end_m = axis_m - 2.0 * config.mount.mirror_offset_m() - 2.0 * lobe_m;
    let rows = |every: usize| (0..map.rows()).step_by(every).filter(|&k| map.present(k));
    let mean = |bin: usize, every: usize| {
        let sum: usize = rows(every).map(|k| usize::from(map.cell(k, bin))).sum();
        (sum / rows(every).count().max(1)) as i32
    };
    let least = (noise + units(p.line_db)).max(skirt(mirror));
    let count = rows(LINE_ROWS).count().max(1);
    let mut most = [0, 0];
    for bin in 0..map.bins() {
        let range_m = geometry.first_range_m + bin as f32 * geometry.bin_m;
        // The ground straight below is seen in every row through side lobes.
        let below = (range_m - geometry.mount_height_m).abs() < p.plumb_m;
        // A few rows exclude a line in most bins.
        let few = units(p.line_spread_db);
        if below || range_m >= end_m || mean(bin, FEW_LINE_ROWS) + few <= least {
            continue;
        }
        let mean = mean(bin, LINE_ROWS);
        if mean <= least {
            continue;
        }
        let alike =
            |k: &usize| (i32::from(map.cell(*k, bin)) - mean).abs() <= units(p.line_spread_db);
        let share = rows(LINE_ROWS).filter(alike).count() * PER_CENT / count;
        let [near, far] = &mut most;
        let place = if range_m < p.blocked_m { near } else { far };
        *place = share.max(*place);
    }
    let limit = (p.line_share * PER_CENT as f32) as i32;
    for (reason, share) in [Reason::BlockedView, Reason::Interference]
        .into_iter()
        .zip(most)
    {
        each(CheckResult {
            reason,
            value: share as i32,
            limit,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the longest standstill, 1/100 beamwidth, over rows without change whose cells 20 to 40 have the level 120; the
    /// noise is 60, and the mirror's own echo has the level `mirror`.
    fn standstill(mirror: i32) -> i32 {
        let mut map = Box::new(PolarMap::new());
        map.begin(&Config::default()).unwrap();
        let mut turning = Turning::new(Numbers::DEFAULT);
        for k in 0..120 {
            map.fill(k, |row| {
                row.cells.fill(60);
                row.cells[20..40].fill(120);
                row.mask.fill(u32::MAX);
            });
            turning.row(&map, k as u16, [60, skirt(mirror)]);
        }
        let mut longest = 0;
        turning.report_checks(&map, &mut |check| {
            if check.reason == Reason::MirrorStuck {
                longest = check.value;
            }
        });
        longest
    }

    #[test]
    fn the_skirt_of_the_mirrors_echo_is_no_mirror_that_stands_still() {
        assert!(standstill(150) > 300, "echoes that do not change");
        // 40 dB below the mirror's echo: a receiver with little noise shows it in every row.
        assert_eq!(standstill(228), 0);
    }
}
