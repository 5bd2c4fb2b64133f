//! Whether the scan is one that a working radar behind a working mirror makes.

use crate::range::RowStats;
use crate::stairs::Reason;

/// Share of samples at the converter's full scale from which the map lies, as 1 in so many: a
/// clipped chirp spreads its strongest echo over all ranges.
const SATURATED_ONE_IN: u32 = 10_000;
/// A converter whose samples never leave their mean by more than this is silent.
const SILENT_SWING: u16 = 1;
/// Map units (0.376 dB) by which the mirror's mean echo must exceed the noise of a cell.
const MIRROR_ABOVE_NOISE: f32 = 12.0;
/// Share of rows that may repeat the row before.
const REPEATED_SHARE: u32 = 2;

/// Sums over the rows of a scan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Health {
    rows: u32,
    saturated: u32,
    swing: u16,
    mirror: u32,
    repeated: u32,
}

impl Health {
    /// Before the first row.
    pub const NEW: Self = Self {
        rows: 0,
        saturated: 0,
        swing: 0,
        mirror: 0,
        repeated: 0,
    };

    /// Takes in one row; `repeats` tells whether its cells are those of the row before.
    pub fn row(&mut self, stats: &RowStats, repeats: bool) {
        self.rows += 1;
        self.saturated = self.saturated.saturating_add(stats.saturated.into());
        self.swing = self.swing.max(stats.swing);
        self.mirror += u32::from(stats.mirror_echo);
        self.repeated += u32::from(repeats);
    }

    /// What is wrong, if anything; `noise` is the filtered map's median in map units, `samples` a
    /// chirp's length and `mirror` whether there is one.
    pub fn fault(&self, noise: f32, samples: u16, mirror: bool) -> Option<Reason> {
        if self.rows == 0 || self.swing <= SILENT_SWING {
            return Some(Reason::Silent);
        }
        let taken = self.rows * u32::from(samples);
        if self.saturated > taken / SATURATED_ONE_IN {
            return Some(Reason::Saturated);
        }
        if self.repeated * REPEATED_SHARE > self.rows {
            return Some(Reason::MirrorFrozen);
        }
        if noise <= 0.0 {
            return Some(Reason::NoNoise);
        }
        let mean = self.mirror as f32 / self.rows as f32;
        (mirror && mean < noise + MIRROR_ABOVE_NOISE).then_some(Reason::MirrorMissing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: RowStats = RowStats {
        saturated: 0,
        swing: 5000,
        mirror_echo: 180,
        hits: 9,
    };
    const NOISE: f32 = 100.0;

    fn fault(rows: impl IntoIterator<Item = (RowStats, bool)>, noise: f32) -> Option<Reason> {
        let mut health = Health::default();
        for (stats, repeats) in rows {
            health.row(&stats, repeats);
        }
        health.fault(noise, 200, true)
    }

    #[test]
    fn a_good_scan_has_no_fault() {
        assert_eq!(fault([(GOOD, false); 281], NOISE), None);
    }

    #[test]
    fn each_fault_has_its_name() {
        let rows = |stats| [(stats, false); 281];
        assert_eq!(fault([], NOISE), Some(Reason::Silent));
        assert_eq!(
            fault(rows(RowStats { swing: 1, ..GOOD }), 0.0),
            Some(Reason::Silent)
        );
        assert_eq!(
            fault(
                rows(RowStats {
                    saturated: 1,
                    ..GOOD
                }),
                NOISE
            ),
            Some(Reason::Saturated)
        );
        assert_eq!(
            fault([(GOOD, true); 281], NOISE),
            Some(Reason::MirrorFrozen)
        );
        assert_eq!(fault(rows(GOOD), 0.0), Some(Reason::NoNoise));
        let lost = RowStats {
            mirror_echo: 104,
            ..GOOD
        };
        assert_eq!(fault(rows(lost), NOISE), Some(Reason::MirrorMissing));
    }

    #[test]
    fn a_single_clipped_sample_is_none() {
        let clipped = (
            RowStats {
                saturated: 1,
                ..GOOD
            },
            false,
        );
        assert_eq!(
            fault([clipped].into_iter().chain([(GOOD, false); 280]), NOISE),
            None
        );
    }
}
