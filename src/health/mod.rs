//! Health checks of the instrument, gathered row by row: mirror, radar module and converter.
//!
//! A fault must end in no answer, not in a clear way, and rows that are not at their assumed angles must not
//! give `ok`. All checks concern the instrument and none the stairs, so they hold for every estimator.
//!
//! In: each row's chirp, statistics and cells. Out: [`Health::fault`], the reason for no answer, and
//! [`Health::failed_checks`], the reasons that prevent `ok`.
//!
//! | module | checks |
//! |---|---|
//! | this file | levels from row to row: noise, leakage and mirror echo, bursts of interference |
//! | `converter` | samples: stuck bits, offset drift, clipping, repeated chirps |
//! | `turning` | the map: echoes change with the angle as a turning mirror makes them |
//! | `phases` | phases: the chair stands, or moves as its motion input has it |
//! | `mirror` | range and level of the mirror's own echo over the whole scan |

mod check;
mod converter;
mod mirror;
mod phases;
mod turning;

use crate::Iq;
use crate::config::{Config, RadarConfig};
use crate::drive::PhaseAgreement;
use crate::params::Numbers;
use crate::params::health::{MAX_BURST_ROWS, MAX_IMAGE_SHARE, RUNNING_MEAN, SAMPLES_PER_SATURATED};
use crate::signal::grid::{DB_PER_UNIT, PolarMap};
use crate::signal::range::{FULL_SCALE, RowStats};
use crate::track::Track;
use crate::verdict::{Reason, Reasons};
pub use check::CheckResult;
use check::{PER_CENT, units};
use converter::Converter;
pub use mirror::MirrorEcho;
use phases::Phases;
use turning::Turning;

/// Row interval of the scan's noise histogram: every eighth row is counted.
const NOISE_ROWS: u16 = 8;
/// Cell interval of the scan's noise histogram: every third cell of a counted row.
const NOISE_CELLS: usize = 3;
/// Maximum swing of I and Q around their means when the converter has no input signal, units of a sample: its own
/// rounding.
const SILENT_SWING: u16 = 1;
/// Minimum mean level of the mirror's echo above the noise, map units (9 dB); below it the echo is missing. With noise
/// alone the strongest of the few bins where it is searched is some 4 dB above the median.
const MIRROR_ABOVE_NOISE: u32 = 24;
/// Minimum level of an echo above the median cell, map units (15 dB). Noise exceeds it in fewer than one in
/// 50,000 of the largest maps (65,536 cells).
const ECHO_ABOVE_NOISE: u8 = 40;
/// Number of samples of a chirp that are compared with those of the chirp before: all equal means that the radar
/// repeats a chirp.
const PROBES: usize = 4;
/// Cell interval of the histogram that gives one row's noise: every sixth cell is counted.
const CELL_STRIDE: usize = 6;
/// Width of a class of the histogram of one row's noise, as a power of two: 4 map units, 1.5 dB.
const CLASS_SHIFT: u32 = 2;
/// Number of values that a cell of the map can take: one byte.
const CELL_VALUES: usize = 256;
/// Number of steps per map unit in which the running mean of the noise counts, and per range bin in which the offset of
/// the mirror's echo counts.
const SIXTEENTHS: i32 = 16;
/// Reciprocal of the quantile of a row's cells that is taken as its noise: the lower quartile, which echoes do not
/// reach.
const QUARTER: usize = 4;

/// Conditions of a scan under which some checks do not apply.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Expected {
    /// The chair is known to move: the echoes' phases change from row to row.
    pub moving: bool,
    /// The scan is for calibration: range and level of the mirror's echo are not known yet.
    pub uncalibrated: bool,
}

/// Health checks of one scan: state that is gathered from row to row.
#[derive(Clone, Debug)]
pub struct Health {
    rows: u32,
    samples: u32,
    saturated: u32,
    silent: u32,
    frozen: u32,
    mirror: u32,
    probes: [Iq; PROBES],
    converter: Converter,
    levels: Levels,
    turning: Turning,
    phases: Phases,
    /// Histogram of the scan's noise: number of counted cells by value, from every [`NOISE_ROWS`]th row.
    cells: [u16; CELL_VALUES],
    numbers: Numbers,
}

