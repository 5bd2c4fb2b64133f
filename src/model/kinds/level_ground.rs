//! Level ground: nothing ahead, except perhaps a [wall](super::wall).

use super::variation::Variation;
use crate::model::normal::ln;
use crate::model::surfaces::Surfaces;

/// Prior probability of level ground.
const P_LEVEL_GROUND: f32 = 0.31;
/// Variants of level ground: single rises on it, and its end.
pub const VARIATIONS: &[Variation] = &[Variation::SingleRise, Variation::End];

/// Returns the log-prior of level ground, nats.
pub fn log_prior() -> f32 {
    const { ln(P_LEVEL_GROUND) }
}

/// Returns the log-likelihood ratio, from the ground's line, of level ground up to a wall at `wall_m`, metres, to ground
/// that goes on, nats.
pub fn ground_line(line: &Surfaces, wall_m: f32) -> f32 {
    line.rise_at(wall_m)
}
