//! Exponentially weighted mean of the line powers over sweeps.
//!
//! A sweep has few rows, so that noise and speckle leave much open. The mean of t over sweeps corresponds to more
//! rows, and to as many independent speckle patterns as the chair has seen from places more than half a wavelength
//! apart.

use super::above::{Above, DEPTHS};
use super::lines::{CELLS, Lines};
use super::power::Power;
use crate::math;
use crate::params::guard::{KEPT, KEPT_UNPLACED};

/// Travel beyond which the speckle is independent, metres: more than half a wavelength.
const OTHER_SPECKLE_M: f32 = 0.002;
/// Number of lines of a range cell: along the ground, above it, and below it.
const LINES: usize = 2 + DEPTHS;

/// Weights of the mean over sweeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanWeights {
    /// Weight in the mean of all earlier sweeps together, where the last sweep has weight 1.
    earlier: f32,
    /// Number of equally weighted sweeps that would give a mean of the same variance.
    sweeps: f32,
    /// Number of independent speckle patterns that would give a mean of the same variance.
    speckles: f32,
}

/// Mean powers of the lines over sweeps, by range cell.
#[derive(Clone, Debug)]
pub struct MeanLines {
    /// Mean powers t, quantised as in [`Power`], of each cell's lines along the ground, above it and below it; 0 where
    /// nothing was seen.
    powers: [[u8; LINES]; CELLS],
    /// Sum of the weights of all sweeps so far, where the last sweep has weight 1.
    weight: f32,
}

impl Default for MeanLines {
    fn default() -> Self {
        Self::new()
    }
}

impl MeanLines {
    /// Returns the state before the first sweep.
    pub const fn new() -> Self {
        Self {
            powers: [[0; LINES]; CELLS],
            weight: 0.0,
        }
    }

    /// Counts another sweep, `moved_m` metres after the last one if known, and returns the weights of the mean.
    fn count(&mut self, moved_m: Option<f32>) -> MeanWeights {
        let kept = if moved_m.is_some() {
            KEPT
        } else {
            KEPT_UNPLACED
        };
        let earlier = kept * self.weight;
        self.weight = earlier + 1.0;
        // (Σw)² / Σw² of a geometric series.
        let sweeps = math::min((1.0 + kept) / (1.0 - kept), self.weight);
        let moves = moved_m.is_some_and(|m| m.abs() > OTHER_SPECKLE_M);
        MeanWeights {
            earlier,
            sweeps,
            speckles: if moves { sweeps } else { 1.0 },
        }
    }

    /// Returns the mean t (power over the noise) of line number `line` at `place`, in cells, interpolated between both
    /// neighbouring cells; `None` if neither was seen.
    fn at(&self, line: usize, place: f32) -> Option<f32> {
        let below = math::floor(place);
        let share = place - below;
        let t = |k: f32| {
            // `as` saturates.
            let cell = if k < 0.0 {
                None
            } else {
                self.powers.get(k as usize)
            };
            let t = cell.and_then(|c| c.get(line)).copied().filter(|t| *t > 0);
            t.map(|t| Power { t, leaks: 0 }.shown().t)
        };
        match (t(below), t(below + 1.0)) {
            (Some(a), Some(b)) => Some(a + share * (b - a)),
            (a, b) => a.or(b),
        }
    }

    /// Averages the lines of a sweep with those of earlier sweeps: `lines` and `above` receive the means, which are
    /// also kept for the next sweep. `moved_m` is the chair's forward travel since the last sweep, metres, if known.
    #[inline(never)]
    pub fn average(&mut self, lines: &mut Lines, above: &mut Above, moved_m: Option<f32>) {
        let weights = self.count(moved_m);
        let (range_of, first_m, step_m) = (lines.height_m, lines.first_m, lines.step_m);
        // Nearest first: what a cell needs of earlier ones lies farther away where the chair drives forward, and
        // backward the other way round.
        let forward = moved_m.is_none_or(|m| m >= 0.0);
        let n = lines.cells.len();
        for k in 0..n {
            let b = if forward { k } else { n - 1 - k };
            let range_m = lines.range_m(b);
            let old_m = math::hypot(lines.x_m(range_m) + moved_m.unwrap_or(0.0), range_of);
            let place = (old_m - first_m) / step_m;
            let (Some(cell), Some(above)) = (lines.cells.get_mut(b), above.get_mut(b)) else {
                continue;
            };
            let [first, ..] = &mut cell.lower;
            self.take(b, place, weights.earlier, [&mut cell.ground, above, first]);
        }
        lines.settle(weights.sweeps, weights.speckles);
    }

