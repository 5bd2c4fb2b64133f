//! Settings from the result of a calibration.

use super::Settings;
use crate::math::{RAD_PER_DEG, round};
use crate::mount::Mounting;

/// Number of setting units in a metre (of 0.01 mm), and below in a degree (of 0.001°), a decibel (of 0.001 dB)
/// and one (of 1e-6).
const METRE: f32 = 1e5;
const DEGREE: f32 = 1e3;
const DECIBEL: f32 = 1e3;
const MILLION: f32 = 1e6;

impl Settings {
    /// Keys that [`Settings::calibrate`] sets.
    pub const CALIBRATED: [&'static str; 5] = [
        "mount-height",
        "home-angle",
        "mirror-echo",
        "mirror-level",
        "range-scale",
    ];

    /// Sets the settings of the mounting to the result `found` of a scan made with these settings. The caller
    /// must validate them.
    pub fn calibrate(&mut self, found: &Mounting) {
        let fixed = |value: f32, unit: f32| round(value * unit) as i32;
        let mount = &mut self.config.mount;
        mount.mount_height = fixed(found.height_m.value, METRE);
        mount.mirror_echo = fixed(found.mirror_echo_m.value, METRE);
        // 0 means not calibrated.
        mount.mirror_level = fixed(found.mirror_level_db, DECIBEL).min(-1);
        // The measured scale is relative to that of the scan.
        let scale = (1.0 + mount.range_scale as f32 / MILLION) * found.scale.value;
        mount.range_scale = fixed(scale - 1.0, MILLION);
        let offset = fixed(found.offset_rad.value / RAD_PER_DEG, DEGREE);
        self.motor.home_angle = self.motor.home_angle.saturating_add(offset);
    }
}
