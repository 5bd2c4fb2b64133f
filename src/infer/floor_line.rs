//! What the ground shows along its line, and where it is missing.
//!
//! Few places of a floor stand out as echoes, and none do where it fades; but the power along the line on which
//! it must lie, summed over a beam's width, exceeds what the same ranges show above it as long as there is a
//! floor at all. Where the ground ends, or a hole begins, that power falls to what shows above at once and stays
//! there. How likely the one is beside the other is told for each cell of the way.

use super::chart::Chart;
use super::cloud::{CELL_M, CELLS, FIRST_END_M};
use crate::math;
use crate::params::Params;
use crate::signal::grid::{EIGHTHS, UNITS_PER_OCTAVE};

/// The line is cut into slots of this length, metres: half a cell.
const SLOT_M: f32 = 0.5 * CELL_M;
/// Slots of a cell.
const PER_CELL: usize = 2;
/// Where the first slot begins, metres: the end of a cell, from where on the lowest angles show a floor.
const FIRST_M: f32 = 0.3;
/// Slots: as far as the range reaches.
const SLOTS: usize = 48;
/// No cell before this one has a window of its own: it ends half a slot behind [`FIRST_M`] at least.
pub const NEAREST_END_M: f32 = 0.45;
/// Levels that a cell of the map can have.
const LEVELS: usize = 256;
/// A mean of exponentially distributed powers over their median, 1 / ln 2.
const MEAN_PER_MEDIAN: f32 = core::f32::consts::LOG2_E;
/// Each slot is looked at in so many places, 2.5 cm apart: nearly two range bins.
const PARTS: usize = 2;
/// Rows up to so many standard deviations of the two-way beam off the line see the floor …
const REACH: f32 = 2.5;
/// … with weights (1 - t²)² that add up to so many rows for each of the reach …
const WEIGHTS: f32 = 16.0 / 15.0;
/// … of which so much must have arrived.
const LEAST_SHARE: f32 = 1.0 / 3.0;
/// Rows farther above the line than this see none of it, standard deviations of the two-way beam …
const CLEAR_OF: f32 = 4.5;
/// … and are compared with it if there are so many …
const LEAST_ABOVE: usize = 20;
/// … of which no more than so many are looked at.
const MOST_ABOVE: usize = 64;
/// The floor ahead is predicted from what the last 20 cm before show, or from the 20 cm before these: slots.
const BEFORE: [(usize, usize); 2] = [(5, 1), (9, 5)];
/// Where the floor behind a cell's end shows that it goes on: slots.
const BEYOND: (usize, usize) = (2, 6);
/// The noise of a bin is no less than this share of the map's.
const LEAST_NOISE: f32 = 0.8;
/// Sums over windows may go this far beyond what their mean is cut off at, nats.
const MARGIN: f32 = 12.0;
/// A gap is as long as so many cells: from the shortest in which a wheel is lost to one without end.
const LENGTHS: [usize; 4] = [2, 3, 4, 6];

/// Power along the line and above it, over the noise, summed over the bins of a slot.
#[derive(Clone, Copy, Debug, Default)]
struct LineSlot {
    line: f32,
    above: f32,
}

/// What the ground shows.
#[derive(Debug)]
pub struct FloorLine {
    slots: [LineSlot; SLOTS],
    /// See [`Shown::gap`].
    gaps: [[f32; 2]; CELLS],
    /// How many rows show each level; all 0 but while they are counted.
    counts: [u8; LEVELS],
}

/// What the ground shows of a cell.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shown {
    /// How much likelier a gap is that begins in this cell, or 5 cm behind it, than a floor that goes on, nats.
    pub gap: [f32; 2],
    /// Power along the line over what shows above it, between 10 and 30 cm behind the cell's end, dB.
    pub beyond_db: f32,
}

impl FloorLine {
    /// Of no map.
    pub const fn new() -> Self {
        Self {
            slots: [LineSlot {
                line: 0.0,
                above: 0.0,
            }; SLOTS],
            gaps: [[0.0; 2]; CELLS],
            counts: [0; LEVELS],
        }
    }

