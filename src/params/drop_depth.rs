//! Tuned constants of the depth of a drop. Numbers without another stated origin were tuned by hand.

/// Maximum reported depth, metres: two low risers of 11 cm. A deeper surface may be the second tread of a flight
/// whose first one is hidden.
pub const MAX_M: f32 = 0.22;
/// Minimum probability at which a depth is reported, given a drop at the reported place.
pub const LEAST: f32 = 0.9;
/// Half-width of the window about the likeliest depth over which probabilities are added, metres.
pub const HALF_M: f32 = 0.015;
/// Depth below the ground down to which echoes count as the ground's own, metres.
pub const GROUND_M: f32 = 0.03;
/// Minimum horizontal distance between two echoes that both count, metres: nearer ones are not independent, but share a
/// main lobe of the range window or a face of a wall.
pub const APART_M: f32 = 0.025;
/// Length by which the shadow behind the edge is shortened, metres, since the edge may be nearer than reported.
pub const SLACK_M: f32 = 0.05;
/// Standard deviation of a surface's scatterers about its depth, metres.
pub const ROUGH_M: f32 = 0.007;
/// Prior probability that an echo behind the shadow is the surface's.
pub const SHARE: f32 = 0.5;
