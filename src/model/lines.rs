//! Power along lines: what a range cell shows of a surface that lies at a level.
//!
//! All rows that look at one place of a surface share its speckle. The power of a range cell, summed over the rows
//! with the two-way beam's weight, therefore shows a surface at a level even where no single cell stands out. With t
//! that mean over the noise, n the number of independent rows, and S the surface's mean power over the noise, which
//! speckle makes exponentially distributed,
//!
//! ```text
//! E t = 1 + a S,   var t = (1 + 2 b S) / n + (a S)²,   p(t | S) = Gamma(t; both),   p(t | nothing) = Gamma(t; 1, 1/n)
//! ln p(t | S) - ln p(t | nothing) = c(S) + d(S) t + e(S) ln t
//! ```
//!
//! Leakage of a cell's strongest row into its other rows counts as noise: side lobes everywhere, and the beam's flank
//! near it.

use super::chart::Chart;
use crate::math;
use crate::params::ground_line::{
    FARTHEST_M, ITSELF, LINE_REACH, MAX_NATS, MIN_SHARE, NEAREST_M, OFF_M, SIDE_LOBES,
};
use crate::signal::grid::{EIGHTHS, UNITS_PER_OCTAVE};
use crate::signal::image::Cleaned;

/// Depths below the ground of the lines of lower ground, metres: from the smallest drop that matters to a wheelchair
/// to a step.
pub const DEPTHS_M: [f32; 4] = [0.05, 0.08, 0.12, 0.17];
/// Spacing of the evaluated range cells, metres, or a range bin if that is longer: nearer ones share the window's main
/// lobe.
const CELL_M: f32 = 0.0235;
/// Maximum number of evaluated range cells.
pub const CELLS: usize = 64;
/// Sum of the rows' weights (1 - t²)² in the mean along a line, per row of its half-width; t is a row's offset from the
/// line over the half-width.
const WEIGHTS: f32 = 16.0 / 15.0;
/// Number of independent rows in the mean along a line, per row of its half-width: (Σw)² / Σw² of the weights w.
const WORTH: f32 = 1.4;
/// Factor of a surface's power S in the weighted mean along its line, Σwg / Σw for the two-way beam g.
const SHOWN: f32 = 0.709;
/// Factor of a surface's power S in the variance of each row, Σw²g / Σw².
const SHOWN_IN_VARIANCE: f32 = 0.792;
/// Maximum step of the search for a cell's strongest row, rows; the step is one standard deviation of the beam if that
/// is less.
const STRIDE: usize = 4;
/// Minimum power of a range cell's strongest row that counts as an echo, as a ratio to the noise: twice ln 70, about
/// the maximum of 70 rows of noise.
const FAINT: f32 = 8.0;
/// Exponent of a Gaussian beam seen through one like it: exp(-d²/4) at d standard deviations.
pub(super) const FLANK: f32 = 0.25;
/// Minimum squared cosine of a line's angle below the horizontal: no scan looks down more steeply.
const STEEPEST: f32 = 0.1;
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

/// Power of a range cell along one line of a surface, quantised.
#[derive(Clone, Copy, Debug, Default)]
pub struct Power {
    /// Mean power t over the noise as raised by leakage, quarters of a decibel above [`Power::MIN_DB`]; 0 where the
    /// line is not seen.
    pub(super) t: u8,
    /// Factor by which leakage of other rows increases the noise's power, quarters of a decibel; 0 for none.
    pub(super) leaks: u8,
}

impl Power {
    /// Quantisation steps of power and leakage per decibel.
    const PER_DB: f32 = 4.0;
    /// Lower limit of the quantised power t, dB over the noise.
    const MIN_DB: f32 = -12.0;
    /// Nats per decibel: ln 10 / 10.
    const NATS_PER_DB: f32 = core::f32::consts::LN_10 / 10.0;

    /// Returns the quantised power `t`, over a noise that leakage has raised by the ratio `leaks`.
    pub(super) fn new(t: f32, leaks: f32) -> Self {
        let db = |ratio: f32| math::DB_PER_OCTAVE * math::log2(math::max(ratio, f32::MIN_POSITIVE));
        // `as` saturates.
        Self {
            t: math::max(math::round((db(t) - Self::MIN_DB) * Self::PER_DB), 1.0) as u8,
            leaks: math::round(db(leaks) * Self::PER_DB) as u8,
        }
    }