/// Checks of signal levels (logarithmic power) from row to row: noise, leakage and mirror echo; levels in map units.
#[derive(Clone, Debug)]
struct Levels {
    /// Power level of the strongest self-echo (leakage or mirror) in the scan's first row, map units.
    self_echo: i32,
    /// Number of rows whose strongest self-echo differs from the first row's by more than `inside_drift_db`.
    self_echo_drifts: u32,
    /// Running mean of the rows' noise, 1/16 map unit, and number of rows so far in the current burst of interference.
    noise: i32,
    burst_rows: u32,
    /// Number of rows that were left out of the map because of a burst of interference.
    bursts: u32,
    /// Numbers of rows in which the I/Q image of the mirror's echo is as strong as the echo, in which it is stronger,
    /// and in which it is less than `image_db` weaker.
    image_equal: u32,
    image_stronger: u32,
    images: u32,
    /// Sum over the rows of the mirror echo's peak range minus the range expected by the mirror's offset, 1/16 bin.
    place: i32,
    /// Number of rows with an obstruction: an echo between mirror and map's first bin that exceeds the mirror's own.
    blocked: u32,
    numbers: Numbers,
}

impl Levels {
    const fn new(numbers: Numbers) -> Self {
        Self {
            self_echo: 0,
            self_echo_drifts: 0,
            noise: 0,
            burst_rows: 0,
            bursts: 0,
            image_equal: 0,
            image_stronger: 0,
            images: 0,
            place: 0,
            blocked: 0,
            numbers,
        }
    }

    /// Adds one row to the checks of levels; `first`: the first of the scan. Returns whether its noise shows a burst of
    /// interference.
    fn row(&mut self, first: bool, stats: &RowStats, cells: &[u8]) -> bool {
        let p = self.numbers;
        let (inside, noise) = (i32::from(stats.self_echo), row_noise(cells));
        if first {
            self.self_echo = inside;
            self.noise = SIXTEENTHS * noise;
        }
        self.self_echo_drifts +=
            u32::from((inside - self.self_echo).abs() > units(p.inside_drift_db));
        self.place = self.place.saturating_add(stats.mirror_place.into());
        let mirror = i32::from(stats.mirror_echo);
        let image = i32::from(stats.image);
        let clear = image.max(mirror) > noise + units(p.image_clear_db);
        let apart = image - mirror;
        self.image_stronger += u32::from(clear && apart > units(p.twin_db));
        self.image_equal += u32::from(clear && apart.abs() <= units(p.twin_db));
        self.images +=
            u32::from(apart > -units(p.image_db) && image > noise + units(p.image_clear_db));
        self.blocked += u32::from(i32::from(stats.before_window) > mirror + units(p.near_db));
        let above = SIXTEENTHS * noise - self.noise;
        let burst = above > SIXTEENTHS * units(p.burst_db) && self.burst_rows < MAX_BURST_ROWS;
        if burst {
            self.burst_rows += 1;
            self.bursts += 1;
        } else {
            // After a burst of the maximum length the current noise is the new reference, else a running mean.
            self.noise += if self.burst_rows < MAX_BURST_ROWS {
                above / RUNNING_MEAN
            } else {
                above
            };
            self.burst_rows = 0;
        }
        burst
    }
}

/// Calls `take` with every cell of a row whose index is a multiple of `stride`. The iterator's `step_by` would cost 65
/// instructions more in the worst row.
#[inline(always)]
fn every(cells: &[u8], stride: usize, mut take: impl FnMut(u8)) {
    let mut k = 0;
    while let Some(&cell) = cells.get(k) {
        take(cell);
        k += stride;
    }
}

