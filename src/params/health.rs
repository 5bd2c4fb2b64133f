//! Tuned constants of the health checks that are no fields of [`super::Params`]. Numbers without another stated origin
//! were tuned by hand.

// Levels.

/// Reciprocal of the share of a scan's samples that may be at full scale. A clipped chirp turns one echo into a comb.
pub const SAMPLES_PER_SATURATED: u32 = 1000;
/// Maximum number of consecutive rows that are discarded as a burst of interference. After it the current noise becomes
/// the new reference.
pub const MAX_BURST_ROWS: u32 = 8;
/// Reciprocal of a new row's weight in the running mean of the noise.
pub const RUNNING_MEAN: i32 = 4;
/// Maximum share of the rows, per cent, that may show an I/Q image of the mirror's echo.
pub const MAX_IMAGE_SHARE: i32 = 75;

// Samples and phases.

/// Maximum share of the checked rows, per cent, that may be clipped. Checked rows look at I and Q in turn, so clipping
/// of I alone shows in half of them.
pub const MAX_CLIPPED_ROWS: i32 = 35;

/// Minimum length of the mean of unit phasors of the phase changes, 0 to 1, of a standing chair: the phase changes have
/// a standard deviation of at most 26 degrees.
pub const MIN_COHERENCE: f32 = 0.9;
