//! The numbers of the posterior: its measurement model, its prior and its variants.
//!
//! They are constants and stand in no [`super::Params`]: nothing changes them at run time. Where no other origin is
//! given, a number was set by hand. What is counted from simulated scans stands in [`super::measured`].

// Arithmetic.

/// Slope of the logistic function that is within 0.01 of the normal distribution.
pub const NORMAL_SLOPE: f32 = 1.702;
/// Least probability, so that its logarithm is finite.
pub const LEAST_PROBABILITY: f32 = 1e-30;
/// ln √(2π), rounded.
pub const LN_ROOT_TAU: f32 = 0.919;
/// 1 / √(2π), rounded.
pub const PER_ROOT_TAU: f32 = 0.4;
/// Variance of an even distribution over a unit: 1 / 12.
pub const EVEN_VARIANCE: f32 = 1.0 / 12.0;
/// Least standard deviation of a level, metres, so that it can be divided by.
pub const LEAST_SIGMA_M: f32 = 1e-4;
/// Least distance or range that is divided by, metres.
pub const LEAST_RANGE_M: f32 = 0.05;
/// Least distance that a slope is taken over, metres.
pub const LEAST_X_M: f32 = 0.02;

// The density of a deviation: a Gaussian and wide tails, over the squared deviation in standard deviations.

/// Weight of the Gaussian.
pub const CORE_SHARE: f32 = 0.92;
/// Weight of the tails at their middle.
pub const TAIL_SHARE: f32 = 0.005;
/// Squared deviation at which the tails have fallen to a sixteenth.
pub const TAIL_Z2: f32 = 128.0;
/// Squared deviation at which the tails are cut off.
pub const TAIL_END_Z2: f32 = 120.0;
/// Density beyond that.
pub const TAIL_END: f32 = 1e-9;

// Levels.

/// Decibels of one unit of q.
pub const TEN_DB: f32 = 10.0;
/// Units of q of one decibel.
pub const PER_TEN_DB: f32 = 0.1;
/// Level of the strongest echo at which q is 0, dB.
pub const REFERENCE_DB: f32 = 30.0;
/// Fall of a point feature's level with range, dB per decade.
pub const FADE_DB: f32 = 20.0;
/// Range from which on it falls, metres.
pub const FADE_FROM_M: f32 = 0.3;
/// Range of levels over which those are spread that no class explains, dB.
pub const LEVELS_DB: f32 = 50.0;
/// Least share of a class's levels above the detection threshold.
pub const LEAST_DETECTED: f32 = 0.02;
/// Share of point features, faces and echoes in the air with any level.
pub const ANY_LEVEL: f32 = 0.05;
/// The same of echoes inside the solid.
pub const ANY_LEVEL_INSIDE: f32 = 0.01;
/// The same of treads.
pub const ANY_LEVEL_TREAD: f32 = 0.002;
/// The same of the floor.
pub const ANY_LEVEL_FLOOR: f32 = 0.005;
/// Level at which the riser before is faint, dB; that of a riser without one before it.
pub const FAINT_DB: f32 = 15.0;
/// Level from which on the riser before outshines no more, dB.
pub const OUTSHINES_DB: f32 = 35.0;
/// Level of a riser before that shows nothing, dB.
pub const SHOWS_NOTHING_DB: f32 = 3.0;
/// Distance from a riser within which an echo is its level, metres.
pub const SHOWN_WITHIN_M: f32 = 0.025;
/// Distance from the mirror's height within which an echo is a flash, metres.
pub const FLASH_WITHIN_M: f32 = 0.03;

// Accuracy and resolution.

/// Factor on the standard deviation of an echo's angle.
pub const ANGLE_SIGMAS: f32 = 1.5;
/// Least standard deviation of an echo's angle, rad.
pub const LEAST_ANGLE_SIGMA_RAD: f32 = 0.0015;
/// Angle by which two features must be apart to be two echoes, in beam widths.
pub const APART_BEAMS: f32 = 0.9;
/// Range by which they must be apart, metres, with bins of [`BIN_M`].
pub const APART_RANGE_M: f32 = 0.02;
/// Bin for which that holds, metres.
pub const BIN_M: f32 = 0.0117;
/// Extent of a hidden riser that gives its echo as much room as one cell, metres.
pub const HIDDEN_ROOM_M: f32 = 0.05;
/// Most point features of one riser.
pub const FEATURES: usize = 3;
/// Classes of extended features whose extent depends on the staircase: face, tread, floor.
pub const SURFACES: usize = 3;

