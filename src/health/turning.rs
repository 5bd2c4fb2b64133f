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
use crate::params::current as p;
use crate::signal::grid::{Geometry, PolarMap};
use crate::verdict::Reason;

/// Distance of the surrounding rows from a compared pair: a null of the pattern is narrower.
const AROUND: usize = 4;
/// Beamwidth that `jump_db` holds for, rows.
const REFERENCE_BEAM: f32 = 20.0;
/// Row interval of the standstill check. Its rows are not those of the noise histogram.
const STILL_ROWS: u16 = 2;
/// Fractions of a beamwidth in which a standstill is reported.
const PER_BEAM: f32 = 100.0;
/// Row interval of the search for lines.
const LINE_ROWS: usize = 8;
/// Row interval of the pre-check of a bin for a line.
const FEW_LINE_ROWS: usize = 32;
/// Per cent of a whole.
const PER_CENT: usize = 100;

/// Results from the rows of one scan so far.
#[derive(Clone, Debug)]
pub struct Turning {
    /// Number of rows that arrived, and the row before.
    rows: u16,
    before: u16,
    /// Number of consecutive rows that equal those one lag before them, and its maximum.
    still_rows: u16,
    max_still_rows: u16,
    /// Maximum difference of neighbouring rows beyond the usual one, summed over cells, map units at
    /// [`REFERENCE_BEAM`].
    max_difference: u16,
    /// Strongest bin of the two neighbouring rows that were compared last.
    strongest: u8,
}

/// A cell that exceeds the noise clearly in one of two rows: its bin, the stronger level and the clipped
/// difference, map units.
#[derive(Clone, Copy)]
struct Pair {
    bin: u8,
    stronger: u8,
    difference: u8,
}

/// Maximum number of compared cells of two rows: a row shows a dozen echoes of four cells.
const MAX_PAIRS: usize = 32;

/// Compared cells of two rows.
struct Pairs {
    list: heapless::Vec<Pair, MAX_PAIRS>,
    /// Sum of the differences, map units.
    sum: u32,
    strongest: Pair,
}

