//! Power along lines: what a range cell shows of a surface that lies at a level.
//!
//! All rows that look at one place of a surface share its speckle. With t a cell's power over the background, S the
//! surface's mean power over the noise, exponentially distributed by speckle, and G the gain Σg² of the coherent image,
//! one look at the image has
//!
//! ```text
//! p(t | S) = Exp(t; 1 + G S),   p(t | nothing) = Exp(t; 1)
//! ```
//!
//! A guard sweep makes no image. The mean power of the rows around the line, weighted like the two-way beam, has with n
//! independent rows
//!
//! ```text
//! E t = 1 + a S,   var t = (1 + 2 b S) / n + (a S)²,   p(t | S) = Gamma(t; both),   p(t | nothing) = Gamma(t; 1, 1/n)
//! ```
//!
//! In both, ln p(t | S) - ln p(t | nothing) = c(S) + d(S) t + e(S) ln t.

use super::chart::Chart;
use super::gaze::Gaze;
use super::power::{Power, RangeCell, Shown};
use crate::answer::Slope;
use crate::math;
use crate::params::ground_line::{FARTHEST_M, LINE_REACH, MAX_NATS, NEAREST_M};

/// Spacing of the evaluated range cells, metres, or a range bin if that is longer: nearer ones share the window's main
/// lobe.
const CELL_M: f32 = 0.0235;
/// Maximum number of evaluated range cells.
pub const CELLS: usize = 64;
/// Number of independent rows in the mean along a line, per row of its half-width: (Σw)² / Σw² of the weights w.
const WORTH: f32 = 1.4;
/// Factor of a surface's power S in the weighted mean along its line, Σwg / Σw for the two-way beam g.
const SHOWN: f32 = 0.709;
/// Factor of a surface's power S in the variance of each row, Σw²g / Σw².
const SHOWN_IN_VARIANCE: f32 = 0.792;
/// Lowest power S of a surface in the table of coefficients of the log-likelihood ratio, dB over the noise.
const FIRST_DB: f32 = -20.0;
/// Step between the powers S of a surface in the table of coefficients of the log-likelihood ratio, dB.
const STEP_DB: f32 = 2.0;
/// Number of powers S of a surface in the table of coefficients of the log-likelihood ratio.
const POWERS: usize = 20;

/// Number n of independent rows, with the summand of the log-likelihood ratio that depends on n alone.
#[derive(Clone, Copy, Debug)]
struct RowCount {
    n: f32,
    /// ln Γ(n) - n ln n.
    constant: f32,
}

impl RowCount {
    fn new(n: f32) -> Self {
        let constant = math::ln_gamma(n) - n * math::ln(n);
        Self { n, constant }
    }
}

/// Coefficients of ln p(t | S) - ln p(t | nothing), for one power S of the surface, in 1, t and ln t; t is a range
/// cell's mean power over the noise.
#[derive(Clone, Copy, Debug)]
struct Term {
    constant: f32,
    per_t: f32,
    per_ln_t: f32,
    /// Lower limits of t and ln t, below which the ratio is constant.
    least: (f32, f32),
}

impl Term {
    const ZERO: Self = Self {
        constant: 0.0,
        per_t: 0.0,
        per_ln_t: 0.0,
        least: (0.0, 0.0),
    };

    /// Returns the term of one complex look at a surface of power `s` over the noise: of exponential distributions.
    fn coherent(s: f32) -> Self {
        Self {
            constant: -math::ln(1.0 + s),
            per_t: s / (1.0 + s),
            per_ln_t: 0.0,
            least: (0.0, f32::MIN),
        }
    }

    /// Returns the term of a surface of power `s` over the noise, seen in `rows` independent rows and `speckles`
    /// independent speckle patterns.
    fn new(s: f32, rows: RowCount, speckles: f32) -> Self {
        let RowCount { n, constant } = rows;
        let mean = 1.0 + SHOWN * s;
        let var = (1.0 + 2.0 * SHOWN_IN_VARIANCE * s) / n + SHOWN * s * SHOWN * s / speckles;
        let (shape, scale) = (mean * mean / var, var / mean);
        let least_t = (n - shape) / (n - 1.0 / scale);
        Self {
            constant: constant - math::ln_gamma(shape) - shape * math::ln(scale),
            per_t: n - 1.0 / scale,
            per_ln_t: shape - n,
            least: (least_t, math::ln(least_t)),
        }
    }
}