    /// Looks along the ground in front of the chair.
    #[inline(never)]
    pub fn look(&mut self, chart: &Chart<'_>, p: &Params) {
        for (k, slot) in self.slots.iter_mut().enumerate() {
            *slot = LineSlot::default();
            for part in 0..PARTS {
                let x_m = FIRST_M + SLOT_M * (k as f32 + (part as f32 + 0.5) / PARTS as f32);
                if let Some(seen) = chart.ground(x_m, &mut self.counts) {
                    slot.line += seen.line;
                    slot.above += seen.above;
                }
            }
        }
        for k in 0..CELLS {
            let gap = end_of(k).map_or([0.0; 2], |end| [0, 1].map(|later| self.gap(end, later, p)));
            if let Some(place) = self.gaps.get_mut(k) {
                *place = gap;
            }
        }
    }

    /// Power along the line over what shows above it, from slot `first` up to `end`; 1 where nothing is seen.
    #[inline(never)]
    fn over(&self, first: usize, end: usize) -> f32 {
        let slots = self.slots.get(first..end.min(SLOTS)).unwrap_or(&[]);
        let (line, above) = slots
            .iter()
            .fold((0.0, 0.0), |(l, a), s| (l + s.line, a + s.above));
        if above > 0.0 { line / above } else { 1.0 }
    }

    /// How much likelier a gap is that begins before slot `end` + `later` than a floor that goes on, nats: the mean
    /// over gaps of several lengths.
    #[inline(never)]
    fn gap(&self, end: usize, later: usize, p: &Params) -> f32 {
        let mut before: f32 = 0.0;
        for (from, to) in BEFORE {
            let fall_db = p.floor_fall_db * (to / PER_CELL) as f32;
            let seen = self.over(end.saturating_sub(from), end.saturating_sub(to)) - 1.0;
            before = math::max(before, seen * math::power_ratio(-fall_db));
        }
        let (mut nats, mut begins, mut sum) = (0.0, 0.0, 0.0);
        for k in 0..LENGTHS[LENGTHS.len() - 1] {
            let first = end + later + PER_CELL * k;
            if first + PER_CELL <= SLOTS {
                let cells = (k + 1) as f32 + 0.5 * later as f32;
                let fall = math::power_ratio(-p.floor_fall_db * cells);
                let spread_db = p.floor_spread_db + p.floor_spread_more_db * k as f32;
                nats += missing(
                    self.over(first, first + PER_CELL),
                    before * fall,
                    spread_db,
                    p,
                );
            }
            if k == 0 {
                begins = nats;
            }
            if LENGTHS.contains(&(k + 1)) {
                sum += math::exp(within(nats, p.gap_nats + MARGIN));
            }
        }
        let mean = math::ln(sum / LENGTHS.len() as f32);
        // Where its first 10 cm show floor none begins, whatever is missing farther on.
        let least = if begins < 0.0 {
            math::min(mean, begins)
        } else {
            mean
        };
        within(least, p.gap_nats)
    }

    /// What the ground shows of cell `k`.
    pub fn cell(&self, k: usize) -> Shown {
        let Some(end) = end_of(k) else {
            return Shown::default();
        };
        Shown {
            gap: self.gaps.get(k).copied().unwrap_or_default(),
            beyond_db: decibels(self.over(end + BEYOND.0, end + BEYOND.1)),
        }
    }
}

/// A number brought between `-limit` and `limit`.
fn within(x: f32, limit: f32) -> f32 {
    math::min(math::max(x, -limit), limit)
}

/// The slot that begins where cell `k` ends, if it has windows of its own.
fn end_of(k: usize) -> Option<usize> {
    let end_m = FIRST_END_M + CELL_M * k as f32;
    let slot = math::round((end_m - FIRST_M) / SLOT_M);
    (end_m >= NEAREST_END_M && slot < SLOTS as f32).then_some(slot as usize)
}

/// A power ratio in decibels, not below -3.
#[inline(never)]
fn decibels(ratio: f32) -> f32 {
    math::DB_PER_OCTAVE * math::log2(math::max(ratio, 0.5))
}

