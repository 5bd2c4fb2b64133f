//! Power above the ground: what stands there though the ground may go on beside it.

use super::super::chart::Chart;
use super::{CELLS, FLANK, Gaze, Lines, Power, Shown};
use crate::math;

/// Heights above the ground that are looked at, metres: from what is a rise to a wheelchair to the upper end of a
/// sweep's sector at 1 m.
const HEIGHTS_M: [f32; 6] = [0.05, 0.08, 0.12, 0.18, 0.26, 0.35];
/// Share of a cell's strongest row that shows in rows far from it: side lobes of an unknown antenna, and of a mirror
/// that turns meanwhile. Counted on tuning sweeps (docs/guard.md): with 0.02 things are seen where nothing stands.
const SIDE_LOBES: f32 = 0.05;
/// Powers of what stands there, dB over the noise: the first, their distance, and their number.
const FIRST_DB: f32 = 18.0;
/// See [`FIRST_DB`].
const STEP_DB: f32 = 6.0;
/// See [`FIRST_DB`].
const POWERS: usize = 4;
/// Something is seen above the ground of a cell so often though nothing stands there: ghosts, tiles on edge.
const ODD: f32 = 0.001;

/// The strongest line above the ground, by range cell; none where the ground is not seen.
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
    /// Of no map.
    pub const fn new() -> Self {
        Self {
            powers: [Power::DARK; CELLS],
        }
    }

    /// Looks above the ground in the cells of `lines`.
    #[inline(never)]
    pub fn look(&mut self, chart: &Chart<'_>, lines: &Lines) {
        let gaze = Gaze::new(chart);
        for (b, power) in self.powers.iter_mut().enumerate() {
            let seen = b < lines.cells.len();
            *power = if seen {
                gaze.above(lines.range_m(b))
            } else {
                Power::DARK
            };
        }
    }

    /// That of cell `b`.
    pub(super) fn get_mut(&mut self, b: usize) -> Option<&mut Power> {
        self.powers.get_mut(b)
    }

    /// How much likelier cell `b` is with something that stands there than without, nats; `None` where it is not seen.
    fn nats(&self, b: usize, lines: &Lines) -> Option<f32> {
        let shown: Shown = self.powers.get(b)?.shown();
        if shown.t <= 0.0 {
            return None;
        }
        let powers = (0..POWERS).map(|k| lines.ratio(shown, FIRST_DB + STEP_DB * k as f32));
        let ratio = powers.sum::<f32>() / POWERS as f32;
        Some(math::ln(ratio / (1.0 - ODD + ODD * ratio)))
    }

    /// The same of something that shows in cell `b` and in one beside it: a single cell is a ghost as a rule.
    pub fn thing(&self, b: usize, lines: &Lines) -> Option<f32> {
        let here = self.nats(b, lines)?;
        let before = b.checked_sub(1).and_then(|b| self.nats(b, lines));
        let beside = [before, self.nats(b + 1, lines)].into_iter().flatten();
        Some(here + beside.reduce(math::max).unwrap_or(0.0))
    }
}

impl Gaze<'_> {
    /// The strongest of the lines above the ground at a range, over what the ground's own line shows there.
    #[inline(never)]
    fn above(&self, range_m: f32) -> Power {
        let Some((bin, level)) = self.place(range_m, 0.0) else {
            return Power::DARK;
        };
        let Some(ground) = self.along(bin, level) else {
            return Power::DARK;
        };
        let (_, strongest) = self.strongest(bin);
        let line = |y_m: f32| {
            let (bin, row) = self.place(range_m, y_m)?;
            let t = self.along(bin, row)?;
            let off = (row - level) / self.sigma_rows;
            let flank = math::max(ground - 1.0, 0.0) * math::exp(-FLANK * off * off);
            let leaks = 1.0 + SIDE_LOBES * strongest + flank;
            Some(Power::new(t / leaks, leaks))
        };
        let lines = HEIGHTS_M.into_iter().filter_map(line);
        lines.reduce(Power::brighter).unwrap_or(Power::DARK)
    }
}
