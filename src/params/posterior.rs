//! Constants of the posterior: its measurement model, its prior and its variants.
//!
//! They are constants rather than fields of [`super::Params`], since nothing changes them at run time. Numbers
//! without another stated origin were tuned by hand. Numbers that are counted from simulated scans are in
//! [`super::measured`].

/// Lower and upper limit of a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Lower limit.
    pub low: f32,
    /// Upper limit.
    pub high: f32,
}

impl Limits {
    /// Returns a range from its limits.
    pub const fn new(low: f32, high: f32) -> Self {
        Self { low, high }
    }
}

/// Distribution of the deviations of a flight's goings or rises from their mean: a mixture of two normal distributions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviations {
    /// Standard deviation of usual deviations, metres.
    pub core_m: f32,
    /// Standard deviation of large deviations, metres.
    pub wide_m: f32,
    /// Share of large deviations.
    pub wide_share: f32,
}

/// Difference of the next rise from the mean rise of its flight, with its prior share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RiseOff {
    /// Difference, metres.
    pub off_m: f32,
    /// Prior share.
    pub share: f32,
}

// Arithmetic.

/// Slope of the logistic function that approximates the normal distribution to within 0.01.
pub const NORMAL_SLOPE: f32 = 1.702;
/// Minimum probability, so that its logarithm is finite.
pub const MIN_PROBABILITY: f32 = 1e-30;
/// ln √(2π), rounded.
pub const LN_ROOT_TAU: f32 = 0.919;
/// 1 / √(2π), rounded.
pub const PER_ROOT_TAU: f32 = 0.4;
/// Variance of an even distribution over a unit: 1 / 12.
pub const EVEN_VARIANCE: f32 = 1.0 / 12.0;
/// Minimum standard deviation of a level, metres, so that it can be a divisor.
pub const MIN_SIGMA_M: f32 = 1e-4;
/// Minimum distance or range as a divisor, metres.
pub const MIN_RANGE_M: f32 = 0.05;
/// Minimum distance over which a slope is computed, metres.
pub const MIN_X_M: f32 = 0.02;

// The density of a deviation: a Gaussian with heavy tails, over the squared deviation in standard deviations.

/// Weight of the Gaussian.
pub const CORE_SHARE: f32 = 0.92;
/// Weight of the tails at their centre.
pub const TAIL_SHARE: f32 = 0.005;
/// Squared deviation at which the tails have fallen to a sixteenth.
pub const TAIL_Z2: f32 = 128.0;
/// Squared deviation beyond which the tails are cut off.
pub const TAIL_END_Z2: f32 = 120.0;
/// Density beyond [`TAIL_END_Z2`].
pub const TAIL_END: f32 = 1e-9;

// Levels.

/// Decibels per unit of q.
pub const TEN_DB: f32 = 10.0;
/// Units of q per decibel.
pub const PER_TEN_DB: f32 = 0.1;
/// Level of the strongest echo at which q is 0, dB.
pub const REFERENCE_DB: f32 = 30.0;
/// Fall of a point feature's level with range, dB per decade.
pub const FADE_DB: f32 = 20.0;
/// Range beyond which the level falls, metres.
pub const FADE_FROM_M: f32 = 0.3;
/// Range of levels over which the flat share of the densities is spread, dB.
pub const LEVELS_DB: f32 = 50.0;
/// Minimum share of a class's levels above the detection threshold.
pub const MIN_DETECTED_SHARE: f32 = 0.02;
/// Flat share of the levels of point features, of faces and of echoes in the air.
pub const ANY_LEVEL: f32 = 0.05;
/// Flat share of the levels of echoes inside the solid.
pub const ANY_LEVEL_INSIDE: f32 = 0.01;
/// Flat share of the levels of treads.
pub const ANY_LEVEL_TREAD: f32 = 0.002;
/// Flat share of the levels of the floor.
pub const ANY_LEVEL_FLOOR: f32 = 0.005;
/// Level at which the riser before counts as faint, dB; also that of a riser with none before it.
pub const FAINT_DB: f32 = 15.0;
/// Maximum level of the riser before that is counted, dB.
pub const OUTSHINES_DB: f32 = 35.0;
/// Level that stands for a riser before without an echo, dB.
pub const SHOWS_NOTHING_DB: f32 = 3.0;
/// Maximum distance between a riser and an echo that counts for its level, metres.
pub const SHOWN_WITHIN_M: f32 = 0.025;
/// Maximum height difference between the mirror and a flash's echo, metres.
pub const FLASH_WITHIN_M: f32 = 0.03;

// Accuracy and resolution.