/// Returns the noise of a row, map units: the lower quartile of its cells, which echoes do not reach.
fn row_noise(cells: &[u8]) -> i32 {
    let mut classes = [0u8; CELL_VALUES >> CLASS_SHIFT];
    every(cells, CELL_STRIDE, |cell| {
        if let Some(count) = classes.get_mut(usize::from(cell >> CLASS_SHIFT)) {
            // A row has fewer than 256 counted cells, so the count cannot overflow; `wrapping_add` spares the
            // check.
            *count = count.wrapping_add(1);
        }
    });
    let quarter = (cells.len().div_ceil(CELL_STRIDE) / QUARTER) as i32;
    let mut below = 0;
    for (class, &count) in (0i32..).zip(&classes) {
        let count = i32::from(count);
        if below + count > quarter {
            // Linear interpolation within the class.
            return (class << CLASS_SHIFT) + ((quarter - below) << CLASS_SHIFT) / count.max(1);
        }
        below += count;
    }
    0
}

impl Health {
    /// Returns the state before a scan's first row.
    pub const fn new(numbers: Numbers) -> Self {
        Self {
            rows: 0,
            samples: 0,
            saturated: 0,
            silent: 0,
            frozen: 0,
            mirror: 0,
            probes: [Iq { i: 0, q: 0 }; PROBES],
            converter: Converter::new(numbers),
            levels: Levels::new(numbers),
            turning: Turning::new(numbers),
            phases: Phases::new(numbers),
            cells: [0; CELL_VALUES],
            numbers,
        }
    }

    /// Adds one row to the checks: its index, chirp, statistics and cells. Returns whether the caller must leave the
    /// row out of the map because of a burst of interference.
    pub fn row(&mut self, row: u16, chirp: &[Iq], stats: &RowStats, cells: &[u8]) -> bool {
        let step = (chirp.len() / PROBES).max(1);
        let mut same = self.rows > 0;
        for (probe, &sample) in self.probes.iter_mut().zip(chirp.iter().step_by(step)) {
            same &= *probe == sample;
            *probe = sample;
        }
        let burst = self.levels.row(self.rows == 0, stats, cells);
        self.converter.row(chirp, stats);
        self.rows += 1;
        self.samples += chirp.len() as u32;
        self.saturated += u32::from(stats.saturated);
        self.silent += u32::from(stats.swing <= SILENT_SWING);
        self.frozen += u32::from(same);
        self.mirror += u32::from(stats.mirror_echo);
        if row.is_multiple_of(NOISE_ROWS) {
            every(cells, NOISE_CELLS, |cell| {
                if let Some(count) = self.cells.get_mut(usize::from(cell)) {
                    // At most one in 24 of the 65,536 cells of the largest map is counted: no overflow.
                    *count = count.wrapping_add(1);
                }
            });
        }
        burst
    }

    /// Adds row `row` of `map`, which [`Health::row`] has already taken, to the checks of the mirror's turning and of
    /// the chair's motion. `phasors` returns the complex values of a stored bin and of the mirror's echo in the row's
    /// chirp.
    pub fn check_map_row(
        &mut self,
        row: u16,
        map: &PolarMap,
        phasors: impl Fn(u8) -> [[f32; 2]; 2],
    ) {
        let noise = self.levels.noise / SIXTEENTHS;
        let skirt = turning::skirt(self.mirror_units());
        let strongest = self.turning.row(map, row, [noise, skirt]);
        self.phases.row(map, row, phasors, strongest, noise);
    }

    /// Returns whether the phases of the echoes of a scan of `map` turn from row to row as the travel along `track` has it.
    pub fn phases(&self, track: &Track, map: &PolarMap, radar: &RadarConfig) -> PhaseAgreement {
        self.phases.agreement(track, map, radar)
    }

    /// Returns the scan's noise, map units: the median of the counted cells, of which echoes fill few; at least 1, for a
    /// receiver whose noise lies below the map's lowest level.
    pub fn noise(&self) -> u8 {
        let all: u32 = self.cells.iter().map(|&n| u32::from(n)).sum();
        let mut below = 0;
        let median = self.cells.iter().position(|&n| {
            below += u32::from(n);
            2 * below > all
        });
        median.unwrap_or(0).max(1) as u8
    }