impl Pairs {
    /// Collects the cells above `floor`, map units; `cells` gives bin and level in either row.
    fn of(cells: impl Iterator<Item = (usize, u8, u8)>, floor: u8) -> Self {
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
                difference: a.abs_diff(b).min(units(p().jump_clip_db) as u8),
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

/// Returns whether row `k` arrived and was not set aside.
fn has_cells(map: &PolarMap, k: usize) -> bool {
    map.present(k) && map.row(k).iter().any(|&cell| cell > 0)
}

/// Returns the number of rows of a beamwidth.
fn beam(geometry: &Geometry) -> f32 {
    geometry.beamwidth_rad / geometry.step_rad.max(f32::MIN_POSITIVE)
}

impl Turning {
    pub const fn new() -> Self {
        Self {
            rows: 0,
            before: 0,
            still_rows: 0,
            max_still_rows: 0,
            max_difference: 0,
            strongest: 0,
        }
    }

    /// Adds row `k` of `map`; `noise` is the rows' lower quartile, map units. Returns the strongest bin of the
    /// rows that were compared last.
    #[inline(never)]
    pub fn row(&mut self, map: &PolarMap, k: u16, noise: i32) -> u8 {
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
        let floor = (noise + units(p().turning_db)).clamp(0, u8::MAX.into()) as u8;
        let beam = beam(map.geometry());
        self.rows = self.rows.wrapping_add(1);
        // The cast saturates.
        let lag = ((p().still_lag_beams * beam + 0.5) as usize).max(2);
        // Every other row suffices for a standstill.
        if let Some(old) = back(lag).filter(|_| self.rows % STILL_ROWS == 1) {
            let before = map.row(old);
            // Every other cell suffices, too.
            let hits = map.detections(here).step_by(2);
            let both = hits.filter_map(|(bin, now)| Some((bin, *before.get(bin)?, now)));
            let Pairs { list, sum, .. } = Pairs::of(both, floor);
            let unmoved = list.len() >= p().still_cells as usize
                && sum < units(p().still_db) as u32 * list.len() as u32;
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

    /// Compares two neighbouring rows whose surrounding rows have arrived as well.
    fn compare_neighbours(&mut self, map: &PolarMap, [a, b]: [usize; 2], floor: u8, beam: f32) {
        // The flanks of a narrow beam are steeper.
        let scale = (REFERENCE_BEAM / beam.max(1.0)).max(1.0);
        let steepest = (f32::from(self.max_difference) * scale) as u32;
        let found = Pairs::of(map.detections_of(a, b), floor);
        if found.sum > 0 {
            self.strongest = found.strongest.bin;
        }
        // Only a difference above the maximum so far needs the surrounding rows.
        if found.sum <= steepest {
            return;
        }
        let near = units(p().jump_near_db) as u8;
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
        if cells >= p().jump_cells as u32 {
            let usual = units(p().jump_usual_db) as u32 * cells;
            let beyond = (differ as f32 / scale) as u32;
            self.max_difference = self.max_difference.max(beyond.saturating_sub(usual) as u16);
        }
    }

    /// Calls `each` with the results of the checks for a standstill and for jumps of the angle.
    pub fn report_checks(&self, map: &PolarMap, each: &mut dyn FnMut(CheckResult)) {
        let beam = beam(map.geometry());
        let max_still = ((p().still_beams * beam) as i32).max(p().still_rows as i32);
        each(CheckResult {
            reason: Reason::MirrorStuck,
            value: (f32::from(self.max_still_rows) * PER_BEAM / beam.max(1.0)) as i32,
            limit: (max_still as f32 * PER_BEAM / beam.max(1.0)) as i32,
        });
        each(CheckResult {
            reason: Reason::AngleJump,
            value: self.max_difference.into(),
            limit: units(p().jump_db),
        });
    }
}

/// Calls `each` with the largest share of the rows, per cent, that has the same level at one range: one check
/// for ranges below `blocked_m`, one for those beyond. `noise` is the map's median cell, map units.
#[inline(never)]
pub fn lines(map: &PolarMap, config: &Config, noise: u8, each: &mut dyn FnMut(CheckResult)) {
    let (geometry, radar) = (map.geometry(), &config.radar);
    // From this range on lie the I/Q images of mirror and leakage.
    let axis_m = radar.fft_len() as f32 * geometry.bin_m;
    let lobe_m = p().range_lobe_bins * radar.range_resolution_m();
    let end_m = axis_m - 2.0 * config.mount.mirror_offset_m() - 2.0 * lobe_m;
    let rows = |every: usize| (0..map.rows()).step_by(every).filter(|&k| map.present(k));
    let mean = |bin: usize, every: usize| {
        let sum: usize = rows(every).map(|k| usize::from(map.cell(k, bin))).sum();
        (sum / rows(every).count().max(1)) as i32
    };
    let least = i32::from(noise) + units(p().line_db);
    let count = rows(LINE_ROWS).count().max(1);
    let mut most = [0, 0];
    for bin in 0..map.bins() {
        let range_m = geometry.first_range_m + bin as f32 * geometry.bin_m;
        // The ground straight below is seen in every row through side lobes.
        let below = (range_m - geometry.mount_height_m).abs() < p().plumb_m;
        // A few rows exclude a line in most bins.
        let few = units(p().line_spread_db);
        if below || range_m >= end_m || mean(bin, FEW_LINE_ROWS) + few <= least {
            continue;
        }
        let mean = mean(bin, LINE_ROWS);
        if mean <= least {
            continue;
        }
        let alike =
            |k: &usize| (i32::from(map.cell(*k, bin)) - mean).abs() <= units(p().line_spread_db);
        let share = rows(LINE_ROWS).filter(alike).count() * PER_CENT / count;
        let [near, far] = &mut most;
        let place = if range_m < p().blocked_m { near } else { far };
        *place = share.max(*place);
    }
    let limit = (p().line_share * PER_CENT as f32) as i32;
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