/// Factor on the standard deviation of an echo's angle.
pub const ANGLE_SIGMAS: f32 = 1.5;
/// Minimum standard deviation of an echo's angle, rad.
pub const MIN_ANGLE_SIGMA_RAD: f32 = 0.0015;
/// Minimum angle between two features that are two echoes, in beam widths.
pub const APART_BEAMS: f32 = 0.9;
/// Minimum range difference of two features that are two echoes, metres, with bins of [`BIN_M`].
pub const APART_RANGE_M: f32 = 0.02;
/// Bin width for which [`APART_RANGE_M`] holds, metres.
pub const BIN_M: f32 = 0.0117;
/// Visible extent of a hidden riser that counts as one resolution cell of room, metres.
pub const HIDDEN_ROOM_M: f32 = 0.05;
/// Maximum number of point features of one riser.
pub const FEATURES: usize = 3;
/// Number of classes of extended features whose extent depends on the staircase: face, tread, floor.
pub const SURFACES: usize = 3;

// Extended features.

/// Distance at which the floor's level and density are those of its class, metres.
pub const FLOOR_M: f32 = 0.6;
/// Distance before [`FLOOR_M`] over which the floor's level and density still rise, metres.
pub const FLOOR_NEARER_M: f32 = 0.4;
/// Fall of the floor's level with distance, dB per metre.
pub const FLOOR_FALL_DB: f32 = 8.0;
/// Fall of the log-density of the floor's echoes with distance, per metre.
pub const FLOOR_FALL: f32 = 1.5;
/// Distance at which the floor begins, metres.
pub const FLOOR_BEGINS_M: f32 = 0.34;
/// Distance at which the floor ends without an obstacle, metres.
pub const FLOOR_ENDS_M: f32 = 2.2;
/// Share of the floor that is visible under open treads.
pub const FLOOR_UNDER: f32 = 0.3;
/// Length of the last tread, metres.
pub const LAST_TREAD_M: f32 = 0.6;
/// Maximum distance of the end of the last tread, metres.
pub const LAST_TREAD_ENDS_M: f32 = 2.4;
/// Reciprocal of the face height to which its rate refers, per metre: 10 cm.
pub const FACES_PER_M: f32 = 10.0;
/// Minimum visible height of a face, metres.
pub const MIN_FACE_M: f32 = 0.01;
/// Standard deviation of a face's ends, metres.
pub const FACE_END_SIGMA_M: f32 = 0.008;
/// Distance of a face's echoes before the riser, in units of the overhang.
pub const FACE_BEFORE: f32 = 0.3;
/// Depth below a surface at which an echo is as likely inside the solid as above it, metres.
pub const INSIDE_M: f32 = 0.015;
/// Standard deviation of [`INSIDE_M`], metres.
pub const INSIDE_SIGMA_M: f32 = 0.012;
/// Share of the space below an open tread that counts as inside the solid.
pub const INSIDE_OPEN: f32 = 0.35;
/// Minimum range in the density of noise echoes, metres.
pub const NOISE_RANGE_M: f32 = 0.1;

// Point features.

/// Distance before a riser within which its echoes are searched, metres.
pub const RISER_BEFORE_M: f32 = 0.12;
/// Distance behind a riser within which its echoes are searched, metres.
pub const RISER_BEHIND_M: f32 = 0.10;
/// Angle from a flash within which it may mask a corner, in units of the beam width at which features are resolved.
pub const MASKS_CORNER: f32 = 1.64;
/// Maximum level of a corner's echo above the flash that masks it, dB.
pub const MASKS_WEAKER_DB: f32 = 6.0;
/// Angle from a flash within which it masks a closed riser's edge at any level, in the same units as
/// [`MASKS_CORNER`].
pub const MASKS_EDGE: f32 = 0.82;
/// Maximum share of an echo that all features together may use.
pub const MAX_USED_SHARE: f32 = 0.999;
/// Maximum log-likelihood ratio of a riser's features, nats, so that the exponential of its negative is not 0.
pub const MAX_FOUND_LLR: f32 = 80.0;
/// Squared deviation, in standard deviations, beyond which an echo is not a point feature.
pub const POINT_REACH: f32 = 100.0;
/// Maximum horizontal distance of a hidden riser's echoes from it, metres.
pub const HIDDEN_X_M: f32 = 0.08;
/// Maximum distance of a hidden riser's echoes below and above its visible ends, metres.
pub const HIDDEN_Y_M: f32 = 0.12;
/// Variance of the visible ends of a hidden riser, m²: 12 mm squared.
pub const HIDDEN_END_M2: f32 = 0.000_144;
/// Minimum height of the mirror above a foot that is visible, metres.
pub const SEES_FOOT_M: f32 = 0.005;
/// Minimum height of an edge above the mirror at which it is a feature besides the flash, metres.
pub const TOP_ABOVE_M: f32 = 0.01;

