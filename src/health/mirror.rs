//! The mirror's own echo: where it is, and how strong, over a whole scan.

use super::{Health, P};
use crate::answer::Reason;
use crate::config::Config;
use crate::grid::DB_PER_UNIT;
use crate::range::FULL_SCALE;

/// The mirror's own echo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorEcho {
    /// Where it was seen, metres from the radar.
    pub range_m: f32,
    /// How strong it was, dB relative to full scale.
    pub level_db: f32,
}

impl Health {
    /// Range at which the mirror's own echo was seen, metres from the radar: mean over the rows.
    pub fn mirror_echo_m(&self, config: &Config) -> f32 {
        let place = self.levels.place as f32 / (16.0 * self.rows.max(1) as f32);
        config.mount.mirror_offset_m() + place * config.radar.bin_spacing_m()
    }

    /// Mean level of the mirror's own echo, dB relative to full scale.
    pub fn mirror_level_db(&self) -> f32 {
        let units = self.mirror as f32 / self.rows.max(1) as f32;
        (units - f32::from(FULL_SCALE)) * DB_PER_UNIT as f32
    }

    /// The mirror's own echo, as a calibration keeps it.
    pub fn mirror_seen(&self, config: &Config) -> MirrorEcho {
        MirrorEcho {
            range_m: self.mirror_echo_m(config),
            level_db: self.mirror_level_db(),
        }
    }

    /// Whether it is where it must be, and as strong.
    pub(super) fn mirror_signs(&self, config: &Config, sign: &mut dyn FnMut(Reason, i32, i32)) {
        let seen = self.mirror_seen(config);
        // By the mirror's offset, which distances count from, and closer by calibration.
        let mut place = |right_m: f32, within_m: f32| {
            let off = (seen.range_m - right_m).abs();
            let (off, within) = ((off * 1e5) as i32, (within_m * 1e5) as i32);
            sign(Reason::RangeScale, off, within);
        };
        place(config.mount.mirror_offset_m(), P.mirror_place_m);
        if config.mount.mirror_echo > 0 {
            place(config.mount.mirror_echo as f32 * 1e-5, P.mirror_moved_m);
        }
        if config.mount.mirror_level < 0 {
            let off_db = (seen.level_db - config.mount.mirror_level as f32 * 1e-3).abs();
            let (off, within) = ((off_db * 1e3) as i32, (P.inside_drift_db * 1e3) as i32);
            sign(Reason::GainDrift, off, within);
        }
    }
}