/// How much likelier the power of a window is without floor than with one that shows `expected` times the
/// noise but for `spread_db`, nats.
#[inline(never)]
fn missing(over: f32, expected: f32, spread_db: f32, p: &Params) -> f32 {
    let over_db = decibels(over);
    let expected_db = decibels(1.0 + expected);
    // A floor as strong as noise varies half as much with the noise added.
    let sigma_db = math::hypot(p.gap_sigma_db, spread_db * expected / (1.0 + expected));
    let density = |off_db: f32, sigma_db: f32| {
        let z = off_db / sigma_db;
        math::exp(-0.5 * z * z) / sigma_db + p.gap_outlier_share
    };
    let ratio = density(over_db, p.gap_sigma_db) / density(over_db - expected_db, sigma_db);
    math::ln(ratio)
}

impl Chart<'_> {
    /// What shows on the ground at `x_m` and above it; `None` where nothing of it can be seen. `counts` is room to
    /// work in, all 0.
    #[inline(never)]
    fn ground(&self, x_m: f32, counts: &mut [u8; LEVELS]) -> Option<LineSlot> {
        let geometry = self.map.geometry();
        let down_m = geometry.mount_height_m - self.height_m;
        let step_rad = math::max(geometry.step_rad, f32::MIN_POSITIVE);
        let first_rad = self.map.angle_rad(0) - self.bias_rad;
        let row_of = |x_m: f32| (math::atan2(down_m, x_m) - first_rad) / step_rad;
        // Where the chair was and how it pitched while it looked there.
        let (x_m, seen) = self.ride.map_or((x_m, row_of(x_m)), |ride| {
            let at = ride.at(row_of(x_m));
            let x_m = x_m + ride.end().travel_m - at.travel_m;
            (x_m, row_of(x_m) + at.pitch_rad / step_rad)
        });
        let range_m = math::hypot(x_m, down_m);
        // `as` saturates, and beyond the last bin nothing has arrived.
        let bin = math::round((range_m - geometry.first_range_m) / geometry.bin_m) as usize;
        let sigma_rows = self.sigma_rad() / step_rad;
        let line = self.along(bin, seen, sigma_rows)?;
        let above = self.above(bin, seen - CLEAR_OF * sigma_rows, counts)?;
        Some(LineSlot { line, above })
    }

    /// The cells of a bin that have arrived, every `stride` rows from row `first` up to `end`: row and level. A row
    /// that was lost is all 0, which noise is not.
    fn seen(
        &self,
        bin: usize,
        (first, end): (usize, usize),
        stride: usize,
    ) -> impl Iterator<Item = (usize, u8)> {
        let bins = self.map.bins();
        let cells = self.map.from(first, bin).filter(|_| bin < bins);
        let cells = cells.unwrap_or(&[]).iter();
        let rows = (first..end.min(self.map.rows())).step_by(stride.max(1));
        let pairs = rows.zip(cells.step_by((stride * bins).max(1)));
        pairs
            .filter(|(_, level)| **level > 0)
            .map(|(row, &level)| (row, level))
    }

    /// Power over the noise of a bin around row `middle`, weighted like the two-way beam.
    #[inline(never)]
    fn along(&self, bin: usize, middle: f32, sigma_rows: f32) -> Option<f32> {
        let reach = REACH * sigma_rows;
        let per_reach = 1.0 / math::max(reach, f32::MIN_POSITIVE);
        let (mut power, mut weight) = (0.0, 0.0);
        // `as` saturates.
        let first = math::ceil(middle - reach) as usize;
        let end = math::ceil(middle + reach) as usize;
        for (row, level) in self.seen(bin, (first, end), 1) {
            let t = (row as f32 - middle) * per_reach;
            let w = (1.0 - t * t) * (1.0 - t * t);
            power += w * linear(level);
            weight += w;
        }
        (weight > LEAST_SHARE * WEIGHTS * reach).then(|| self.over_noise(power / weight))
    }

    /// The mean power over the noise that a bin shows in the rows before `end`, by their median, which what
    /// stands there moves little; at least nearly the noise.
    #[inline(never)]
    fn above(&self, bin: usize, end: f32, counts: &mut [u8; LEVELS]) -> Option<f32> {
        let end = (math::floor(end) as usize).min(self.map.rows());
        let (mut seen, mut lowest, mut highest) = (0, u8::MAX, 0);
        for (_, level) in self.seen(bin, (0, end), end.div_ceil(MOST_ABOVE)) {
            (lowest, highest) = (lowest.min(level), highest.max(level));
            if let Some(count) = counts.get_mut(usize::from(level)) {
                *count += 1;
                seen += 1;
            }
        }
        let (mut below, mut median) = (0, 0);
        let levels = counts.get_mut(lowest.into()..usize::from(highest) + 1);
        for (k, count) in levels.unwrap_or(&mut []).iter_mut().enumerate() {
            if 2 * below < seen {
                median = k;
            }
            below += usize::from(core::mem::take(count));
        }
        // Within a byte, as both are.
        let median = lowest.saturating_add(median as u8);
        (seen >= LEAST_ABOVE).then(|| {
            let mean = MEAN_PER_MEDIAN * self.over_noise(linear(median));
            math::max(mean, LEAST_NOISE)
        })
    }

    /// Power over the noise, of power as [`linear`] counts it.
    fn over_noise(&self, power: f32) -> f32 {
        power * math::exp2(-self.noise / f32::from(UNITS_PER_OCTAVE))
    }
}