    /// Power of a line that is not seen.
    pub(super) const DARK: Self = Self { t: 0, leaks: 0 };

    /// Returns the stronger of two line powers.
    pub(super) fn brighter(self, other: Self) -> Self {
        if other.t > self.t { other } else { self }
    }

    /// Returns power and leakage in floating point.
    pub fn shown(self) -> Shown {
        let t_db = Self::MIN_DB + f32::from(self.t) * (1.0 / Self::PER_DB);
        let ln_t = t_db * Self::NATS_PER_DB;
        Shown {
            t: if self.t == 0 { 0.0 } else { math::exp(ln_t) },
            ln_t,
            leaks_db: f32::from(self.leaks) * (1.0 / Self::PER_DB),
        }
    }
}

/// Power of a range cell along one line, and its leakage, in floating point.
#[derive(Clone, Copy, Debug)]
pub struct Shown {
    /// Mean power t, as a ratio to the noise with its leakage; 0 where the line is not seen.
    pub(super) t: f32,
    ln_t: f32,
    leaks_db: f32,
}

impl Shown {
    /// Returns whether the line is seen.
    pub fn is_seen(self) -> bool {
        self.t > 0.0
    }
}

/// Powers over the noise of a range cell along the lines of the ground and of lower ground.
#[derive(Clone, Copy, Debug)]
pub struct RangeCell {
    /// Power over the noise along the strongest of three lines: at the ground's height, slightly below and slightly
    /// above it.
    pub ground: Power,
    /// Powers over the noise along the lines of lower ground, in the order of their depths [`DEPTHS_M`].
    pub lower: [Power; DEPTHS_M.len()],
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
    /// [`DEPTHS_M`].
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
        let squared = range_m * range_m - self.height_m * self.height_m;
        math::sqrt(math::max(squared, 0.0))
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

/// A map with mirror height, angles, beam width in rows and noise, from which the powers along its lines are computed.
pub(super) struct Gaze<'c> {
    chart: &'c Chart<'c>,
    height_m: f32,
    first_rad: f32,
    step_rad: f32,
    pub(super) sigma_rows: f32,
    /// Reciprocal of the noise's mean power, in units of the power of a map cell of level 0.
    per_noise: f32,
}

impl<'c> Gaze<'c> {
    pub(super) fn new(chart: &'c Chart<'c>) -> Self {
        let geometry = chart.map.geometry();
        let step_rad = math::max(geometry.step_rad, f32::MIN_POSITIVE);
        Self {
            chart,
            height_m: geometry.mount_height_m - chart.height_m,
            first_rad: chart.map.angle_rad(0) - chart.bias_rad,
            step_rad,
            sigma_rows: chart.sigma_rad() / step_rad,
            per_noise: math::exp2(-chart.noise / f32::from(UNITS_PER_OCTAVE)),
        }
    }

    /// Returns the line powers of a range cell, at range bin `bin` and range `range_m`, metres.
    #[inline(never)]
    fn cell(&self, bin: usize, range_m: f32) -> RangeCell {
        if let Some(image) = &self.chart.image {
            return RangeCell {
                ground: self.look(image, range_m, 0.0),
                lower: DEPTHS_M.map(|depth_m| self.look(image, range_m, -depth_m)),
            };
        }
        let cell = LookedCell::new(self, bin, range_m);
        RangeCell {
            ground: cell.ground(),
            lower: DEPTHS_M.map(|depth_m| cell.line(cell.seen(-depth_m))),
        }
    }

    /// Returns what the image shows at range `range_m` of a surface at height `y_m` above the ground, metres.
    #[inline(never)]
    fn look(&self, image: &Cleaned<'_>, range_m: f32, y_m: f32) -> Power {
        let look = self.place(range_m, y_m).and_then(|(bin, row)| {
            image.look(
                bin,
                self.first_rad + self.chart.bias_rad + row * self.step_rad,
            )
        });
        look.map_or(Power::DARK, |look| Power::new(look.power, look.background))
    }