// The prior: stairs as they are built.

/// Standard deviation of small overhangs, metres.
pub const OVERHANG_SIGMA_M: f32 = 0.002;
/// Density of large overhangs, relative to that of no overhang.
pub const OVERHANG_LARGE: f32 = 0.15;
/// Range of all goings, metres.
pub const GOINGS_M: Limits = Limits::new(0.18, 0.60);
/// Range of usual goings, metres.
pub const USUAL_GOINGS_M: Limits = Limits::new(0.22, 0.40);
/// Standard deviation of a going about the flight's mean, metres.
pub const GOING_SIGMA_M: f32 = 0.012;
/// Standard deviation of the Gaussian shoulders of the usual goings, metres.
pub const GOING_SHOULDER_M: f32 = 0.03;
/// Integral of the goings' prior with its shoulders, metres.
pub const GOING_VOLUME_M: f32 = 0.22;
/// Deviations of one going from the flight's.
pub const GOING_DEPARTS: Deviations = Deviations {
    core_m: 0.004,
    wide_m: 0.02,
    wide_share: 0.05,
};
/// Deviations of one rise from the flight's.
pub const RISE_DEPARTS: Deviations = Deviations {
    core_m: 0.0035,
    wide_m: 0.025,
    wide_share: 0.05,
};

// Variants.

/// Length of way that a variant at an echo represents, metres.
pub const SPOT_M: f32 = 0.006;
/// Minimum rise of a variant, metres.
pub const MIN_RISE_M: f32 = 0.03;
/// Minimum prior odds of a variant's riser behind the last.
pub const MIN_ODDS: f32 = 1e-5;
/// Maximum distance of a variant's riser behind the last, metres from that.
pub const BEHIND_TO_M: f32 = 1.6;
/// Minimum distance between that riser and a wall, metres.
pub const BEHIND_WALL_M: f32 = 0.1;
/// Shortest and longest going of a flight that goes on, metres.
pub const BEHIND_GOINGS_M: Limits = Limits::new(0.20, 0.60);
/// Minimum going that may be a landing, metres.
pub const LANDING_FROM_M: f32 = 0.4;
/// Spacing of the places for the next riser, metres.
pub const BEHIND_GRID_M: f32 = 0.08;
/// Differences of the next rise from the mean, with their prior shares.
pub const BEHIND_RISES: [RiseOff; 3] = [
    RiseOff {
        off_m: 0.0,
        share: 0.6,
    },
    RiseOff {
        off_m: -RISE_OFF_M,
        share: 0.2,
    },
    RiseOff {
        off_m: RISE_OFF_M,
        share: 0.2,
    },
];
/// Difference of a variant's rise from the mean, metres.
pub const RISE_OFF_M: f32 = 0.03;
/// Prior odds of an irregular rise.
pub const ODD_ODDS: f32 = 0.1;
/// Nearest and farthest single step on bare ground, metres.
pub const FLOOR_FROM_TO_M: Limits = Limits::new(0.24, 2.6);
/// Minimum distance between that step and a wall, metres.
pub const FLOOR_WALL_M: f32 = 0.15;
/// Spacing of the places for that step, metres.
pub const FLOOR_GRID_M: f32 = 0.16;
/// Prior odds of a single step, box or threshold.
pub const FLOOR_ODDS: f32 = 0.8;
/// Length of way over which a single step or a drop is evenly distributed, metres.
pub const FLOOR_WAY_M: f32 = 2.5;

// Echoes and their features.

/// Minimum range of an echo, metres: nearer, the mirror's own echo covers everything.
pub const NEAREST_ECHO_M: f32 = 0.12;
/// Width of an undisturbed echo's lobe over the angle, in units of a point scatterer's.
pub const CLEAN_WIDTH: f32 = 1.0;
/// Area of the scanned sector, m², over which echoes in the air and inside the solid are evenly distributed.
pub const SECTOR_AREA_M2: f32 = 4.4;
/// Extent of the scan, over which noise echoes are evenly distributed: range in metres times angle in radians.
pub const NOISE_EXTENT: f32 = 3.3;
/// Distance behind a riser up to which echoes still belong to the tread before it, metres.
pub const BEHIND_RISER_M: f32 = 0.02;
/// Maximum range difference between a point feature and its echo, metres.
pub const RANGE_GATE_M: f32 = 0.06;
/// Maximum distance across the line of sight between a point feature and its echo, metres.
pub const CROSS_GATE_M: f32 = 0.20;
/// Squared deviation of an echo from a face, in squared standard deviations, beyond which the echo is not part of the
/// face.
pub const FACE_REACH: f32 = 100.0;
/// Minimum probability of detection of a feature: scenes differ, however many were counted.
pub const MIN_P_DETECTED: f32 = 0.02;
/// Maximum probability of detection of a feature.
pub const MAX_P_DETECTED: f32 = 0.985;

