//! The mirror's own echo: where it is, and how strong, over a whole scan.

use crate::config::Config;
use crate::params::current;
use crate::verdict::Reason;

/// Unit of places in settings and signs, metres, and its reciprocal.
const STEP_M: f32 = 1e-5;
/// See [`STEP_M`].
const PER_METRE: f32 = 1e5;
/// Unit of levels in settings and signs, dB, and its reciprocal.
const STEP_DB: f32 = 1e-3;
/// See [`STEP_DB`].
const PER_DB: f32 = 1e3;

/// The mirror's own echo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorEcho {
    /// Where it was seen, metres from the radar.
    pub range_m: f32,
    /// How strong it was, dB relative to full scale.
    pub level_db: f32,
}

impl MirrorEcho {
    /// Whether it is where it must be, and as strong.
    #[inline(never)]
    pub(super) fn signs(self, config: &Config, sign: &mut dyn FnMut(Reason, i32, i32)) {
        let p = current();
        // By the mirror's offset, which distances count from, and closer by calibration.
        let mut place = |right_m: f32, within_m: f32| {
            let off = (self.range_m - right_m).abs();
            let (off, within) = ((off * PER_METRE) as i32, (within_m * PER_METRE) as i32);
            sign(Reason::RangeScale, off, within);
        };
        place(config.mount.mirror_offset_m(), p.mirror_place_m);
        if config.mount.mirror_echo > 0 {
            place(config.mount.mirror_echo as f32 * STEP_M, p.mirror_moved_m);
        }
        if config.mount.mirror_level < 0 {
            let off_db = (self.level_db - config.mount.mirror_level as f32 * STEP_DB).abs();
            let (off, within) = (
                (off_db * PER_DB) as i32,
                (p.inside_drift_db * PER_DB) as i32,
            );
            sign(Reason::GainDrift, off, within);
        }
    }
}
