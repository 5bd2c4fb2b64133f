//! Depth of the surface behind an edge where the ground ends, from the echoes below the ground.
//!
//! In: the scan's echoes and the reported place of the edge. Out: a depth, or none where no depth is probable enough.
//! The [ground's line](crate::model::surfaces) has four depths: enough to detect lower ground, too few to measure its
//! depth. An echo's height has a standard deviation of about 1 cm. The method is a posterior over a grid of depths
//! and "no surface is seen". Each echo behind the edge is either from a surface at the depth, with a normal density
//! around it, or from anything else, evenly distributed over a metre. A surface is visible from the end of the edge's
//! shadow on, which depends on its depth.

use crate::math;
use crate::model::ModelEcho;
use crate::params::drop_depth::{APART_M, GROUND_M, HALF_M, LEAST, MAX_M, ROUGH_M, SHARE, SLACK_M};
use crate::params::posterior;

/// Smallest depth below the ground of the grid of depths, metres: less than any drop.
const FIRST_M: f32 = 0.04;
/// Spacing of the grid's depths, metres.
const STEP_M: f32 = 0.005;
/// Number of the grid's depths: up to 40 cm, so that the second tread of a flight competes with the first.
const DEPTHS: usize = 73;
/// Squared deviation of an echo's height from a surface, in squared standard deviations, beyond which the echo is not
/// the surface's. Most echoes are beyond it for most depths, which saves their square root and exponential.
const FAR: f32 = 25.0;
/// Log-likelihood ratio of a visible surface to none that each echo far from the surface contributes, nats; negative.
const NOT_ITS_OWN: f32 = math::ln(1.0 - SHARE);

/// Returns the depth of the next surface behind an edge `edge_m` ahead, metres below the ground; `None` where no run
/// of neighbouring depths has a probability of at least 90 %. `echoes` are sorted by distance; `height_m` is the
/// mirror's height above the ground, metres.
#[inline(never)]
pub fn behind(echoes: &[ModelEcho], height_m: f32, edge_m: f32) -> Option<f32> {
    let depth = |k: usize| FIRST_M + STEP_M * k as f32;
    let mut nats = [0.0; DEPTHS];
    for (k, nats) in nats.iter_mut().enumerate() {
        *nats = log_likelihood(echoes, height_m, edge_m, depth(k));
    }
    let (best, most) = nats
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(b.1))
        .map(|(k, most)| (depth(k), math::max(*most, 0.0)))?;
    // "No surface is seen" has half of the prior, all depths together the other half.
    let mut all = DEPTHS as f32 * math::exp(-most);
    let (mut near, mut sum) = (0.0, 0.0);
    for (k, nats) in nats.iter().enumerate() {
        let weight = math::exp(nats - most);
        all += weight;
        if (depth(k) - best).abs() < HALF_M + 0.5 * STEP_M {
            near += weight;
            sum += weight * depth(k);
        }
    }
    let depth = sum / near;
    (near >= LEAST * all && depth <= MAX_M).then_some(depth)
}

/// Returns the log-likelihood ratio of a surface `depth_m` below the ground, behind the edge, against no visible
/// surface, nats.
fn log_likelihood(echoes: &[ModelEcho], height_m: f32, edge_m: f32, depth_m: f32) -> f32 {
    let shadow_m = edge_m * (1.0 + depth_m / height_m) - SLACK_M;
    let from_m = math::max(edge_m, shadow_m);
    let (mut sum, mut last_m) = (0.0, f32::NEG_INFINITY);
    for e in echoes {
        if e.y_m > -GROUND_M || e.x_m < from_m || e.x_m - last_m < APART_M {
            continue;
        }
        last_m = e.x_m;
        let variance_m2 = ROUGH_M * ROUGH_M + e.across_m * e.across_m;
        let off_m = e.y_m + depth_m;
        let z2 = off_m * off_m / variance_m2;
        sum += if z2 > FAR {
            NOT_ITS_OWN
        } else {
            let density = posterior::PER_ROOT_TAU / math::sqrt(variance_m2) * math::exp(-0.5 * z2);
            math::ln(1.0 - SHARE + SHARE * density)
        };
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    const HEIGHT_M: f32 = 0.4;

    /// Returns echoes at these distances and heights, metres, each with a standard deviation of 5 mm.
    fn seen(places: &[(f32, f32)]) -> Vec<ModelEcho> {
        let echo = |&(x_m, y_m): &(f32, f32)| {
            let mut echo = ModelEcho::default();
            (echo.x_m, echo.y_m, echo.across_m) = (x_m, y_m, 0.005);
            echo
        };
        places.iter().map(echo).collect()
    }

    fn depth_of(places: &[(f32, f32)]) -> Option<f32> {
        behind(&seen(places), HEIGHT_M, 0.8)
    }

    #[test]
    fn depth_is_measured_from_echoes_behind_the_edges_shadow() {
        for depth_m in [0.05, 0.083, 0.126, 0.171, 0.21] {
            let from_m = 0.8 * (1.0 + depth_m / HEIGHT_M);
            let places = [(0.0, 0.004), (0.06, -0.003), (0.12, 0.005), (0.18, -0.004)];
            let places = places.map(|(more_m, off_m)| (from_m + more_m, off_m - depth_m));
            let reported_m = depth_of(&places).unwrap();
            assert!(
                (reported_m - depth_m).abs() < 0.005,
                "{depth_m}: {reported_m}"
            );
        }
    }

    #[test]
    fn echoes_of_the_ground_and_a_single_echo_give_no_depth() {
        assert_eq!(depth_of(&[]), None);
        assert_eq!(depth_of(&[(0.5, 0.0), (0.6, 0.01), (1.3, -0.02)]), None);
        assert_eq!(depth_of(&[(1.2, -0.12)]), None);
    }

    #[test]
    fn echoes_in_the_edges_shadow_give_no_depth() {
        // At 17 cm the shadow of an edge 0.8 m ahead ends at 1.14 m.
        let places = [0.0, 0.06, 0.12, 0.18].map(|more| (0.85 + more, -0.17));
        assert_eq!(depth_of(&places), None);
    }

    #[test]
    fn far_wall_of_a_hole_gives_no_depth() {
        let wall = [-0.34, -0.27, -0.2, -0.13, -0.06].map(|y_m| (1.4, y_m));
        assert_eq!(depth_of(&wall), None);
    }

    #[test]
    fn depth_beyond_two_low_risers_is_not_reported() {
        let places = [0.0, 0.06, 0.12, 0.18].map(|more| (1.6 + more, -0.34));
        assert_eq!(depth_of(&places), None);
    }

    #[test]
    fn two_equally_likely_depths_give_no_depth() {
        let places = [
            (1.05, -0.1),
            (1.1, -0.1),
            (1.3, -0.2),
            (1.36, -0.2),
            (1.42, -0.1),
            (1.48, -0.2),
        ];
        assert_eq!(depth_of(&places), None);
    }

    #[test]
    fn any_mirror_height_gives_no_panic() {
        let places = seen(&[(0.9, -0.1), (1.0, -0.1), (1.1, -0.1)]);
        for height_m in [0.0, f32::NAN, -0.4, f32::INFINITY] {
            let _ = behind(&places, height_m, 0.8);
        }
    }
}
