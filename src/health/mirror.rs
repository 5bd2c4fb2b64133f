//! The mirror's own echo: where it is, and how strong, over a whole scan.

use crate::answer::Reason;
use crate::config::Config;
use crate::params::current;

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
            let (off, within) = ((off * 1e5) as i32, (within_m * 1e5) as i32);
            sign(Reason::RangeScale, off, within);
        };
        place(config.mount.mirror_offset_m(), p.mirror_place_m);
        if config.mount.mirror_echo > 0 {
            place(config.mount.mirror_echo as f32 * 1e-5, p.mirror_moved_m);
        }
        if config.mount.mirror_level < 0 {
            let off_db = (self.level_db - config.mount.mirror_level as f32 * 1e-3).abs();
            let (off, within) = ((off_db * 1e3) as i32, (p.inside_drift_db * 1e3) as i32);
            sign(Reason::GainDrift, off, within);
        }
    }
}
