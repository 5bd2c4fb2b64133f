//! Power above the ground, of objects beside which the ground may still be visible.

use super::chart::Chart;
use super::gaze::Gaze;
use super::lines::{CELLS, Lines};
use super::power::{DEPTHS_M, Power, RangeCell, Shown};
use crate::math;
use crate::params::ground_line::{self, ITSELF, OFF_M};
use crate::params::guard::{FIRST_DB, ODD, SIDE_LOBES, STEP_DB};

/// Heights above the ground of the lines along which an object's power is evaluated, metres: from the lowest rise that
/// matters to a wheelchair to the upper end of a sweep's sector at 1 m.
const HEIGHTS_M: [f32; 4] = [0.05, 0.1, 0.18, 0.3];
/// Number of lines below the ground, of the smallest depths in [`DEPTHS_M`]. Ground 5 to 7 cm lower passes on the
/// ground's own line for ground of less reflectivity; deeper ground does not.
pub const DEPTHS: usize = 1;
/// Maximum range of the lines, metres: a chair does not reach anything farther than 1.65 m within three seconds.
const FARTHEST_M: f32 = 1.7;
/// Minimum power over the noise of a range cell's strongest echo that counts as one: about the maximum of noise over the
/// angles of a sweep.
const FAINT: f32 = 8.0;
/// Exponent of a Gaussian beam seen through one like it: exp(-d²/4) at d standard deviations.
const FLANK: f32 = 0.25;
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
        lines.fill(&Gaze::new(chart), FARTHEST_M, |gaze, range_m| {
            let above = powers.next();
            let Some(cell) = SweptCell::new(gaze, range_m) else {
                return RangeCell::DARK;
            };
            if let Some(power) = above {
                *power = cell.above();
            }
            let mut lower = [Power::DARK; DEPTHS_M.len()];
            for (power, depth_m) in lower.iter_mut().zip(DEPTHS_M).take(DEPTHS) {
                *power = cell.shown(cell.line(-depth_m));
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

/// Power over the noise along a line, and the angle at which it was seen, radians.
type SeenLine = (f32, f32);

/// A range cell of a sweep. CLEAN would take longer than a sweep has: what the cell's strongest echo leaks into its other
/// angles counts as noise, side lobes everywhere and the beam's flank near it.
struct SweptCell<'g> {
    gaze: &'g Gaze<'g>,
    range_m: f32,
    /// The ground's own line.
    level: SeenLine,
    /// The line to the cell's strongest echo.
    strongest: SeenLine,
    /// Power of the noise and of the strongest echo's side lobes together, as a ratio to the noise.
    leaks: f32,
}

impl<'g> SweptCell<'g> {
    /// Returns the cell at a range, metres; `None` where the ground is not seen.
    fn new(gaze: &'g Gaze<'g>, range_m: f32) -> Option<Self> {
        let (look, (bin, angle_rad)) = gaze.look(range_m, 0.0)?;
        let strongest = gaze.chart.image.strongest(bin);
        Some(Self {
            gaze,
            range_m,
            level: (look.power, angle_rad),
            strongest,
            leaks: 1.0 + ground_line::SIDE_LOBES * strongest.0,
        })
    }

    /// Returns the share of its power that an echo shows at `off_rad` beside its angle, seen through the image's filter.
    fn flank(&self, off_rad: f32) -> f32 {
        let off = off_rad / self.gaze.chart.sigma_rad();
        math::exp(-FLANK * off * off)
    }

    /// Returns the line of a surface at height `y_m` above the ground, metres; `None` if it is not seen.
    fn line(&self, y_m: f32) -> Option<SeenLine> {
        let (look, (_, angle_rad)) = self.gaze.look(self.range_m, y_m)?;
        Some((look.power, angle_rad))
    }

    /// Returns the quantised power of a line over the noise and its leakage; dark if it is not seen.
    fn shown(&self, line: Option<SeenLine>) -> Power {
        let Some((power, angle_rad)) = line else {
            return Power::DARK;
        };
        let (strongest, strongest_rad) = self.strongest;
        let off_rad = angle_rad - strongest_rad;
        let other = strongest > math::max(power, FAINT)
            && off_rad.abs() > ITSELF * self.gaze.chart.sigma_rad();
        let flank = if other {
            math::max(strongest / self.leaks - 1.0, 0.0) * self.flank(off_rad)
        } else {
            0.0
        };
        let leaks = self.leaks * (1.0 + flank);
        Power::new(power / leaks, leaks)
    }

    /// Returns the quantised power along the strongest of three lines: the ground's own, one slightly below and one
    /// slightly above it.
    fn ground(&self) -> Power {
        let [below, above] = [-OFF_M, OFF_M].map(|y_m| self.shown(self.line(y_m)));
        self.shown(Some(self.level)).brighter(below.brighter(above))
    }

    /// Returns the power along the strongest line above the ground, over the leakage of the ground's own line.
    fn above(&self) -> Power {
        let (ground, ground_rad) = self.level;
        let ground = math::max(ground - 1.0, 0.0);
        let line = |y_m: f32| {
            let (power, angle_rad) = self.line(y_m)?;
            let flank = ground * self.flank(angle_rad - ground_rad);
            let leaks = 1.0 + SIDE_LOBES * self.strongest.0 + flank;
            Some((power / leaks, leaks))
        };
        let lines = HEIGHTS_M.into_iter().filter_map(line);
        let strongest = lines.reduce(|a, b| if b.0 > a.0 { b } else { a });
        strongest.map_or(Power::DARK, |(t, leaks)| Power::new(t, leaks))
    }
}
