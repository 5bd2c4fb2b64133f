//! Checks of the instrument: whether radar, mirror and converter worked, gathered row by row.
//!
//! A scanner that sees nothing because it is blind must not say that the way is clear, and one whose
//! rows are not what they are taken for must not say `ok`. Every rule here is about the instrument, none
//! about stairs, so it holds for every estimator.
//!
//! | module | watches |
//! |---|---|
//! | this file | levels from row to row: noise, what the scanner shows of itself, bursts |
//! | `converter` | samples: bits, offsets, swings, chirps that come twice |
//! | `turning` | the map: that echoes change as a mirror that turns makes them |
//! | `standing` | phases: that chair and scene stand |
//!
//! [`Health::verdict`] is why there is no answer at all, [`Health::doubts`] why an answer is not to be
//! trusted.

mod converter;
mod mirror;
mod sign;
mod standing;
mod turning;

use crate::Iq;
use crate::config::Config;

use crate::params::current as p;
use crate::signal::grid::{DB_PER_UNIT, PolarMap};
use crate::signal::range::{FULL_SCALE, RowStats};
use crate::verdict::{Reason, Reasons};
use converter::Converter;
pub use mirror::MirrorEcho;
pub use sign::Sign;
use sign::{PER_CENT, units};
use standing::Standing;
use turning::Turning;

/// Rows between two whose cells are counted for the noise level.
const NOISE_ROWS: u16 = 8;
/// Cells of those rows between two that are counted.
const NOISE_CELLS: usize = 3;
/// Of so many samples one may stand at full scale: a clipped chirp turns one echo into a comb.
const SAMPLES_PER_SATURATED: u32 = 1000;
/// A converter whose samples swing by no more than this has no signal: its own rounding.
const SILENT_SWING: u16 = 1;
/// The mirror's echo stands at least so far above the noise, map units (9 dB). Noise alone has its
/// strongest bin of the mirror's few some 4 dB above the median.
const MIRROR_ABOVE_NOISE: u32 = 24;
/// An echo stands at least so far above the median cell, map units (15 dB): of the 65,536 cells of the largest map noise
/// brings one there in fewer than one map in 50,000.
const HEARD_ABOVE_NOISE: u8 = 40;
/// Samples of a chirp that are compared with those of the chirp before.
const PROBES: usize = 4;
/// Rows up to which a noise level that was seen last is a yardstick for the next.
const YARDSTICK_ROWS: u32 = 8;
/// Cells between two that are looked at for a row's noise.
const CELL_STRIDE: usize = 6;
/// Cells of one class of the histogram behind a row's noise, as a power of two: 1.5 dB.
const CLASS_SHIFT: u32 = 2;
/// Values of a cell.
const CELL_VALUES: usize = 256;
/// Steps of a map unit, or of a bin, in which means of levels and places are kept.
const SIXTEENTHS: i32 = 16;
/// Rows over which the noise is averaged.
const RUNNING_MEAN: i32 = 4;
/// One over the share of a row's cells that lie below its noise: echoes do not reach the lower quartile.
const QUARTER: usize = 4;

/// What is seen in more than so many per cent of the rows is no chance.
const MOST: i32 = 75;

/// What is expected of a scan, and no sign of a defect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Expected {
    /// The chair is known to move: the echoes' phases go on from row to row.
    pub moving: bool,
    /// The scan is for calibration: place and level of the mirror's echo are still to be found.
    pub uncalibrated: bool,
}

/// The health of one scan.
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
    standing: Standing,
    /// How often each cell value was seen, in every [`NOISE_ROWS`]th row.
    cells: [u16; CELL_VALUES],
}

/// Levels from row to row, map units.
#[derive(Clone, Debug)]
struct Levels {
    /// What the scanner showed of itself in the first row.
    inside: i32,
    /// Rows in which that was otherwise.
    strayed: u32,
    /// Noise of the rows before, sixteenths, and rows since one was taken for it.
    noise: i32,
    since: u32,
    /// Rows set aside.
    bursts: u32,
    /// Rows with an image of the mirror's echo: as strong, stronger, or too strong.
    twins: u32,
    backwards: u32,
    images: u32,
    /// Sum of the places of the mirror's echo, 1/16 bin.
    place: i32,
    /// Rows with something right before the mirror.
    near: u32,
}

impl Levels {
    const fn new() -> Self {
        Self {
            inside: 0,
            strayed: 0,
            noise: 0,
            since: 0,
            bursts: 0,
            twins: 0,
            backwards: 0,
            images: 0,
            place: 0,
            near: 0,
        }
    }