// Extended features.

/// Distance at which the floor's level and density are those of its class, metres.
pub const FLOOR_M: f32 = 0.6;
/// Way before that over which they still rise, metres.
pub const FLOOR_NEARER_M: f32 = 0.4;
/// Fall of the floor's level with distance, dB per metre.
pub const FLOOR_FALL_DB: f32 = 8.0;
/// Fall of the logarithm of its density with distance, per metre.
pub const FLOOR_FALL: f32 = 1.5;
/// Distance at which the floor begins, metres.
pub const FLOOR_BEGINS_M: f32 = 0.34;
/// Distance at which it ends where nothing stands, metres.
pub const FLOOR_ENDS_M: f32 = 2.2;
/// Share of the floor that shows under floating treads.
pub const FLOOR_UNDER: f32 = 0.3;
/// Length of the last tread, metres.
pub const LAST_TREAD_M: f32 = 0.6;
/// Distance at which it ends, metres.
pub const LAST_TREAD_ENDS_M: f32 = 2.4;
/// Height of a face that its rate counts, per metre: 10 cm.
pub const FACES_PER_M: f32 = 10.0;
/// Least height of a face that shows, metres.
pub const LEAST_FACE_M: f32 = 0.01;
/// Standard deviation of a face's ends, metres.
pub const FACE_END_SIGMA_M: f32 = 0.008;
/// Distance of a face's echoes before the riser, in overhangs.
pub const FACE_BEFORE: f32 = 0.3;
/// Depth below a surface at which an echo is as likely inside the solid as above it, metres.
pub const INSIDE_M: f32 = 0.015;
/// Standard deviation of that, metres.
pub const INSIDE_SIGMA_M: f32 = 0.012;
/// Share of what is below a floating tread that counts as inside the solid.
pub const INSIDE_OPEN: f32 = 0.35;
/// Density of a wall's echoes, in those of a face.
pub const WALL_SHARE: f32 = 0.25;
/// Standard deviation of a wall's echoes off it, metres.
pub const WALL_SIGMA_M: f32 = 0.008;
/// Squared deviation, in standard deviations, beyond which an echo is no part of a wall.
pub const WALL_REACH: f32 = 60.0;
/// Depth below the ground before a wall down to which its echoes reach, metres.
pub const WALL_BELOW_M: f32 = 0.03;
/// Least range of a noise echo's density, metres.
pub const NOISE_RANGE_M: f32 = 0.1;

// Point features.

/// Way before a riser in which its echoes are looked for, metres.
pub const RISER_BEFORE_M: f32 = 0.12;
/// The same behind it.
pub const RISER_BEHIND_M: f32 = 0.10;
/// Angle from a flash within which it covers a corner, in the beams that part two features, …
pub const MASKS_CORNER: f32 = 1.64;
/// … if it is weaker than the corner's echo by no more than this, dB.
pub const MASKS_WEAKER_DB: f32 = 6.0;
/// The same of a closed riser's edge, whatever the flash's level.
pub const MASKS_EDGE: f32 = 0.82;
/// Most of an echo that features claim together.
pub const MOST_USED: f32 = 0.999;
/// Probability that a wall shows nothing.
pub const WALL_HIDDEN: f32 = 0.3;
/// Most that a riser's features gain, nats, so that their reciprocal is no zero.
pub const MOST_FOUND: f32 = 80.0;
/// Squared deviation, in standard deviations, beyond which an echo is no point feature.
pub const POINT_REACH: f32 = 100.0;
/// Distance from a hidden riser within which its echoes lie, metres.
pub const HIDDEN_X_M: f32 = 0.08;
/// Height below and above its ends within which they lie, metres.
pub const HIDDEN_Y_M: f32 = 0.12;
/// Variance of its ends, m²: 12 mm squared.
pub const HIDDEN_END_M2: f32 = 0.000_144;
/// Least height of the mirror above a foot that it sees, metres.
pub const SEES_FOOT_M: f32 = 0.005;
/// Least height above the mirror of an edge that is a feature beside the flash, metres.
pub const TOP_ABOVE_M: f32 = 0.01;

// The prior: what stairs people build.