/// Line powers by range cell, the nearest first, and the table of terms that evaluates them.
#[derive(Clone, Debug)]
pub struct Lines {
    pub(super) cells: heapless::Vec<RangeCell, CELLS>,
    terms: [Term; POWERS],
    /// Range of the first evaluated cell from the mirror, metres.
    pub(super) first_m: f32,
    /// Spacing of the range cells, metres.
    pub(super) step_m: f32,
    /// Height of the mirror above the ground, metres.
    pub height_m: f32,
    /// Slope of the ground.
    bend: Slope,
    /// Number of independent rows that see a line in one sweep.
    pub(super) rows: f32,
    /// Gain of a coherent look over one row's cell; 0 for looks at the power of rows.
    pub(super) coherent_gain: f32,
}

impl Default for Lines {
    fn default() -> Self {
        Self::new()
    }
}

impl Lines {
    /// Returns the state without cells. All bits are zero, so that it is no constant in flash.
    pub const fn new() -> Self {
        Self {
            cells: heapless::Vec::new(),
            terms: [Term::ZERO; POWERS],
            first_m: 0.0,
            step_m: 0.0,
            height_m: 0.0,
            bend: Slope {
                from_m: 0.0,
                slope: 0.0,
            },
            rows: 0.0,
            coherent_gain: 0.0,
        }
    }

    /// Evaluates the lines along the ground and below it, in all range cells of a scan.
    #[inline(never)]
    pub fn look(&mut self, chart: &Chart<'_>) {
        self.coherent_gain = chart.image.map_or(0.0, |image| image.gain());
        self.fill(&Gaze::new(chart), FARTHEST_M, |gaze, bin, range_m| {
            gaze.cell(bin, range_m)
        });
        self.settle(1.0, 1.0);
    }

    /// Fills the cells by `cell`, called with each bin and its range, metres. [`Lines::settle`] must follow.
    pub(super) fn fill(
        &mut self,
        gaze: &Gaze<'_>,
        farthest_m: f32,
        mut cell: impl FnMut(&Gaze<'_>, usize, f32) -> RangeCell,
    ) {
        let chart = gaze.chart;
        let geometry = chart.map.geometry();
        self.rows = match chart.image {
            Some(_) => 1.0,
            None => WORTH * LINE_REACH * gaze.sigma_rows,
        };
        self.cells.clear();
        self.height_m = gaze.height_m;
        self.bend = chart.bend;
        // `as` saturates.
        let bins = (math::round(CELL_M / geometry.bin_m) as usize).max(1);
        self.step_m = geometry.bin_m * bins as f32;
        let nearest_m = math::hypot(NEAREST_M, self.height_m);
        for bin in (0..chart.map.bins()).step_by(bins) {
            let range_m = geometry.range_m(bin as f32);
            if range_m < nearest_m {
                continue;
            }
            if self.cells.is_empty() {
                self.first_m = range_m;
            }
            if range_m > farthest_m || self.cells.push(cell(gaze, bin, range_m)).is_err() {
                break;
            }
        }
    }

    /// Computes the table of terms for cells that are means over `sweeps` sweeps with `speckles` independent speckle
    /// patterns.
    pub(super) fn settle(&mut self, sweeps: f32, speckles: f32) {
        let rows = RowCount::new(self.rows * sweeps);
        for (k, term) in self.terms.iter_mut().enumerate() {
            let s = math::power_ratio(FIRST_DB + STEP_DB * k as f32);
            *term = match self.coherent_gain > 0.0 {
                true => Term::coherent(self.coherent_gain * s),
                false => Term::new(s, rows, speckles),
            };
        }
    }

    /// Returns the line powers by range cell, the nearest first.
    pub fn cells(&self) -> &[RangeCell] {
        &self.cells
    }

    /// Returns the quantised power over the noise along the ground in range cell `b`; not seen beyond the last cell.
    pub fn ground(&self, b: usize) -> Power {
        self.cells.get(b).map_or(Power::default(), |c| c.ground)
    }

    /// Returns the quantised power over the noise in range cell `b` along lower ground of depth number `k` of
    /// [`DEPTHS_M`](super::power::DEPTHS_M).
    pub fn lower(&self, b: usize, k: usize) -> Power {
        let power = self.cells.get(b).and_then(|c| c.lower.get(k));
        power.copied().unwrap_or_default()
    }

    /// Returns the range of cell `b`, metres.
    pub fn range_m(&self, b: usize) -> f32 {
        self.first_m + self.step_m * b as f32
    }

    /// Returns the horizontal distance from the mirror at which a range, metres, meets the ground, metres.
    pub fn x_m(&self, range_m: f32) -> f32 {
        self.bend.reach_m(range_m, self.height_m)
    }

    /// Returns the index of the cell at a range, metres; the number of cells if it is farther.
    pub fn at(&self, range_m: f32) -> usize {
        // `as` saturates.
        let b = math::round((range_m - self.first_m) / self.step_m) as usize;
        b.min(self.cells.len())
    }

    /// Returns the likelihood ratio of a line's power `shown` with a surface of power `s_db`, dB over the noise, to
    /// that without one; 1 where the line is not seen.
    #[inline]
    pub fn ratio(&self, shown: Shown, s_db: f32) -> f32 {
        let place = (s_db - shown.leaks_db - FIRST_DB) * (1.0 / STEP_DB) + 0.5;
        // What is not seen says nothing, and a surface so dark shows nothing.
        if shown.t <= 0.0 || place < 0.0 {
            return 1.0;
        }
        // `as` saturates.
        let Some(term) = self.terms.get((place as usize).min(POWERS - 1)) else {
            return 1.0;
        };
        let (least_t, least_ln_t) = term.least;
        let nats = term.constant
            + term.per_t * math::max(shown.t, least_t)
            + term.per_ln_t * math::max(shown.ln_t, least_ln_t);
        math::exp(math::min(nats, MAX_NATS))
    }
}

#[cfg(test)]
mod tests {
    use super::super::gaze::WEIGHTS;
    use super::*;