    /// Takes one row; whether something else transmitted meanwhile.
    fn row(&mut self, first: bool, stats: &RowStats, cells: &[u8]) -> bool {
        let (inside, noise) = (i32::from(stats.inside), row_noise(cells));
        if first {
            self.inside = inside;
            self.noise = SIXTEENTHS * noise;
        }
        self.strayed += u32::from((inside - self.inside).abs() > units(p().inside_drift_db));
        self.place = self.place.saturating_add(stats.mirror_place.into());
        let mirror = i32::from(stats.mirror_echo);
        let image = i32::from(stats.image);
        let clear = image.max(mirror) > noise + units(p().image_clear_db);
        let apart = image - mirror;
        self.backwards += u32::from(clear && apart > units(p().twin_db));
        self.twins += u32::from(clear && apart.abs() <= units(p().twin_db));
        self.images +=
            u32::from(apart > -units(p().image_db) && image > noise + units(p().image_clear_db));
        self.near += u32::from(i32::from(stats.near) > mirror + units(p().near_db));
        let above = SIXTEENTHS * noise - self.noise;
        let burst = above > SIXTEENTHS * units(p().burst_db) && self.since < YARDSTICK_ROWS;
        if burst {
            self.since += 1;
            self.bursts += 1;
        } else {
            // A fresh yardstick after so long a burst, else a running mean.
            self.noise += if self.since < YARDSTICK_ROWS {
                above / RUNNING_MEAN
            } else {
                above
            };
            self.since = 0;
        }
        burst
    }
}

/// Calls `take` with every cell whose number is a multiple of `stride`. With `step_by` the worst row takes 65
/// instructions more.
#[inline(always)]
fn every(cells: &[u8], stride: usize, mut take: impl FnMut(u8)) {
    let mut k = 0;
    while let Some(&cell) = cells.get(k) {
        take(cell);
        k += stride;
    }
}

/// Noise of a row: the lower quartile of its cells, which echoes do not reach, map units.
fn row_noise(cells: &[u8]) -> i32 {
    let mut classes = [0u8; CELL_VALUES >> CLASS_SHIFT];
    every(cells, CELL_STRIDE, |cell| {
        if let Some(count) = classes.get_mut(usize::from(cell >> CLASS_SHIFT)) {
            // A row has fewer cells than a count holds: nothing wraps around, and no instruction tests that.
            *count = count.wrapping_add(1);
        }
    });
    let quarter = (cells.len().div_ceil(CELL_STRIDE) / QUARTER) as i32;
    let mut below = 0;
    for (class, &count) in (0i32..).zip(&classes) {
        let count = i32::from(count);
        if below + count > quarter {
            // Within the class in proportion.
            return (class << CLASS_SHIFT) + ((quarter - below) << CLASS_SHIFT) / count.max(1);
        }
        below += count;
    }
    0
}

impl Health {
    /// Nothing seen yet.
    pub const fn new() -> Self {
        Self {
            rows: 0,
            samples: 0,
            saturated: 0,
            silent: 0,
            frozen: 0,
            mirror: 0,
            probes: [Iq { i: 0, q: 0 }; PROBES],
            converter: Converter::new(),
            levels: Levels::new(),
            turning: Turning::new(),
            standing: Standing::new(),
            cells: [0; CELL_VALUES],
        }
    }