/// Standard deviation of small overhangs, metres.
pub const OVERHANG_SIGMA_M: f32 = 0.002;
/// Density of large overhangs against that of none.
pub const OVERHANG_LARGE: f32 = 0.15;
/// All goings, metres.
pub const GOINGS_M: (f32, f32) = (0.18, 0.60);
/// Usual goings, metres.
pub const USUAL_GOINGS_M: (f32, f32) = (0.22, 0.40);
/// Spread of goings about the flight's mean, metres.
pub const GOING_SIGMA_M: f32 = 0.012;
/// Shoulder of the usual goings, metres.
pub const GOING_SHOULDER_M: f32 = 0.03;
/// Volume of the goings' prior with its shoulders, metres.
pub const GOING_VOLUME_M: f32 = 0.22;
/// Standard deviations of one going's departure from the flight's, small and large, metres, and the share of large ones.
pub const GOING_DEPARTS: (f32, f32, f32) = (0.004, 0.02, 0.05);
/// Standard deviations of one rise's departure from the flight's, small and large, metres, and the share of large ones.
pub const RISE_DEPARTS: (f32, f32, f32) = (0.0035, 0.025, 0.05);
/// Lowest usual rise of a flight, metres.
pub const LOWEST_RISE_M: f32 = 0.085;
/// Lowest usual rise of a single step, metres.
pub const LOWEST_STEP_M: f32 = 0.05;
/// Highest usual rise, metres.
pub const HIGHEST_RISE_M: f32 = 0.22;
/// Shoulder of the usual rises, metres.
pub const RISE_SHOULDER_M: f32 = 0.02;
/// Volume of the rises' prior with its shoulders, metres.
pub const RISE_VOLUME_M: f32 = 0.15;
/// Range of a box's heights, metres.
pub const BOX_HEIGHTS_M: f32 = 0.55;
/// Range of a threshold's heights, metres.
pub const THRESHOLD_HEIGHTS_M: f32 = 0.05;
/// Prior probability of nothing.
pub const NOTHING: f32 = 0.31;
/// Prior probability of a ramp at one of [`RAMPS`] slopes.
pub const RAMP: f32 = 0.08;
/// Number of slopes that it is shared among.
pub const RAMPS: f32 = 12.0;
/// Prior probability of a drop.
pub const DROP: f32 = 0.03;
/// Prior probability of stairs that begin at one place.
pub const STAIRS: f32 = 0.10;
/// Prior probability of a box.
pub const BOX: f32 = 0.06;
/// Prior probability of a threshold.
pub const THRESHOLD: f32 = 0.05;

// Variants.

/// Way that a variant at an echo stands for, metres.
pub const SPOT_M: f32 = 0.006;
/// Least rise of a variant, metres.
pub const LEAST_RISE_M: f32 = 0.03;
/// Least odds of a riser that a variant puts behind the last.
pub const LEAST_ODDS: f32 = 1e-5;
/// Farthest riser behind the last, metres from it.
pub const BEHIND_TO_M: f32 = 1.6;
/// Room between it and a wall, metres.
pub const BEHIND_WALL_M: f32 = 0.1;
/// Shortest and longest going of a flight that goes on, metres.
pub const BEHIND_GOINGS_M: (f32, f32) = (0.20, 0.60);
/// Going from which on it may lead over a landing, metres.
pub const LANDING_FROM_M: f32 = 0.4;
/// Distance of places for the next riser, metres.
pub const BEHIND_GRID_M: f32 = 0.08;
/// What the next rise differs from the mean by, metres, and how often.
pub const BEHIND_RISES: [(f32, f32); 3] = [(0.0, 0.6), (-RISE_OFF_M, 0.2), (RISE_OFF_M, 0.2)];
/// Difference of a rise to the mean in a variant, metres.
pub const RISE_OFF_M: f32 = 0.03;
/// Odds of an odd rise.
pub const ODD_ODDS: f32 = 0.1;
/// Nearest and farthest first step where none is told, metres.
pub const FLOOR_FROM_TO_M: (f32, f32) = (0.24, 2.6);
/// Room between it and a wall, metres.
pub const FLOOR_WALL_M: f32 = 0.15;
/// Distance of places for it, metres.
pub const FLOOR_GRID_M: f32 = 0.16;
/// Odds of one step, box or threshold.
pub const FLOOR_ODDS: f32 = 0.8;
/// Way over which a step or drop is spread, metres.
pub const FLOOR_WAY_M: f32 = 2.5;
