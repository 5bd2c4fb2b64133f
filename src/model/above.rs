//! Power above the ground: what stands there though the ground may go on beside it.

use super::chart::Chart;
use super::lines::{CELLS, DEPTHS_M, FLANK, Gaze, Lines, LookedCell, Power, RangeCell, Shown};
use crate::math;

/// Heights above the ground that are looked at, metres: from what is a rise to a wheelchair to the upper end of a
/// sweep's sector at 1 m.
const HEIGHTS_M: [f32; 4] = [0.05, 0.1, 0.18, 0.3];
/// Number of lines below the ground, the smallest depths first: ground that goes on 5 to 7 cm lower passes for ground of less
/// reflectivity along the ground's own line, deeper ground does not.
pub const DEPTHS: usize = 1;
/// Range up to which they are, metres: what is farther than 1.65 m a chair does not reach within three seconds.
const FARTHEST_M: f32 = 1.7;
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

    /// Evaluates the lines along the ground, above it and at the smallest depth below it: in place of [`Lines::look`].
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

    /// That of cell `b`.
    pub(super) fn get_mut(&mut self, b: usize) -> Option<&mut Power> {
        self.powers.get_mut(b)
    }

    /// How much likelier cell `b` is with something that stands there than without, nats; `None` where it is not seen.
    fn nats(&self, b: usize, lines: &Lines) -> Option<f32> {
        let shown: Shown = self.powers.get(b)?.shown();
        if !shown.is_seen() {
            return None;
        }
        let powers = (0..POWERS).map(|k| lines.ratio(shown, FIRST_DB + STEP_DB * k as f32));
        let ratio = powers.sum::<f32>() / POWERS as f32;
        Some(math::ln(ratio / (1.0 - ODD + ODD * ratio)))
    }

    /// The same of something that shows in a cell and in one beside it: a single cell is a ghost as a rule. Calls `tell`
    /// for each cell that is seen.
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
    /// The strongest of the lines above the ground, over what the ground's own line shows there; dark where that is not
    /// seen.
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
