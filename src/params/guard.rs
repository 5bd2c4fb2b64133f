//! Tuned constants of the guard. Numbers without another stated origin were tuned by hand.

// Objects above the ground.

/// Power of a range cell's strongest row that shows in rows far from it, as a ratio: side lobes of an unknown antenna,
/// and of a mirror that turns meanwhile. From tuning sweeps (docs/design/guard.md): with 0.02 objects are detected where none
/// are.
pub const SIDE_LOBES: f32 = 0.05;
/// Lowest power that an object is assumed to have, dB over the noise.
pub const FIRST_DB: f32 = 18.0;
/// Step between the powers that an object is assumed to have, dB.
pub const STEP_DB: f32 = 6.0;
/// Probability that a range cell without an object shows power above the ground: ghosts, tiles on edge.
pub const ODD: f32 = 0.001;

// Mean over sweeps.

/// Factor on the weight of earlier sweeps at each new sweep, if the chair's travel in between is known. From tuning
/// sweeps (docs/design/guard.md): with 0.5 and 0.8 more answers are wrong.
pub const KEPT: f32 = 0.7;
/// Factor on the weight of earlier sweeps at each new sweep, if the travel is unknown: objects that have moved blur.
pub const KEPT_UNPLACED: f32 = 0.3;

// Noise.

/// Quantile of the levels (logarithmic power) of cells off the ground, from which the mean noise is computed: it is low
/// enough not to depend on echoes of objects.
pub const QUANTILE: f32 = 0.35;

// Free ground.

/// Density of rises, and of drops, ahead of a chair, per metre. No survey counts them; a factor of four either way
/// changes the free distance of 3 % of the tuning sweeps (docs/design/guard.md).
pub const ACROSS_PER_M: f32 = 0.3;
/// Density of objects (rather than steps of the ground itself) beside which the ground is still visible, per metre.
pub const BESIDE_PER_M: f32 = 0.0003;
/// Maximum probability of a hazard nearer than the end of the free ground: a fifth of the 1 % that the contract allows;
/// the rest is for errors of the model.
pub const RISK: f32 = 0.002;
/// Distance from the end of the free ground back to the reported free distance, metres: half a slot, and the length
/// over which a beam's foot shows ground beyond an edge.
pub const MARGIN_M: f32 = 0.08;
/// Minimum probability at which the kind of the hazard (rise, drop or obstacle) is reported.
pub const NAMED: f32 = 0.5;
/// Maximum distance beyond the free distance of the hazards whose probabilities count for the reported kind, metres.
pub const NAMED_WITHIN_M: f32 = 0.35;
/// Distance from the mirror from which on the free ground ends without a hazard, at the end of the evaluated cells,
/// metres.
pub const FARTHEST_M: f32 = 1.6;
