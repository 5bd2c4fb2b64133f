//! Tuned constants of the power along the ground's line. Numbers without another stated origin were tuned by hand.

// Power along a line.

/// Tolerance of the ground's height, metres: joints, slopes, the remaining error of the mounting.
pub const OFF_M: f32 = 0.01;
/// Minimum horizontal distance of evaluated ground from the mirror, metres.
pub const NEAREST_M: f32 = 0.36;
/// Maximum range of evaluated ground from the mirror, metres.
pub const FARTHEST_M: f32 = 2.0;
/// Minimum share of the rows around a line, by weight, that must have been received for the line to count as seen.
pub const MIN_SHARE: f32 = 0.5;
/// Power that side lobes put into all other rows of a range cell, as a ratio to the power of its strongest row.
pub const SIDE_LOBES: f32 = 0.02;
/// Maximum distance of a cell's strongest row from a surface's line at which it counts as the surface's own echo,
/// standard deviations of the beam.
pub const ITSELF: f32 = 1.0;
/// Maximum log-likelihood ratio of one cell, nats: neighbouring cells share the window's main lobe, and the beam's
/// shape is not known better.
pub const MAX_NATS: f32 = 12.0;

// Markov chain of the ground's reflectivity, and what stands on it.

/// Probability per range cell that the ground's reflectivity goes to a neighbouring state.
pub const WALKS: f32 = 0.05;
/// Probability per range cell that the ground's reflectivity goes to any state: the ground is of another material.
pub const JUMPS: f32 = 0.006;
/// Probability that the power of a range cell does not depend on the reflectivity state: joints, patches.
pub const ODD: f32 = 0.03;
/// Prior probability that a range cell around a riser is dark; otherwise it has any power.
pub const DARK_AT_RISER: f32 = 0.4;
/// Probability per range cell behind an edge that a low object begins.
pub const LIES_LOW: f32 = 0.006;
/// Probability per range cell that a low object behind an edge ends.
pub const LOW_ENDS: f32 = 0.2;
/// Probability per range cell behind an edge that the ground begins again.
pub const AGAIN: f32 = 0.004;
/// Minimum length of a hole, metres: a wheel crosses shorter ones.
pub const HOLE_M: f32 = 0.2;
/// Probability that lower ground is visible behind an edge, over all depths.
pub const LOWER: f32 = 0.5;

// Averaging of rows.

/// Half-width of the window of rows over which the power along a line is averaged, standard deviations of the two-way
/// beam.
pub const LINE_REACH: f32 = 2.5;

// Powers of the surfaces.

/// Power S of the ground in the first (weakest) state at [`REFERENCE_M`], dB over the noise.
pub const FIRST_STATE_DB: f32 = -16.0;
/// Step of the power S from state to state, dB.
pub const STATE_DB: f32 = 4.0;
/// Range to which the powers of the states refer, metres.
pub const REFERENCE_M: f32 = 0.7;
/// Step between the powers that a surface of unknown power may have, dB; the first is 0 dB over the noise.
pub const ANY_DB: f32 = 6.0;