    /// Returns whether any detection of `map` exceeds the scan's noise by `ECHO_ABOVE_NOISE`.
    pub fn has_echo(&self, map: &PolarMap) -> bool {
        let least = self.noise().saturating_add(ECHO_ABOVE_NOISE);
        (0..map.rows()).any(|k| map.detections(k).any(|(_, cell)| cell >= least))
    }

    /// Returns the reason for giving no answer, or `None` if the signal can be used. `mirror`: whether the radar looks
    /// at a mirror.
    #[inline(never)]
    pub fn fault(&self, mirror: bool) -> Option<Reason> {
        let most = |rows: u32| 2 * rows > self.rows;
        if self.rows == 0 || most(self.silent) {
            return Some(Reason::Silent);
        }
        if self.saturated.saturating_mul(SAMPLES_PER_SATURATED) > self.samples {
            return Some(Reason::Saturated);
        }
        if most(self.frozen) {
            return Some(Reason::MirrorFrozen);
        }
        let noise = u32::from(self.noise());
        if mirror && most(self.levels.image_stronger) {
            return Some(Reason::IqSwapped);
        }
        let missing = mirror && self.mirror < (noise + MIRROR_ABOVE_NOISE) * self.rows;
        missing.then_some(Reason::MirrorMissing)
    }

    /// Returns the range of the mirror's own echo, metres from the radar lens: mean over the rows.
    pub fn mirror_echo_m(&self, config: &Config) -> f32 {
        let place = self.levels.place as f32 / (SIXTEENTHS as f32 * self.rows.max(1) as f32);
        config.mount.mirror_offset_m() + place * config.radar.bin_spacing_m()
    }

    /// Returns the power level of the mirror's own echo, map units: mean over the rows.
    fn mirror_units(&self) -> i32 {
        (self.mirror / self.rows.max(1)) as i32
    }

    /// Returns the power level of the mirror's own echo, dB relative to full scale: mean over the rows.
    pub fn mirror_level_db(&self) -> f32 {
        let units = self.mirror as f32 / self.rows.max(1) as f32;
        (units - f32::from(FULL_SCALE)) * DB_PER_UNIT
    }

    /// Returns range and level of the mirror's own echo, in the form that a calibration stores.
    pub fn mirror_seen(&self, config: &Config) -> MirrorEcho {
        MirrorEcho {
            range_m: self.mirror_echo_m(config),
            level_db: self.mirror_level_db(),
        }
    }

    /// Calls `each` with the result of every check of the whole scan, except those that `expected` excludes. A check
    /// fails where its measured value exceeds its limit. `config` is the configuration of the scan that filled `map`.
    pub fn report_checks(
        &self,
        config: &Config,
        map: &PolarMap,
        expected: Expected,
        each: &mut dyn FnMut(CheckResult),
    ) {
        let (p, levels) = (&*self.numbers, &self.levels);
        let share = |rows: u32| (PER_CENT * rows / self.rows.max(1)) as i32;
        let mut check = |reason, value, limit| {
            each(CheckResult {
                reason,
                value,
                limit,
            });
        };
        check(Reason::Silent, self.silent as i32, 0);
        check(
            Reason::GainDrift,
            levels.self_echo_drifts as i32,
            p.strayed_rows as i32,
        );
        check(Reason::Interference, levels.bursts as i32, 0);
        if config.mount.mirror_offset > 0 {
            let twins = share(levels.image_equal);
            check(Reason::ChannelDead, twins, MAX_IMAGE_SHARE);
            let images = share(levels.images);
            check(
                Reason::IqImbalance,
                if twins > MAX_IMAGE_SHARE { 0 } else { images },
                MAX_IMAGE_SHARE,
            );
            check(
                Reason::BlockedView,
                levels.blocked as i32,
                p.near_rows as i32,
            );
            if !expected.uncalibrated {
                self.mirror_seen(config)
                    .report_checks(config, p, &mut check);
            }
        }
        self.converter.report_checks(each);
        self.turning.report_checks(map, each);
        if config.mount.mirror_offset > 0 && !expected.moving {
            self.phases.report_checks(each);
        }
        let mirror = self.mirror_units();
        turning::lines(map, config, p, [self.noise().into(), mirror], each);
    }