    /// Averages the lines of cell `b` with the means of earlier sweeps at `place`, in cells, which have weight
    /// `earlier`; that of this sweep is 1.
    fn take(&mut self, b: usize, place: f32, earlier: f32, lines: [&mut Power; LINES]) {
        for (line, power) in lines.into_iter().enumerate() {
            if power.t > 0
                && let Some(before) = self.at(line, place)
            {
                let t = (earlier * before + power.shown().t) / (earlier + 1.0);
                power.t = Power::new(t, 1.0).t;
            }
            if let Some(kept) = self.powers.get_mut(b).and_then(|c| c.get_mut(line)) {
                *kept = power.t;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::power::{DEPTHS_M, RangeCell};
    use super::*;

    /// Returns ten range cells from 0.6 m on, all with this power along the ground.
    fn lines(power: Power) -> (Lines, Above) {
        let mut lines = Lines::new();
        (lines.first_m, lines.step_m, lines.height_m) = (0.6, 0.02, 0.4);
        lines.rows = 10.0;
        for _ in 0..10 {
            let lower = [Power::DARK; DEPTHS_M.len()];
            let cell = RangeCell {
                ground: power,
                lower,
            };
            lines.cells.push(cell).unwrap();
        }
        (lines, Above::new())
    }

    fn t(power: Power) -> f32 {
        power.shown().t
    }

    #[test]
    fn a_mean_of_equal_sweeps_is_like_each_of_them() {
        let mut mean = MeanLines::new();
        for _ in 0..20 {
            let (mut lines, mut above) = lines(Power::new(5.0, 1.0));
            mean.average(&mut lines, &mut above, Some(0.0));
            // A quarter of a decibel is 6 %.
            assert!((t(lines.ground(3)) / 5.0 - 1.0).abs() < 0.06);
        }
    }

    #[test]
    fn a_new_sweep_has_its_share() {
        let mut mean = MeanLines::new();
        let (mut first, mut above) = lines(Power::new(1.0, 1.0));
        mean.average(&mut first, &mut above, Some(0.0));
        let (mut second, _) = lines(Power::new(10.0, 1.0));
        mean.average(&mut second, &mut above, Some(0.0));
        let expected = (10.0 + KEPT) / (1.0 + KEPT);
        assert!((t(second.ground(3)) / expected - 1.0).abs() < 0.06);
    }

    #[test]
    fn number_of_sweeps_is_that_of_a_geometric_mean() {
        let mut mean = MeanLines::new();
        let mut weights: std::vec::Vec<MeanWeights> =
            (0..40).map(|_| mean.count(Some(0.1))).collect();
        let last = weights.pop().unwrap();
        let full = (1.0 + KEPT) / (1.0 - KEPT);
        assert!((last.sweeps - last.speckles).abs() < 1e-6 && last.sweeps <= full);
        assert!((last.earlier - KEPT / (1.0 - KEPT)).abs() < 1e-3);
        // A chair that stands sees the same speckle again and again.
        assert!((mean.count(Some(0.0)).speckles - 1.0).abs() < 1e-6);
        // Where the way is not known little is kept.
        assert!(mean.count(None).earlier < last.earlier);
    }

    #[test]
    fn mean_is_moved_with_the_chairs_travel() {
        let mut mean = MeanLines::new();
        let (mut first, mut above) = lines(Power::new(1.0, 1.0));
        first.cells[6].ground = Power::new(100.0, 1.0);
        mean.average(&mut first, &mut above, Some(0.0));
        let moved_m = first.x_m(first.range_m(6)) - first.x_m(first.range_m(4));
        let (mut second, _) = lines(Power::new(1.0, 1.0));
        mean.average(&mut second, &mut above, Some(moved_m));
        assert!(t(second.ground(4)) > 20.0, "{}", t(second.ground(4)));
        assert!(t(second.ground(6)) < 2.0);
    }
}
