//! Looks at a surface: from a place on it to the power there, in the coherent image or in the map's rows.
//!
//! In the map, leakage of a cell's strongest row into its other rows counts as noise: side lobes everywhere, and the beam's
//! flank near it. In the image CLEAN has taken it out.

use super::chart::Chart;
use super::power::{DEPTHS_M, Power, RangeCell};
use crate::math;
use crate::params::ground_line::{ITSELF, LINE_REACH, MIN_SHARE, OFF_M, SIDE_LOBES};
use crate::signal::grid::{EIGHTHS, UNITS_PER_OCTAVE};
use crate::signal::image::Cleaned;

/// Sum of the rows' weights (1 - t²)² in the mean along a line, per row of its half-width; t is a row's offset from the
/// line over the half-width.
pub(super) const WEIGHTS: f32 = 16.0 / 15.0;
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

/// A map with mirror height, angles, beam width in rows and noise, from which the powers along its lines are computed.
pub(super) struct Gaze<'c> {
    pub(super) chart: &'c Chart<'c>,
    pub(super) height_m: f32,
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
    pub(super) fn cell(&self, bin: usize, range_m: f32) -> RangeCell {
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
        let level_m = self.height_m - y_m;
        let squared = range_m * range_m - level_m * level_m;
        if squared < STEEPEST * range_m * range_m {
            return None;
        }
        let x_m = self.chart.bend.reach_m(range_m, level_m);
        let down_m = level_m - self.chart.bend.height_m(x_m);
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
}
