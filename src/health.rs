//! Checks of the instrument: whether radar, mirror and converter worked, gathered row by row.
//!
//! A scanner that sees nothing because it is blind must not say that the way is clear. Every rule
//! here is about the instrument, none about stairs, so it holds for every estimator.

use crate::Iq;
use crate::answer::Reason;
use crate::range::RowStats;

/// Rows between two whose cells are counted for the noise level.
const NOISE_ROWS: u16 = 8;
/// Of so many samples one may stand at full scale: a clipped chirp turns one echo into a comb.
const SAMPLES_PER_SATURATED: u32 = 1000;
/// A converter whose samples swing by no more than this has no signal: its own rounding.
const SILENT_SWING: u16 = 1;
/// The mirror's echo stands at least so far above the noise, map units (9 dB). Noise alone has its
/// strongest bin of the mirror's few some 4 dB above the median.
const MIRROR_ABOVE_NOISE: u32 = 24;
/// Samples of a chirp that are compared with those of the chirp before.
const PROBES: usize = 4;

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
    /// How often each cell value was seen, in every [`NOISE_ROWS`]th row.
    cells: [u16; 256],
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
            cells: [0; 256],
        }
    }

    /// Takes one row: its chirp, its statistics and its cells.
    pub fn row(&mut self, row: u16, chirp: &[Iq], stats: &RowStats, cells: &[u8]) {
        let step = (chirp.len() / PROBES).max(1);
        let mut same = self.rows > 0;
        for (probe, &sample) in self.probes.iter_mut().zip(chirp.iter().step_by(step)) {
            same &= *probe == sample;
            *probe = sample;
        }
        self.rows += 1;
        self.samples += chirp.len() as u32;
        self.saturated += u32::from(stats.saturated);
        self.silent += u32::from(stats.swing <= SILENT_SWING);
        self.frozen += u32::from(same);
        self.mirror += u32::from(stats.mirror_echo);
        if row.is_multiple_of(NOISE_ROWS) {
            for &cell in cells {
                if let Some(count) = self.cells.get_mut(usize::from(cell)) {
                    *count = count.saturating_add(1);
                }
            }
        }
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

    /// Why the scan can be no answer, if so. `mirror` says whether the radar looks at a mirror.
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
        let missing = mirror && self.mirror < (noise + MIRROR_ABOVE_NOISE) * self.rows;
        missing.then_some(Reason::MirrorMissing)
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
            saturated: 0,
            swing: 900,
            mirror_echo: 170,
            hits: 0,
        };
        (Iq::new(k as i16, 5), stats, 80)
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
