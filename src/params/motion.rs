//! Tuned constants of the odometer and of the comparison of two sweeps. Numbers without another stated origin were
//! tuned by hand.

// The odometer.

/// Scale error of the odometer, which the tyres cause, as a share of the distance travelled.
pub const ODOMETER_SCALE_ERROR: f32 = 0.02;
/// Error of the odometer that does not grow with the distance travelled, metres.
pub const ODOMETER_WANDER_M: f32 = 0.002;
/// Maximum distance between two sweeps' echoes of one scatterer where the travel is known exactly, metres.
pub const SAME_PLACE_M: f32 = 0.012;

// Comparison of two sweeps.

/// SNR from which an echo has a weight in the comparison, dB; the weight is the SNR less this.
pub const FROM_DB: f32 = 8.0;
/// Maximum weight of an echo in the comparison: dB above [`FROM_DB`].
pub const MAX_DB: f32 = 25.0;
/// Maximum height difference of two sweeps' echoes of one scatterer at range 0, metres.
pub const SAME_HEIGHT_M: f32 = 0.012;
/// Increase of the maximum height difference with range, radians: one step of the scan and the shift of the
/// main lobe. The limit along the ground is [`SAME_PLACE_M`].
pub const SAME_HEIGHT_RAD: f32 = 0.008;
/// Minimum share of the echoes' weight that agrees in two sweeps from one position. Of 60 simulated pairs from
/// standing chairs all but those without echoes have 0.82 or more, of 70 from moving ones none has more than
/// 0.65.
pub const STANDING_SHARE: f32 = 0.75;
/// Maximum travel from sweep to sweep of a chair that stands, metres: a sixth of the tolerance that `ok`
/// guarantees.
pub const STANDING_M: f32 = 0.005;
/// Minimum share of the echoes' weight that agrees where the travel between the sweeps is known: 0.34 and more
/// in the pairs that were simulated for [`STANDING_SHARE`].
pub const DRIVING_SHARE: f32 = 0.33;
/// Minimum weight (dB above [`FROM_DB`], summed over echoes) by which the agreement for the reported travel
/// exceeds that for any other: two echoes of 17 dB. With it none of 200 pairs with reversed or frozen travel
/// counted as agreeing.
pub const MIN_MARGIN: f32 = 18.0;
/// Minimum share of the echoes' weight that agrees on one steady speed without motion input.
pub const STEADY_SHARE: f32 = 0.5;
/// Minimum time between an echo's two observations, as a share of the sweep interval, from which a speed is
/// estimated.
pub const MIN_SHARE: f32 = 0.25;
