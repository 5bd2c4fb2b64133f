//! Tuned constants of the calibration by command. Numbers without another stated origin were tuned by hand.

use crate::math::RAD_PER_DEG;

/// Maximum angle offset that calibration accepts for a mounting, radians: more is a wrong bracket or a
/// misplaced switch.
pub const MAX_OFFSET_RAD: f32 = 6.0 * RAD_PER_DEG;
/// Maximum error of the range scale, as a share of the range: five times the drift of a chirp's slope.
pub const MAX_SCALE_ERROR: f32 = 0.05;
/// Maximum difference of the fitted mounting height from the configured one, metres.
pub const MAX_HEIGHT_ERROR_M: f32 = 0.15;
/// Minimum SNR of a wall's flash (specular reflection), dB: that of a plaster wall at 1.5 m is 50.
pub const FLASH_DB: f32 = 25.0;
/// Minimum SNR of the echo of the corner of wall and ground, dB: that of plaster and concrete is 49.
pub const CORNER_DB: f32 = 20.0;
/// Maximum difference, dB, by which an echo may be weaker than the wall's flash and still count as a second reflector:
/// weaker ones may be side lobes or multiple reflections of the flash.
pub const LESSER_DB: f32 = 30.0;
/// Maximum range difference of echoes of one wall, metres: two range bins.
pub const SAME_M: f32 = 0.03;
/// Maximum horizontal distance of the corner's echo from the measured wall before the fit, metres.
pub const CORNER_M: f32 = 0.08;
/// Minimum horizontal distance of a ground echo from the wall, metres: nearer echoes belong to the corner.
pub const CORNER_MARGIN_M: f32 = 0.1;
/// Minimum number of ground echoes for a calibration.
pub const MIN_GROUND_ECHOES: u8 = 5;
/// Distance from the fitted ground, in standard deviations, beyond which a ground echo is an outlier.
pub const OUTLIER_SIGMAS: f32 = 4.0;
/// Maximum share of outliers among the ground echoes of a calibration.
pub const OUTLIER_SHARE: f32 = 0.34;
/// Maximum range error of the corner's echo after the fit, metres: the shape of the main lobe, and the wall's
/// base.
pub const CORNER_OFF_M: f32 = 0.01;
/// Maximum angle error of the corner's echo after the fit, radians.
pub const CORNER_OFF_RAD: f32 = 0.5 * RAD_PER_DEG;
/// Standard deviation of the range of the flash or the corner in addition to that by noise, metres: the chirp's
/// slope.
pub const RANGE_MODEL_M: f32 = 0.0005;
/// Standard deviation of the wall's measured distance, metres: a steel tape from the mirror to the wall.
pub const TAPE_M: f32 = 0.001;