    /// Returns the reasons of the failed checks, which prevent `ok`; empty if the instrument works. `config` is the
    /// configuration of the scan that filled `map`.
    #[inline(never)]
    pub fn failed_checks(&self, config: &Config, map: &PolarMap, expected: Expected) -> Reasons {
        let mut failed = Reasons::NONE;
        self.report_checks(config, map, expected, &mut |check| {
            if check.value > check.limit && !self.numbers.rules.muted.has(check.reason) {
                failed.add(check.reason);
            }
        });
        failed
    }
}

impl Default for Health {
    fn default() -> Self {
        Self::new(Numbers::DEFAULT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the health checks after a scan of 16 rows: `row(k)` gives for row k the sample and the cell, each
    /// repeated 64 times, and the statistics.
    fn scan(row: impl Fn(u16) -> (Iq, RowStats, u8)) -> Health {
        let mut health = Health::default();
        for k in 0..16 {
            let (sample, stats, cell) = row(k);
            health.row(k, &[sample; 64], &stats, &[cell; 64]);
        }
        health
    }

    fn good(k: u16) -> (Iq, RowStats, u8) {
        let stats = RowStats {
            swing: 900,
            mirror_echo: 170,
            image: 85,
            self_echo: 200,
            before_window: 100,
            ..RowStats::EMPTY
        };
        (Iq::new(k as i16, 5), stats, 80)
    }

    /// Returns the reasons that 64 good rows raise after `change` has altered the statistics and the cell value of
    /// each, and the number of rows left out as bursts; the map stays empty.
    fn failed_checks(change: impl Fn(u16, &mut RowStats, &mut u8)) -> (Reasons, u32) {
        let mut health = Health::default();
        let mut aside = 0;
        for k in 0..64 {
            let (_, mut stats, mut cell) = good(k);
            change(k, &mut stats, &mut cell);
            // Every bit changes within a chirp, and no two rows are equal.
            let odd = k.wrapping_mul(0x9E37) ^ 0x5A5A;
            let (a, b) = (odd as i16, !odd as i16);
            let chirp: Vec<Iq> = (0..64)
                .map(|n| {
                    if n % 2 == 0 {
                        Iq::new(a, b)
                    } else {
                        Iq::new(b, a)
                    }
                })
                .collect();
            aside += u32::from(health.row(k, &chirp, &stats, &[cell; 64]));
        }
        let config = Config::default();
        let mut map = Box::new(PolarMap::new());
        map.begin(&config).unwrap();
        (
            health.failed_checks(&config, &map, Expected::default()),
            aside,
        )
    }

    #[test]
    fn what_a_good_scan_shows_raises_no_doubt() {
        assert_eq!(failed_checks(|_, _, _| ()), (Reasons::NONE, 0));
    }

    #[test]
    fn each_doubt_has_its_reason() {
        let only = |reason| (Reasons::NONE.with(reason), 0);
        let falls =
            |k: u16, s: &mut RowStats, _: &mut u8| s.self_echo -= if k > 40 { 12 } else { 0 };
        assert_eq!(failed_checks(falls), only(Reason::GainDrift));
        let twin = |_, s: &mut RowStats, _: &mut u8| s.image = s.mirror_echo - 3;
        assert_eq!(failed_checks(twin), only(Reason::ChannelDead));
        let image = |_, s: &mut RowStats, _: &mut u8| s.image = s.mirror_echo - 40;
        assert_eq!(failed_checks(image), only(Reason::IqImbalance));
        let moved = |_, s: &mut RowStats, _: &mut u8| s.mirror_place = 40;
        assert_eq!(failed_checks(moved), only(Reason::RangeScale));
        let near = |_, s: &mut RowStats, _: &mut u8| s.before_window = s.mirror_echo + 20;
        assert_eq!(failed_checks(near), only(Reason::BlockedView));
        let dead = |k: u16, s: &mut RowStats, _: &mut u8| s.swing *= u16::from(k != 20);
        assert_eq!(failed_checks(dead), only(Reason::Silent));
        let burst = |k: u16, _: &mut RowStats, c: &mut u8| *c += if k % 16 == 9 { 30 } else { 0 };
        assert_eq!(
            failed_checks(burst),
            (Reasons::NONE.with(Reason::Interference), 4)
        );
    }

    #[test]
    fn a_calibrated_mirror_is_held_to_its_place() {
        let mut health = Health::default();
        let (sample, mut stats, cell) = good(0);
        // 8/16: half a bin beyond the mirror's offset.
        stats.mirror_place = 8;
        health.row(0, &[sample; 64], &stats, &[cell; 64]);
        let mut config = Config::default();
        let seen_m = health.mirror_echo_m(&config);
        assert!((seen_m - 0.2259).abs() < 1e-3, "{seen_m}");
        let map = Box::new(PolarMap::new());
        let fails = |config: &Config, uncalibrated| {
            let expected = Expected {
                uncalibrated,
                moving: false,
            };
            let failed = health.failed_checks(config, &map, expected);
            failed.has(Reason::RangeScale)
        };
        assert!(!fails(&config, false));
        config.mount.mirror_echo = 22_000;
        assert!(fails(&config, false));
        assert!(!fails(&config, true), "calibration finds it");
        config.mount.mirror_echo = 22_600;
        assert!(!fails(&config, false));
        // Calibrated, and then set to another mirror offset, from which all distances count.
        for (place, fails) in [(40, false), (60, true)] {
            stats.mirror_place = place;
            health.row(1, &[sample; 64], &stats, &[cell; 64]);
            let seen_m = health.mirror_echo_m(&config);
            assert_eq!(
                seen_m - 0.22 > Numbers::DEFAULT.mirror_place_m,
                fails,
                "{seen_m}"
            );
            config.mount.mirror_echo = (seen_m * 1e5) as i32;
            let failed = health.failed_checks(&config, &map, Expected::default());
            assert_eq!(failed.has(Reason::RangeScale), fails);
        }
    }

    #[test]
    fn swapped_channels_give_no_answer() {
        let swapped = scan(|k| {
            let (sample, mut stats, cell) = good(k);
            (stats.mirror_echo, stats.image) = (80, 170);
            (sample, stats, cell)
        });
        assert_eq!(swapped.fault(true), Some(Reason::IqSwapped));
    }

    #[test]
    fn a_good_scan_is_healthy() {
        let health = scan(good);
        assert_eq!(health.fault(true), None);
        assert_eq!(health.noise(), 80);
    }

    #[test]
    fn each_defect_has_its_reason() {
        let with = |change: fn(&mut (Iq, RowStats, u8), u16)| {
            scan(|k| {
                let mut row = good(k);
                change(&mut row, k);
                row
            })
            .fault(true)
        };
        assert_eq!(with(|r, _| r.1.swing = 1), Some(Reason::Silent));
        assert_eq!(
            with(|r, k| r.1.saturated = u16::from(k < 2)),
            Some(Reason::Saturated)
        );
        assert_eq!(with(|r, k| r.1.saturated = u16::from(k < 1)), None);
        assert_eq!(with(|r, _| r.0.i = 7), Some(Reason::MirrorFrozen));
        assert_eq!(with(|r, _| r.2 = 0), None);
        assert_eq!(
            with(|r, _| r.1.mirror_echo = 103),
            Some(Reason::MirrorMissing)
        );
        assert_eq!(with(|r, _| r.1.mirror_echo = 104), None);
    }

    #[test]
    fn without_rows_there_is_no_answer() {
        assert_eq!(Health::default().fault(false), Some(Reason::Silent));
    }
}
