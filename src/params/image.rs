//! Constants of CLEAN: which point of the coherent image is an echo, and how well the image's responses are known.

/// Minimum power of a point over noise and error: 9 dB. Noise alone has three or four such points in a scan (counted by a
/// test).
pub const LEAST: f32 = 7.943_282;
/// Level of such a point in one row's cell, dB: 11.8 dB less, the gain over 5 degrees of beam in rows of 0.25 degrees.
pub const LEAST_DB: f32 = -2.8;
/// Error of the pattern's main lobe and of the window's response, as a share of a point's power: -30 dB. Antenna patterns
/// are known to 3 %.
pub const PATTERN: f32 = 1e-3;
/// Two-way side lobes at any angle and the same range, as a share of the power: 15 dB one way.
pub const SIDE_LOBES: f32 = 1e-3;
/// Skirt over the range of a sweep that is not linear, as a share of the power: -40 dB, by hand.
pub const SKIRT: f32 = 1e-4;
/// Extent of that skirt, native bins: ripple of the sweep puts paired echoes 16 cm beside a strong one.
pub const SKIRT_BINS: f32 = 20.0;
/// Image of an I/Q imbalance of 5 % and 3 degrees, as a share of the power: -30 dB less the margin of an echo.
pub const IQ_IMAGE: f32 = 1.26e-4;
/// Maximum distance of that image from its expected place, native bins: the lobe's reach and half a bin.
pub const IMAGE_BINS: f32 = 2.5;
/// Phase noise at all ranges of the same angle, as a share of the power: 40 dB below the echo in one row, by hand, and
/// different from row to row.
pub const PHASE_NOISE: f32 = 1e-5;
