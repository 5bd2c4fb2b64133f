//! Tuned constants of the way down: treads that are seen from above, their edges and their flights. Numbers without
//! another stated origin were tuned by hand.

// Echoes of treads.

/// Maximum height difference between a tread and an echo that counts as the tread's, metres.
pub const TREAD_OFF_M: f32 = 0.03;
/// Minimum likelihood ratio, of a tread to everything else, at which an echo counts as the tread's.
pub const MIN_RATIO: f32 = 0.05;
/// Share of a tread's echoes whose height has the larger of two standard deviations.
pub const WIDE_SHARE: f32 = 0.15;
/// Ratio of the larger standard deviation of echo heights to the smaller one.
pub const WIDE_FACTOR: f32 = 3.0;
/// Horizontal distance from a tread's end beyond which an echo is clearly on the tread or off it, metres.
pub const END_AROUND_M: f32 = 0.05;
/// Mean distance beyond a tread's ends up to which its echoes lie, metres: a lobe's peak is not at the scatterer.
pub const END_BEYOND_M: f32 = 0.009;
/// Number of echoes that is added to both the counted and the expected number, so that their ratio stays near 1 in
/// scenes of few echoes.
pub const USUAL_ECHOES: f32 = 4.0;
/// SNR below which echoes are mostly noise, dB.
pub const NOISE_DB: f32 = 5.0;

// Edges of treads.

/// Share of edges that deviate from equal goings by up to 7 cm.
pub const ODD_SHARE: f32 = 0.05;
/// Share of the other edges at each of both neighbouring places: they deviate by 6 mm, half a place included.
pub const BESIDE_SHARE: f32 = 0.166;

// Flights.

/// Maximum probability that an edge lies beyond three standard deviations.
pub const OUTSIDE_SHARE: f32 = 0.005;
/// Length of the range of first rises, metres, over which they are evenly distributed.
pub const FIRST_RISES_WIDTH_M: f32 = 0.16;

// Proposals.

/// Minimum half-height of the band about a tread's strongest echo in which echoes belong to the same tread, metres.
pub const ROW_M: f32 = 0.015;
/// Half-height of the band about a tread's strongest echo in which echoes belong to the same tread, in standard
/// deviations of that strongest echo's height.
pub const ROW_SIGMAS: f32 = 1.5;
/// Minimum depth below the ground of a tread, metres: higher echoes are the ground's.
pub const BELOW_GROUND_M: f32 = 0.035;
/// Rises of the first step, metres: from the lowest to the highest that is built.
pub const FIRST_RISES_M: core::ops::RangeInclusive<f32> = 0.05..=0.27;
/// Maximum deviation of a rise from the mean rise of its flight, metres.
pub const ALIKE_M: f32 = 0.05;
/// Maximum deviation of two rises from twice the mean rise, metres, where the tread between them has no echoes.
pub const SKIPPED_ALIKE_M: f32 = 0.025;