    /// Number of independent rows that see a line with the paper's instrument.
    const ROWS: f32 = WORTH * LINE_REACH * 6.0;

    fn nats(term: Term, t: f32) -> f32 {
        let (least_t, least_ln_t) = term.least;
        term.constant + term.per_t * t.max(least_t) + term.per_ln_t * t.ln().max(least_ln_t)
    }

    #[test]
    fn power_ratio_grows_with_power_and_is_below_one_for_noise() {
        for s_db in [-3.0, 3.0, 9.0] {
            let s = math::power_ratio(s_db);
            let term = Term::new(s, RowCount::new(ROWS), 1.0);
            let reported = [0.2, 0.6, 1.0, 1.3, 2.0, 4.0].map(|t| nats(term, t));
            assert!(reported.is_sorted(), "{s_db}: {reported:?}");
            assert!(nats(term, 1.0) < 0.0, "{s_db}");
            assert!(nats(term, 1.0 + s) > 0.0, "{s_db}");
        }
    }

    #[test]
    fn a_term_is_the_ratio_of_two_densities() {
        // Over all t, p(t | nothing) times the ratio is a density again, but for the part below `least`.
        for s_db in [-6.0, 0.0, 6.0] {
            let term = Term::new(math::power_ratio(s_db), RowCount::new(ROWS), 1.0);
            let n = f64::from(ROWS);
            let ln_gamma = f64::from(math::ln_gamma(ROWS));
            let step = 0.005;
            let sum: f64 = (1..8000)
                .map(|k| {
                    let t = step * f64::from(k);
                    let nothing = n * n.ln() - ln_gamma + (n - 1.0) * t.ln() - n * t;
                    let ratio = f64::from(term.constant)
                        + f64::from(term.per_t) * t
                        + f64::from(term.per_ln_t) * t.ln();
                    step * (nothing + ratio).exp()
                })
                .sum();
            assert!((sum - 1.0).abs() < 0.02, "{s_db}: {sum}");
        }
    }

    #[test]
    fn weights_sum_to_their_stated_constants() {
        let steps = 20_000;
        let mean = |f: &dyn Fn(f64) -> f64| -> f64 {
            let all = (0..steps).map(|k| f((f64::from(k) + 0.5) / f64::from(steps)));
            all.sum::<f64>() / f64::from(steps)
        };
        let w = |t: f64| (1.0 - t * t).powi(2);
        let beam = |t: f64| (-0.5 * (t * f64::from(LINE_REACH)).powi(2)).exp();
        let (sum, squares) = (mean(&w), mean(&|t| w(t) * w(t)));
        let close = |a: f64, b: f32| (a - f64::from(b)).abs() < 1e-3;
        assert!(close(2.0 * sum, WEIGHTS));
        assert!(close(2.0 * sum * sum / squares, WORTH));
        assert!(close(mean(&|t| w(t) * beam(t)) / sum, SHOWN));
        assert!(close(
            mean(&|t| w(t) * w(t) * beam(t)) / squares,
            SHOWN_IN_VARIANCE
        ));
    }
}