    /// Takes one row: its chirp, its statistics and its cells. Says whether the row is to be set aside,
    /// because something else transmitted meanwhile.
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
                    // Of the largest map, 65,536 cells, one in 24 is counted: nothing wraps around.
                    *count = count.wrapping_add(1);
                }
            });
        }
        burst
    }

    /// Takes in that row `row`, which [`Health::row`] has seen, stands in `map`. `phasors` gives the complex
    /// values of a stored bin and of the mirror's echo in the row's chirp.
    pub fn stands(&mut self, row: u16, map: &PolarMap, phasors: impl Fn(u8) -> [[f32; 2]; 2]) {
        let noise = self.levels.noise / SIXTEENTHS;
        let strongest = self.turning.row(map, row, noise);
        self.standing.row(map, row, phasors, strongest, noise);
    }

    /// Whether the phases of the echoes show that the chair stood.
    pub fn stood(&self) -> bool {
        self.standing.stood()
    }

    /// Median cell of the map: echoes fill so little of it that this is the noise.
    pub fn noise(&self) -> u8 {
        let all: u32 = self.cells.iter().map(|&n| u32::from(n)).sum();
        let mut below = 0;
        let median = self.cells.iter().position(|&n| {
            below += u32::from(n);
            2 * below > all
        });
        median.unwrap_or(0) as u8
    }

    /// Whether any echo of `map` stands out of the noise.
    pub fn heard(&self, map: &PolarMap) -> bool {
        let least = self.noise().saturating_add(HEARD_ABOVE_NOISE);
        (0..map.rows()).any(|k| map.hits(k).any(|(_, cell)| cell >= least))
    }

    /// Why the scan can be no answer, if so. `mirror` says whether the radar looks at a mirror.
    #[inline(never)]
    pub fn verdict(&self, mirror: bool) -> Option<Reason> {
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
        if noise == 0 {
            return Some(Reason::NoNoise);
        }
        if mirror && most(self.levels.backwards) {
            return Some(Reason::IqSwapped);
        }
        let missing = mirror && self.mirror < (noise + MIRROR_ABOVE_NOISE) * self.rows;
        missing.then_some(Reason::MirrorMissing)
    }

    /// Range at which the mirror's own echo was seen, metres from the radar: mean over the rows.
    pub fn mirror_echo_m(&self, config: &Config) -> f32 {
        let place = self.levels.place as f32 / (SIXTEENTHS as f32 * self.rows.max(1) as f32);
        config.mount.mirror_offset_m() + place * config.radar.bin_spacing_m()
    }

    /// Mean level of the mirror's own echo, dB relative to full scale.
    pub fn mirror_level_db(&self) -> f32 {
        let units = self.mirror as f32 / self.rows.max(1) as f32;
        (units - f32::from(FULL_SCALE)) * DB_PER_UNIT
    }

    /// The mirror's own echo, as a calibration keeps it.
    pub fn mirror_seen(&self, config: &Config) -> MirrorEcho {
        MirrorEcho {
            range_m: self.mirror_echo_m(config),
            level_db: self.mirror_level_db(),
        }
    }

    /// What is looked at in the whole scan, one after the other, but for what is `expected`: an answer is not to
    /// be trusted where more is seen than may be. `config` is that of the scan that filled `map`.
    pub fn signs(
        &self,
        config: &Config,
        map: &PolarMap,
        expected: Expected,
        each: &mut dyn FnMut(Sign),
    ) {
        let levels = &self.levels;
        let share = |rows: u32| (PER_CENT * rows / self.rows.max(1)) as i32;
        let mut sign = |reason, seen, limit| {
            each(Sign {
                reason,
                seen,
                limit,
            });
        };
        sign(Reason::Silent, self.silent as i32, 0);
        sign(
            Reason::GainDrift,
            levels.strayed as i32,
            p().strayed_rows as i32,
        );
        sign(Reason::Interference, levels.bursts as i32, 0);
        if config.mount.mirror_offset > 0 {
            let twins = share(levels.twins);
            sign(Reason::ChannelDead, twins, MOST);
            let images = share(levels.images);
            sign(
                Reason::IqImbalance,
                if twins > MOST { 0 } else { images },
                MOST,
            );
            sign(
                Reason::BlockedView,
                levels.near as i32,
                p().near_rows as i32,
            );
            if !expected.uncalibrated {
                self.mirror_seen(config).signs(config, &mut sign);
            }
        }
        self.converter.signs(each);
        self.turning.signs(map, each);
        if config.mount.mirror_offset > 0 && !expected.moving {
            self.standing.signs(each);
        }
        turning::lines(map, config, self.noise(), each);
    }

    /// Why an answer is not to be trusted: empty where the instrument is well. `config` is that of the
    /// scan that filled `map`.
    #[inline(never)]
    pub fn doubts(&self, config: &Config, map: &PolarMap, expected: Expected) -> Reasons {
        let mut doubts = Reasons::NONE;
        self.signs(config, map, expected, &mut |sign| {
            if sign.seen > sign.limit && !p().rules.muted.has(sign.reason) {
                doubts.add(sign.reason);
            }
        });
        doubts
    }
}