/// Power of a cell, that of level 0 being 1.
fn linear(level: u8) -> f32 {
    /// Of the units of an octave.
    const FRACTIONS: [f32; UNITS_PER_OCTAVE as usize] = {
        let mut fractions = [0.0; UNITS_PER_OCTAVE as usize];
        let mut k = 0;
        while k < fractions.len() {
            fractions[k] = EIGHTHS[k] as f32 / EIGHTHS[0] as f32;
            k += 1;
        }
        fractions
    };
    /// An f32 of exponent 0 has this one …
    const BIAS: u32 = f32::MAX_EXP as u32 - 1;
    /// … over so many bits.
    const MANTISSA_BITS: u32 = f32::MANTISSA_DIGITS - 1;
    let (octave, eighth) = (level / UNITS_PER_OCTAVE, level % UNITS_PER_OCTAVE);
    let whole = f32::from_bits((u32::from(octave) + BIAS) << MANTISSA_BITS);
    FRACTIONS
        .get(usize::from(eighth))
        .map_or(whole, |f| whole * f)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Config;
    use crate::motion::{Drive, Input, Ride, RowPose, Track};
    use crate::signal::echoes::tests::{map, scene};
    use crate::signal::grid::PolarMap;

    const NOISE: f32 = 80.0;

    /// A floor of places 2 cm apart from 0.25 m to `end_m`, but for those in `hole`, that is `db` over the noise at
    /// 0.5 m and fades by 3 dB every 10 cm.
    fn floor(end_m: f32, hole: core::ops::Range<f32>, db: f64) -> Box<PolarMap> {
        let places = (0..120).map(|k| 0.25 + 0.02 * k as f32);
        let shown = places.filter(|x| *x < end_m && !hole.contains(x));
        let points: std::vec::Vec<_> = shown
            .map(|x| (x, 0.0, db - 30.0 * (f64::from(x) - 0.5)))
            .collect();
        scene(&Config::default(), &points)
    }

    fn chart(map: &PolarMap) -> Chart<'_> {
        Chart {
            map,
            noise: NOISE,
            bias_rad: 0.0,
            height_m: 0.0,
            ride: None,
        }
    }

    fn line(map: &PolarMap) -> FloorLine {
        let mut line = FloorLine::new();
        line.look(&chart(map), &Params::DEFAULT);
        line
    }

    /// The cell that ends at `end_m`.
    fn at(end_m: f32) -> usize {
        ((end_m - FIRST_END_M) / CELL_M).round() as usize
    }

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

    /// The likeliest gap up to cell `k`, nats.
    fn most(line: &FloorLine, k: usize) -> f32 {
        let gaps = (0..=k).flat_map(|k| line.cell(k).gap);
        gaps.fold(0.0, f32::max)
    }

    #[test]
    fn a_floor_that_goes_on_has_no_gap() {
        let line = line(&floor(2.5, 0.0..0.0, 30.0));
        for k in at(0.5)..=at(1.2) {
            let shown = line.cell(k);
            assert!(shown.beyond_db > 3.0, "{k}: {shown:?}");
            assert!(
                shown.gap[0] < -2.0 && most(&line, k) < 1.0,
                "{k}: {shown:?}"
            );
        }
    }

    #[test]
    fn where_the_floor_ends_is_a_gap_and_nothing_behind_it() {
        let line = line(&floor(0.97, 0.0..0.0, 25.0));
        for k in at(0.5)..=at(0.8) {
            assert!(most(&line, k) < 1.0, "{k}: {:?}", line.cell(k));
        }
        let edge = line.cell(at(1.0));
        assert!(edge.gap[0] > 4.0 && most(&line, at(1.0)) > 4.0, "{edge:?}");
        assert!(edge.beyond_db < 2.0, "{edge:?}");
        let behind = line.cell(at(1.4));
        assert!(behind.beyond_db.abs() < 2.0, "{behind:?}");
        assert!(most(&line, at(1.4)) > 4.0, "{behind:?}");
    }

    #[test]
    fn a_hole_is_a_gap_though_the_floor_goes_on() {
        let line = line(&floor(2.5, 0.75..1.05, 30.0));
        assert!(most(&line, at(0.8)) > 4.0, "{:?}", line.cell(at(0.8)));
        assert!(most(&line, at(0.6)) < 1.0, "{:?}", line.cell(at(0.6)));
    }

    #[test]
    fn where_nothing_is_seen_nothing_is_told() {
        let line = line(&scene(&Config::default(), &[]));
        for k in 0..CELLS {
            let shown = line.cell(k);
            assert!(
                shown.gap.iter().all(|gap| gap.abs() < 1.5),
                "{k}: {shown:?}"
            );
            assert!(shown.beyond_db.abs() < 2.0, "{shown:?}");
        }
        let far = line.cell(CELLS + 9);
        assert!(far.gap == [0.0; 2] && far.beyond_db.is_finite());
    }

    #[test]
    fn rows_that_are_lost_or_full_of_one_level_do_no_harm() {
        let mut blank = PolarMap::new();
        blank.begin(&Config::default()).unwrap();
        let full = map(&Config::default(), |_, _| u8::MAX);
        let empty = map(&Config::default(), |_, _| 0);
        for map in [&blank, &*full, &*empty] {
            let line = line(map);
            let told = (0..CELLS).map(|k| line.cell(k));
            for shown in told {
                let mut all = shown.gap.into_iter().chain([shown.beyond_db]);
                assert!(all.all(f32::is_finite));
            }
        }
        for (bias_rad, height_m) in [(f32::NAN, 0.0), (9.0, 0.0), (0.0, f32::NAN), (-9.0, 5.0)] {
            let mut line = FloorLine::new();
            let chart = Chart {
                bias_rad,
                height_m,
                ..chart(&full)
            };
            line.look(&chart, &Params::DEFAULT);
            assert!((0..CELLS).all(|k| most(&line, k).is_finite()));
        }
    }

    #[test]
    fn a_chair_that_drove_on_is_nearer_to_the_gap() {
        let map = floor(1.15, 0.0..0.0, 25.0);
        let mut track = Track::new();
        track.begin(map.rows() as u16);
        for row in 0..map.rows() as u16 {
            let place = RowPose {
                time_s: 0.005 * f32::from(row),
                // All of the way is made behind the row that looks at the end of the floor.
                travel_m: if row < 220 { 0.0 } else { 0.2 },
                pitch_rad: 0.0,
            };
            track.add(row, place);
        }
        let config = Config::default();
        let drive = Drive {
            input: Input::Good,
            track: Some(&track),
            ..Drive::STANDING
        };
        let mut line = FloorLine::new();
        let ride = Ride::of(&drive, &config.radar);
        line.look(
            &Chart {
                ride,
                ..chart(&map)
            },
            &Params::DEFAULT,
        );
        assert!(most(&line, at(0.8)) < 1.0, "{:?}", line.cell(at(0.8)));
        assert!(most(&line, at(1.0)) > 4.0, "{:?}", line.cell(at(1.0)));
    }
}
