//! That the mirror turned as it was told: echoes change with the angle as the beam's width makes them.
//!
//! A scatterer's level follows the beam: two rows two fifths of a beam's width apart differ by several
//! decibels, neighbours by little. What does not change over such a lag for longer than it takes a
//! lobe to pass its peak shows a mirror that stands still; what changes at once shows rows that are not
//! where they are taken to be. A line at one range through all angles is nothing that a mirror shows at
//! all: something transmits, or stands right before it.

use super::units;
use crate::answer::{Reason, Reasons};
use crate::config::Config;
use crate::grid::{MAX_BINS, PolarMap};
use crate::params::Params;

const P: Params = Params::DEFAULT;

/// Rows to both sides in which the strongest cell around is looked for.
const AROUND: usize = 5;
/// Rows of the beam that `jump_db` is told for.
const USUAL_BEAM: f32 = 20.0;

/// How two rows differ where either is well above the noise of both.
#[derive(Default)]
struct Difference {
    /// Cells compared.
    cells: u32,
    /// Sum of the differences, map units; each counts [`P`]`.jump_clip_db` at most.
    sum: u32,
}

impl Difference {
    fn add(&mut self, a: u8, b: u8) {
        self.cells += 1;
        self.sum += u32::from(a.abs_diff(b)).min(units(P.jump_clip_db).unsigned_abs());
    }

    /// Of rows `a` and `b`, of the cells above `floor`.
    fn of(map: &PolarMap, a: usize, b: usize, floor: i32) -> Self {
        let mut found = Self::default();
        for (&a, &b) in map.row(a).iter().zip(map.row(b)) {
            if i32::from(a.max(b)) > floor {
                found.add(a, b);
            }
        }
        found
    }

    /// Of row `k` and the one before, of the cells above `floor` that lie in no null.
    fn beside(map: &PolarMap, k: usize, floor: i32) -> Self {
        let mut found = Self::default();
        let around = k.saturating_sub(1 + AROUND)..(k + 1 + AROUND).min(map.rows());
        let pairs = map.row(k.saturating_sub(1)).iter().zip(map.row(k));
        for (bin, (&a, &b)) in pairs.enumerate() {
            let stronger = i32::from(a.max(b));
            if stronger > floor {
                let strongest = around.clone().map(|row| map.cell(row, bin)).max();
                if stronger + units(P.jump_near_db) >= strongest.unwrap_or(0).into() {
                    found.add(a, b);
                }
            }
        }
        found
    }

    /// Whether the mean difference is below so many map units.
    fn below(&self, mean: i32) -> bool {
        self.sum < mean.unsigned_abs() * self.cells
    }
}

/// Mean cell of a row, map units.
fn mean(row: &[u8]) -> i32 {
    let sum: u32 = row.iter().map(|&cell| u32::from(cell)).sum();
    (sum / row.len().max(1) as u32) as i32
}

/// Whether row `k` came and was not set aside.
fn seen(map: &PolarMap, k: usize) -> bool {
    map.present(k) && map.row(k).iter().any(|&cell| cell > 0)
}

/// What the map tells of the mirror; `noise` is its median cell.
#[inline(never)]
pub fn watch(map: &PolarMap, config: &Config, noise: u8) -> Reasons {
    let geometry = map.geometry();
    let beam = geometry.beamwidth_rad / geometry.step_rad.max(f32::MIN_POSITIVE);
    // `as` saturates.
    let lag = ((P.still_lag_beams * beam + 0.5) as usize).max(2);
    let patience = ((P.still_beams * beam + 0.5) as u32).max(P.still_rows as u32);
    let strong = units(P.turning_db);
    let steep = units(P.jump_db * (USUAL_BEAM / beam.max(1.0)).max(1.0));
    let (mut still, mut longest, mut jumps) = (0, 0, 0);
    // A jump's cells differ by so much in sum at least: without it nobody need look for nulls.
    let least = P.jump_cells as u32 * steep.unsigned_abs();
    let mut before = mean(map.row(0));
    for k in 1..map.rows() {
        let here = mean(map.row(k));
        let floor = before.max(here).max(noise.into()) + strong;
        before = here;
        if !seen(map, k) || !seen(map, k - 1) {
            continue;
        }
        if Difference::of(map, k - 1, k, floor).sum >= least {
            let beside = Difference::beside(map, k, floor);
            let enough = beside.cells >= P.jump_cells as u32;
            jumps += u32::from(enough && !beside.below(steep));
        }
        let Some(old) = k.checked_sub(lag).filter(|&old| seen(map, old)) else {
            continue;
        };
        let far = Difference::of(map, old, k, floor);
        let unmoved = far.cells >= P.still_cells as u32 && far.below(units(P.still_db));
        still = if unmoved { still + 1 } else { 0 };
        longest = longest.max(still);
    }
    let mut doubts = Reasons::NONE;
    if longest > patience {
        doubts.add(Reason::MirrorStuck);
    }
    if jumps > 0 {
        doubts.add(Reason::AngleJump);
    }
    if let Some(range_m) = line(map, config, noise) {
        doubts.add(if range_m < P.blocked_m {
            Reason::BlockedView
        } else {
            Reason::Interference
        });
    }
    doubts
}

/// Rows between two that are looked at for lines.
const LINE_ROWS: usize = 4;

/// The nearest range at which nearly all rows show the same level, metres.
#[inline(never)]
fn line(map: &PolarMap, config: &Config, noise: u8) -> Option<f32> {
    let (geometry, radar) = (map.geometry(), &config.radar);
    // From here on lie the images of mirror and leakage.
    let axis_m = radar.fft_len() as f32 * geometry.bin_m;
    let lobe_m = P.range_lobe_bins * radar.range_resolution_m();
    let end_m = axis_m - 2.0 * config.mount.mirror_offset_m() - 2.0 * lobe_m;
    let range_m = |bin: usize| geometry.first_range_m + bin as f32 * geometry.bin_m;
    // The floor straight below shows by side lobes in every row.
    let below = |range_m: f32| (range_m - geometry.mount_height_m).abs() < P.plumb_m;
    let real = |bin: usize| range_m(bin) < end_m && !below(range_m(bin));
    let rows = || (0..map.rows()).step_by(LINE_ROWS).filter(|&k| seen(map, k));
    let count = rows().count() as u32;
    let mut sums = [0u32; MAX_BINS];
    for k in rows() {
        for (sum, &cell) in sums.iter_mut().zip(map.row(k)) {
            *sum += u32::from(cell);
        }
    }
    let most = (P.line_share * count as f32) as u32;
    let bin = (0..map.bins()).zip(&sums).position(|(bin, &sum)| {
        let mean = (sum / count.max(1)) as i32;
        let level = mean > i32::from(noise) + units(P.line_db);
        let alike =
            |k: &usize| (i32::from(map.cell(*k, bin)) - mean).abs() <= units(P.line_spread_db);
        level && real(bin) && rows().filter(alike).count() as u32 > most
    })?;
    Some(range_m(bin))
}