impl Default for Health {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A scan of 16 rows of 64 samples and cells, made by `row(k)`.
    fn scan(row: impl Fn(u16) -> (Iq, RowStats, u8)) -> Health {
        let mut health = Health::new();
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
            inside: 200,
            near: 100,
            ..RowStats::EMPTY
        };
        (Iq::new(k as i16, 5), stats, 80)
    }

    /// What is doubted of levels alone after 64 rows; the map stays empty.
    fn doubts(change: impl Fn(u16, &mut RowStats, &mut u8)) -> (Reasons, u32) {
        let mut health = Health::new();
        let mut aside = 0;
        for k in 0..64 {
            let (_, mut stats, mut cell) = good(k);
            change(k, &mut stats, &mut cell);
            // Samples of which every bit changes, and no two rows the same.
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
        (health.doubts(&config, &map, Expected::default()), aside)
    }

    #[test]
    fn what_a_good_scan_shows_raises_no_doubt() {
        assert_eq!(doubts(|_, _, _| ()), (Reasons::NONE, 0));
    }

    #[test]
    fn each_doubt_has_its_reason() {
        let only = |reason| (Reasons::NONE.with(reason), 0);
        let falls = |k: u16, s: &mut RowStats, _: &mut u8| s.inside -= if k > 40 { 12 } else { 0 };
        assert_eq!(doubts(falls), only(Reason::GainDrift));
        let twin = |_, s: &mut RowStats, _: &mut u8| s.image = s.mirror_echo - 3;
        assert_eq!(doubts(twin), only(Reason::ChannelDead));
        let image = |_, s: &mut RowStats, _: &mut u8| s.image = s.mirror_echo - 40;
        assert_eq!(doubts(image), only(Reason::IqImbalance));
        let moved = |_, s: &mut RowStats, _: &mut u8| s.mirror_place = 40;
        assert_eq!(doubts(moved), only(Reason::RangeScale));
        let near = |_, s: &mut RowStats, _: &mut u8| s.near = s.mirror_echo + 20;
        assert_eq!(doubts(near), only(Reason::BlockedView));
        let dead = |k: u16, s: &mut RowStats, _: &mut u8| s.swing *= u16::from(k != 20);
        assert_eq!(doubts(dead), only(Reason::Silent));
        let burst = |k: u16, _: &mut RowStats, c: &mut u8| *c += if k % 16 == 9 { 30 } else { 0 };
        assert_eq!(doubts(burst), (Reasons::NONE.with(Reason::Interference), 4));
    }

    #[test]
    fn a_calibrated_mirror_is_held_to_its_place() {
        let mut health = Health::new();
        let (sample, mut stats, cell) = good(0);
        // Half a bin beyond the mirror's offset.
        stats.mirror_place = 8;
        health.row(0, &[sample; 64], &stats, &[cell; 64]);
        let mut config = Config::default();
        let seen_m = health.mirror_echo_m(&config);
        assert!((seen_m - 0.2259).abs() < 1e-3, "{seen_m}");
        let map = Box::new(PolarMap::new());
        let doubted = |config: &Config, uncalibrated| {
            let expected = Expected {
                uncalibrated,
                moving: false,
            };
            let doubts = health.doubts(config, &map, expected);
            doubts.has(Reason::RangeScale)
        };
        assert!(!doubted(&config, false));
        config.mount.mirror_echo = 22_000;
        assert!(doubted(&config, false));
        assert!(!doubted(&config, true), "calibration finds it");
        config.mount.mirror_echo = 22_600;
        assert!(!doubted(&config, false));
        // Calibrated, and then somebody set another offset, which all distances count from.
        for (place, doubted) in [(40, false), (60, true)] {
            stats.mirror_place = place;
            health.row(1, &[sample; 64], &stats, &[cell; 64]);
            let seen_m = health.mirror_echo_m(&config);
            assert_eq!(seen_m - 0.22 > p().mirror_place_m, doubted, "{seen_m}");
            config.mount.mirror_echo = (seen_m * 1e5) as i32;
            let doubts = health.doubts(&config, &map, Expected::default());
            assert_eq!(doubts.has(Reason::RangeScale), doubted);
        }
    }

    #[test]
    fn swapped_channels_give_no_answer() {
        let swapped = scan(|k| {
            let (sample, mut stats, cell) = good(k);
            (stats.mirror_echo, stats.image) = (80, 170);
            (sample, stats, cell)
        });
        assert_eq!(swapped.verdict(true), Some(Reason::IqSwapped));
    }

    #[test]
    fn a_good_scan_is_healthy() {
        let health = scan(good);
        assert_eq!(health.verdict(true), None);
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
            .verdict(true)
        };
        assert_eq!(with(|r, _| r.1.swing = 1), Some(Reason::Silent));
        assert_eq!(
            with(|r, k| r.1.saturated = u16::from(k < 2)),
            Some(Reason::Saturated)
        );
        assert_eq!(with(|r, k| r.1.saturated = u16::from(k < 1)), None);
        assert_eq!(with(|r, _| r.0.i = 7), Some(Reason::MirrorFrozen));
        assert_eq!(with(|r, _| r.2 = 0), Some(Reason::NoNoise));
        assert_eq!(
            with(|r, _| r.1.mirror_echo = 103),
            Some(Reason::MirrorMissing)
        );
        assert_eq!(with(|r, _| r.1.mirror_echo = 104), None);
    }

    #[test]
    fn without_rows_there_is_no_answer() {
        assert_eq!(Health::new().verdict(false), Some(Reason::Silent));
    }
}
