//! Check of the mirror's own echo: its range and its level, means over a whole scan, against configuration and
//! calibration.

use crate::config::Config;
use crate::params::Params;
use crate::verdict::Reason;

/// Unit of the mirror echo's range in settings and check results, metres.
const STEP_M: f32 = 1e-5;
/// Reciprocal of [`STEP_M`].
const PER_METRE: f32 = 1e5;
/// Unit of the mirror echo's power level in settings and check results, dB.
const STEP_DB: f32 = 1e-3;
/// Reciprocal of [`STEP_DB`].
const PER_DB: f32 = 1e3;

/// The mirror's own echo, as measured by one scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorEcho {
    /// Measured range of the mirror's own echo, metres from the radar.
    pub range_m: f32,
    /// Measured power level of the mirror's own echo, dB relative to the converter's full scale.
    pub level_db: f32,
}

impl MirrorEcho {
    /// Calls `report` with each check's reason, the measured value's deviation and its limit: the range against the
    /// configured mirror offset and against the calibrated range, in units of 0.01 mm; the level against the calibrated
    /// one, in 0.001 dB. Checks without a calibrated value are left out.
    #[inline(never)]
    pub(super) fn report_checks(
        self,
        config: &Config,
        p: &Params,
        report: &mut dyn FnMut(Reason, i32, i32),
    ) {
        // Wide limit against the mirror's offset, from which distances count; narrow limit against the
        // calibrated range.
        let mut place = |right_m: f32, within_m: f32| {
            let off = (self.range_m - right_m).abs();
            let (off, within) = ((off * PER_METRE) as i32, (within_m * PER_METRE) as i32);
            report(Reason::RangeScale, off, within);
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
            report(Reason::GainDrift, off, within);
        }
    }
}
