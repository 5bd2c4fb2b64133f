//! Visibility behind an edge, going up, and below it, going down.

use crate::math;
use crate::params::posterior;

/// Returns the lowest visible height at distance `x_m` over an edge at distance `edge_m`, behind which the surface is
/// at height `base_m`, from a mirror at height `height_m`: metres, heights above the ground. An infinite `edge_m`
/// stands for no edge before.
pub fn sight_m(height_m: f32, x_m: f32, base_m: f32, edge_m: f32) -> f32 {
    if base_m > height_m && edge_m.is_finite() && edge_m > 0.0 {
        height_m + (base_m - height_m) * x_m / math::max(edge_m, posterior::MIN_RANGE_M)
    } else {
        base_m
    }
}

/// Returns the distance from which on the tread below an edge at `edge_m` is visible, metres. `deeper` is the ratio
/// of the tread's depth below the mirror to that of the edge. Ahead of the mirror the sight line over the edge is the
/// limit; behind the mirror it is the edge itself.
pub fn tread_begins_m(edge_m: f32, deeper: f32) -> f32 {
    if edge_m > 0.0 {
        edge_m * deeper
    } else {
        edge_m
    }
}