    /// Returns range bin and (fractional) row in which a surface at height `y_m` above the ground, metres, was seen;
    /// `range_m` is its range from the mirror's present position. `None` if the line of sight is too steep.
    fn place(&self, range_m: f32, y_m: f32) -> Option<(usize, f32)> {
        let geometry = self.chart.map.geometry();
        let down_m = self.height_m - y_m;
        let squared = range_m * range_m - down_m * down_m;
        if squared < STEEPEST * range_m * range_m {
            return None;
        }
        let x_m = math::sqrt(squared);
        let row_of = |x_m: f32| (math::atan2(down_m, x_m) - self.first_rad) / self.step_rad;
        // Where the chair was and how it pitched while it looked there.
        let (x_m, row) = self.chart.ride.map_or((x_m, row_of(x_m)), |ride| {
            let at = ride.at(row_of(x_m));
            let x_m = x_m + ride.end().travel_m - at.travel_m;
            (x_m, row_of(x_m) + at.pitch_rad / self.step_rad)
        });
        let bin = (math::hypot(x_m, down_m) - geometry.first_range_m) / geometry.bin_m;
        // `as` saturates, and beyond the last bin nothing has arrived.
        Some((math::round(bin) as usize, row))
    }

    /// Returns the index of the strongest row of a range bin, and that row's power as a ratio to the noise.
    fn strongest(&self, bin: usize) -> (f32, f32) {
        let map = self.chart.map;
        let bins = map.bins();
        let cells = map.from(0, bin).filter(|_| bin < bins).unwrap_or(&[]);
        // `as` saturates.
        let stride = (self.sigma_rows as usize).clamp(1, STRIDE);
        let rows = (0..map.rows()).step_by(stride);
        let cells = rows.zip(cells.iter().step_by((stride * bins).max(1)).copied());
        let (row, level) = cells.fold(
            (0, 0),
            |best, cell| if cell.1 > best.1 { cell } else { best },
        );
        (row as f32, linear(level) * self.per_noise)
    }

    /// Returns the mean power, as a ratio to the noise, of a range bin over the rows around `middle`, weighted like the
    /// two-way beam; `None` if too few rows were received.
    #[inline(never)]
    fn along(&self, bin: usize, middle: f32) -> Option<f32> {
        let reach = LINE_REACH * self.sigma_rows;
        let per_reach = 1.0 / math::max(reach, f32::MIN_POSITIVE);
        let (mut power, mut weight) = (0.0, 0.0);
        // `as` saturates.
        let first = math::ceil(middle - reach) as usize;
        let end = math::ceil(middle + reach) as usize;
        let (map, mut t) = (self.chart.map, (first as f32 - middle) * per_reach);
        let bins = map.bins();
        if bin >= bins {
            return None;
        }
        let rows = first..end.min(map.rows());
        let cells = map.from(first, bin).unwrap_or(&[]);
        for &level in cells.iter().step_by(bins).take(rows.len()) {
            let w = (1.0 - t * t) * (1.0 - t * t);
            t += per_reach;
            // A row that was lost is all 0, which noise is not.
            if level > 0 {
                power += w * linear(level);
                weight += w;
            }
        }
        (weight > MIN_SHARE * WEIGHTS * reach).then(|| power / weight * self.per_noise)
    }
}

/// A range cell under evaluation.
pub(super) struct LookedCell<'g> {
    pub(super) gaze: &'g Gaze<'g>,
    range_m: f32,
    /// Power along the ground's own line, as a ratio to the noise, and the (fractional) row of that line.
    pub(super) level: LineSeen,
    /// Index of the range cell's strongest row.
    row: f32,
    pub(super) strongest: f32,
    /// Power of the noise and of the strongest row's side lobes together, as a ratio to the noise.
    leaks: f32,
    /// Mean power around the strongest row, as a ratio to the noise; 0 if that row is noise.
    rival: f32,
}

/// Power along a line as a ratio to the noise, and the line's (fractional) row; `None` if the line is not seen.
pub(super) type LineSeen = Option<(f32, f32)>;