// Places of features.

/// Thickness of an open tread, metres.
pub const TREAD_THICK_M: f32 = 0.045;
/// Minimum extent of a face above and below the mirror's height for a full flash, metres.
pub const FRESNEL_M: f32 = 0.04;

// The prior of flights.

/// Prior probability that a flight goes on after a step.
pub const P_CONTINUES: f32 = 0.87;
/// Prior probability that a staircase has open treads.
pub const P_OPEN: f32 = 0.2;
/// Probability of a going that deviates from those of its flight, evenly distributed over 0.4 m.
pub const P_IRREGULAR_GOING: f32 = 0.07;
/// Density of a landing's length, per metre. One in five flights goes on after a landing, of up to a metre and more.
pub const LANDING_PER_M: f32 = 0.2;

// Initial hypotheses.

/// Riser heights from which the refinement starts, as multiples of the search's riser height.
pub const STRETCHES: [f32; 2] = [0.95, 1.05];
/// Overhangs that are tried besides the measured one, metres.
pub const OVERHANG_STARTS_M: [f32; 2] = [0.0, 0.03];
/// Maximum score margin behind the search's best flight at which a flight is proposed, nats. With 5 nats, 8 of 2,014
/// validation scenes fewer are exact; with 20 nats, 14 fewer.
pub const PROPOSAL_MARGIN_NATS: f32 = 3.0;
/// Maximum score margin behind the search's best flight, nats, for that flight in the other build (closed or open)
/// and for hypotheses of earlier scans. It is wide, since the search does not model walls behind open treads or
/// earlier scans.
pub const OTHER_MARGIN_NATS: f32 = 12.0;
/// Minimum distance of a wall on level ground from the mirror, metres: nearer are the footrests.
pub const NEAREST_WALL_M: f32 = 0.3;
/// Minimum distance of a wall from the last riser, metres: the shortest landing.
pub const SHORTEST_LANDING_M: f32 = 0.28;

// Places and heights of variants.

/// Minimum SNR of an echo that may be a riser's place, dB.
pub const SPOT_DB: f32 = 8.0;
/// Minimum distance between two echoes that are both tried as a riser's place, metres.
pub const SPOTS_APART_M: f32 = 0.015;
/// Standard deviation of the height of a tread that a variant sets rather than measures, metres.
pub const PLACED_SIGMA_M: f32 = 0.01;
/// Standard deviation of the height of a tread that is seen from above, metres.
pub const TREAD_SIGMA_M: f32 = 0.003;
/// Deviations of an irregular riser's height from that of its hypothesis, metres.
pub const IRREGULAR_M: [f32; 2] = [-0.03, 0.03];
/// Distance from a riser beyond which its face does not change an echo's likelihood, metres.
pub const FACE_NEAR_M: f32 = 0.10;

// Reports of the particles.

/// Minimum probability at which a possible step is reported.
pub const MIN_POSSIBLE_PROBABILITY: f32 = 0.05;
/// Maximum distance in log-weight from the likeliest hypothesis at which variants are added, nats.
pub const VARIED_WITHIN_NATS: f32 = 4.0;

/// A drop is reported if the ground ends in one and the same place (within two slots of 5 cm) with at least this
/// probability.
pub const MIN_DROP_PROBABILITY: f32 = 0.5;
/// Maximum probability that the ground ends nearer than a reported drop's distance less three standard deviations; the
/// reported standard deviation is enlarged until this holds.
pub const MAX_NEARER_PROBABILITY: f32 = 0.005;

// Steps of the answer.

/// Maximum horizontal distance of a flash straight below the mirror, metres.
pub const PLUMB_FLASH_M: f32 = 0.03;
/// Maximum distance along a tread between one of its ends and an echo that counts as the echo of that end, metres.
pub const TREAD_END_M: f32 = 0.02;

/// Minimum number of echoes that contradict a flight at which `blocked-view` is reported: fewer may be chance.
pub const MIN_CONTRADICTING_ECHOES: usize = 3;

// Log-odds of way cells.

/// Lower limit of the log-odds that an answer is first wrong in a way cell, nats.
pub const MIN_LOG_ODDS: f32 = -9.0;
/// Upper limit of the log-odds that an answer is first wrong in a way cell, nats.
pub const MAX_LOG_ODDS: f32 = 4.0;
