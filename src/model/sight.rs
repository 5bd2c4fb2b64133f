//! What an edge leaves in sight behind it and below it.

use crate::math;
use crate::params::posterior as number;

/// Lowest height that is in sight at `x_m`, over an edge at `edge_m` behind which the level is `base_m`, from a mirror at
/// `height_m`; infinitely far off where no edge stands before.
pub fn sight_m(height_m: f32, x_m: f32, base_m: f32, edge_m: f32) -> f32 {
    if base_m > height_m && edge_m.is_finite() && edge_m > 0.0 {
        height_m + (base_m - height_m) * x_m / math::max(edge_m, number::LEAST_RANGE_M)
    } else {
        base_m
    }
}

/// Where the tread below an edge at `edge_m` comes into sight, metres: it lies `deeper` times as far below the mirror as
/// the edge. Over an edge before the mirror the sight line goes on; behind the mirror the edge itself bounds it.
pub fn tread_begins_m(edge_m: f32, deeper: f32) -> f32 {
    if edge_m > 0.0 {
        edge_m * deeper
    } else {
        edge_m
    }
}