impl<'g> LookedCell<'g> {
    pub(super) fn new(gaze: &'g Gaze<'g>, bin: usize, range_m: f32) -> Self {
        // Where the chair drives, what stands at this range now was seen in another bin.
        let level = gaze.place(range_m, 0.0);
        let seen = level.map_or(bin, |(bin, _)| bin);
        let (row, strongest) = gaze.strongest(seen);
        let rival = if strongest > FAINT {
            gaze.along(seen, row).unwrap_or(0.0)
        } else {
            0.0
        };
        Self {
            gaze,
            range_m,
            level: level.and_then(|(bin, row)| Some((gaze.along(bin, row)?, row))),
            row,
            strongest,
            leaks: 1.0 + SIDE_LOBES * strongest,
            rival,
        }
    }

    /// Returns the power, as a ratio to the noise, along the line of a surface at height `y_m` above the ground,
    /// metres, and the line's row; `None` if the line is not seen.
    pub(super) fn seen(&self, y_m: f32) -> LineSeen {
        let (bin, row) = self.gaze.place(self.range_m, y_m)?;
        Some((self.gaze.along(bin, row)?, row))
    }

    /// Returns the quantised power of a line over the noise and its leakage; dark if the line was not seen.
    pub(super) fn line(&self, seen: LineSeen) -> Power {
        let Some((t, row)) = seen else {
            return Power::DARK;
        };
        let off = (row - self.row) / self.gaze.sigma_rows;
        let flank = if self.rival > t && off.abs() > ITSELF {
            math::max(self.rival / self.leaks - 1.0, 0.0) * math::exp(-FLANK * off * off)
        } else {
            0.0
        };
        let leaks = self.leaks * (1.0 + flank);
        Power::new(t / leaks, leaks)
    }

    /// Returns the quantised power along the strongest of three lines: the ground's own, one slightly below and one
    /// slightly above it.
    pub(super) fn ground(&self) -> Power {
        let below = self.line(self.seen(-OFF_M));
        let above = self.line(self.seen(OFF_M));
        self.line(self.level).brighter(below.brighter(above))
    }
}

/// Returns the power of a map cell of this level (unit 1/8 octave of power), as a ratio to the power of level 0.
fn linear(level: u8) -> f32 {
    POWERS_OF_LEVELS
        .get(usize::from(level))
        .copied()
        .unwrap_or(0.0)
}

/// Power of a map cell, as a ratio to that of level 0; the index is the cell's level (1/8 octave of power). See
/// [`linear`].
static POWERS_OF_LEVELS: [f32; 256] = {
    const OCTAVE: usize = UNITS_PER_OCTAVE as usize;
    let mut powers = [0.0; 256];
    let mut level = 0;
    while level < powers.len() {
        let fraction = EIGHTHS[level % OCTAVE] as f32 / EIGHTHS[0] as f32;
        powers[level] = fraction * (1_u32 << (level / OCTAVE)) as f32;
        level += 1;
    }
    powers
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_eighths_of_octaves() {
        assert!(
            (crate::signal::grid::DB_PER_UNIT * f32::from(UNITS_PER_OCTAVE) - math::DB_PER_OCTAVE)
                .abs()
                < 1e-4
        );
        for level in 0..=u8::MAX {
            let exact = (f64::from(level) / 8.0).exp2();
            let off = (f64::from(linear(level)) / exact - 1.0).abs();
            assert!(off < 1e-7, "{level}: {off}");
        }
    }

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

    #[test]
    fn powers_keep_a_quarter_of_a_decibel() {
        for t in [0.1_f32, 0.7, 1.0, 3.0, 40.0] {
            let shown = Power::new(t, 2.0).shown();
            let off_db = 10.0 * (shown.t / t).log10();
            assert!(
                off_db.abs() < 0.13 && (shown.leaks_db - 3.0).abs() < 0.13,
                "{t}: {off_db}"
            );
            assert!((shown.ln_t - shown.t.ln()).abs() < 1e-5);
        }
        assert!(Power::default().shown().t <= 0.0);
    }
}
