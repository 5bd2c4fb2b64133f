//! Power above the ground, of objects beside which the ground may still be visible.

use super::chart::Chart;
use super::gaze::{FLANK, Gaze, LookedCell};
use super::lines::{CELLS, Lines};
use super::power::{DEPTHS_M, Power, RangeCell, Shown};
use crate::math;
use crate::params::guard::{FIRST_DB, ODD, SIDE_LOBES, STEP_DB};

/// Heights above the ground of the lines along which an object's power is evaluated, metres: from the lowest rise that
/// matters to a wheelchair to the upper end of a sweep's sector at 1 m.
const HEIGHTS_M: [f32; 4] = [0.05, 0.1, 0.18, 0.3];
/// Number of lines below the ground, of the smallest depths in [`DEPTHS_M`]. Ground 5 to 7 cm lower passes on the
/// ground's own line for ground of less reflectivity; deeper ground does not.
pub const DEPTHS: usize = 1;
/// Maximum range of the lines, metres: a chair does not reach anything farther than 1.65 m within three seconds.
const FARTHEST_M: f32 = 1.7;
/// Number of powers that an object is assumed to have, equally probable.
const POWERS: usize = 4;

/// Quantised power over the noise along the strongest of the lines above the ground, by range cell, the nearest first;
/// dark where the ground is not seen.
#[derive(Clone, Debug)]
pub struct Above {
    powers: [Power; CELLS],
}

impl Default for Above {
    fn default() -> Self {
        Self::new()
    }
}

impl Above {
    /// Returns the state without a sweep: all cells dark.
    pub const fn new() -> Self {
        Self {
            powers: [Power::DARK; CELLS],
        }
    }

    /// Evaluates the lines along the ground, above it and, at the smallest depths, below it, for each range cell of a
    /// sweep: in place of [`Lines::look`].
    #[inline(never)]
    pub fn look(&mut self, chart: &Chart<'_>, lines: &mut Lines) {
        self.powers = [Power::DARK; CELLS];
        let mut powers = self.powers.iter_mut();
        lines.fill(&Gaze::new(chart), FARTHEST_M, |gaze, bin, range_m| {
            let cell = LookedCell::new(gaze, bin, range_m);
            if let Some(power) = powers.next() {
                *power = cell.above();
            }
            let mut lower = [Power::DARK; DEPTHS_M.len()];
            for (power, depth_m) in lower.iter_mut().zip(DEPTHS_M).take(DEPTHS) {
                *power = cell.line(cell.seen(-depth_m));
            }
            RangeCell {
                ground: cell.ground(),
                lower,
            }
        });
    }

    /// Returns the quantised power along the strongest line above the ground in range cell `b`; `None` beyond the last
    /// cell.
    pub(super) fn get_mut(&mut self, b: usize) -> Option<&mut Power> {
        self.powers.get_mut(b)
    }

    /// Returns the log-likelihood ratio of an object above the ground in range cell `b` to none, nats; `None` where the
    /// cell is not seen.
    fn nats(&self, b: usize, lines: &Lines) -> Option<f32> {
        let shown: Shown = self.powers.get(b)?.shown();
        if !shown.is_seen() {
            return None;
        }
        let powers = (0..POWERS).map(|k| lines.ratio(shown, FIRST_DB + STEP_DB * k as f32));
        let ratio = powers.sum::<f32>() / POWERS as f32;
        Some(math::ln(ratio / (1.0 - ODD + ODD * ratio)))
    }

    /// Calls `tell` for each range cell that is seen, with its index and the log-likelihood ratio to none of an object
    /// that shows in this cell and in one neighbour, nats: a single cell is usually a ghost.
    pub fn things(&self, lines: &Lines, mut tell: impl FnMut(usize, f32)) {
        let (mut before, mut here) = (None, self.nats(0, lines));
        for b in 0..lines.cells.len() {
            let next = self.nats(b + 1, lines);
            if let Some(here) = here {
                let beside = [before, next].into_iter().flatten().reduce(math::max);
                tell(b, here + beside.unwrap_or(0.0));
            }
            (before, here) = (here, next);
        }
    }
}

impl LookedCell<'_> {
    /// Returns the power along the strongest line above the ground, over the leakage of the ground's own line; dark
    /// where that is not seen.
    fn above(&self) -> Power {
        let Some((ground, base)) = self.level else {
            return Power::DARK;
        };
        let ground = math::max(ground - 1.0, 0.0);
        let line = |y_m: f32| {
            let (t, row) = self.seen(y_m)?;
            let off = (row - base) / self.gaze.sigma_rows;
            let leaks = 1.0 + SIDE_LOBES * self.strongest + ground * math::exp(-FLANK * off * off);
            Some((t / leaks, leaks))
        };
        let lines = HEIGHTS_M.into_iter().filter_map(line);
        let strongest = lines.reduce(|a, b| if b.0 > a.0 { b } else { a });
        strongest.map_or(Power::DARK, |(t, leaks)| Power::new(t, leaks))
    }
}
