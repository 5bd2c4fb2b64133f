//! Grid of places at which an edge may lie, 1 cm apart; densities over it; the deviations of edges from equal goings.

use crate::math;
use crate::params::descent::{BESIDE_SHARE, ODD_SHARE};

/// Number of places at which an edge may lie: from behind the mirror of a chair that stands before the stairs to the
/// end of the scanned sector.
pub(super) const PLACES: usize = 201;
/// Horizontal distance of the first place from the mirror, metres.
pub(super) const FIRST_PLACE_M: f32 = -0.30;
/// Spacing of the places of an edge, metres: about the accuracy of the echoes.
pub(super) const PLACE_M: f32 = 0.01;
/// Log-density of an edge relative to its largest one, by place, in 1/64 nat.
pub(super) type EdgeDensity = [i16; PLACES];
/// Units of a stored log-density per nat.
pub(super) const PER_NAT: f32 = 64.0;
/// Minimum log-density of an edge relative to its largest one, nats: smaller ones count as this.
pub(super) const MIN_NATS: f32 = -20.0;
/// Density of an edge, relative to its largest one, at [`MIN_NATS`].
pub(super) const MIN_DENSITY: f32 = 2e-9;
/// Maximum deviation of an edge from equal goings, in places of 1 cm.
const ODD_PLACES: usize = 7;
/// Share of all edges, by those that deviate, at each place within [`ODD_PLACES`] of equal goings.
const EACH_ODD: f32 = ODD_SHARE / (2 * ODD_PLACES + 1) as f32;

/// Returns the horizontal distance of place `k` from the mirror, metres.
pub(super) fn place_m(k: usize) -> f32 {
    FIRST_PLACE_M + PLACE_M * k as f32
}

/// Returns the index of the first place at or beyond a distance from the mirror, metres.
pub(super) fn place_beyond(x_m: f32) -> usize {
    // `as` saturates.
    (math::ceil((x_m - FIRST_PLACE_M) * (1.0 / PLACE_M)) as usize).min(PLACES)
}

/// Density of an edge by place, convolved with its deviations from equal goings: mostly half a place, sometimes
/// several.
pub(super) struct EdgeSpread<'d> {
    pub density: &'d [f32; PLACES],
}

impl EdgeSpread<'_> {
    /// Returns the convolved density of the edge for flights whose equal goings put it at `place`.
    pub fn at(&self, place: usize) -> f32 {
        let mut sum = 0.0;
        self.each(place, &mut |_, density| sum += density);
        sum
    }

    /// For flights whose equal goings put the edge at `place`: calls `part` with each place where it may really lie,
    /// and the share of the density there.
    pub fn each(&self, place: usize, part: &mut dyn FnMut(usize, f32)) {
        let first = place.saturating_sub(ODD_PLACES);
        let near = self.density.iter().enumerate().skip(first);
        for (k, &density) in near.take(place + ODD_PLACES + 1 - first) {
            let small = match k.abs_diff(place) {
                0 => 1.0 - 2.0 * BESIDE_SHARE,
                1 => BESIDE_SHARE,
                _ => 0.0,
            };
            part(k, density * ((1.0 - ODD_SHARE) * small + EACH_ODD));
        }
    }
}

/// Writes the logarithm, in 1/64 nat, of the density of an edge at all places, convolved with its deviations from equal
/// goings.
#[inline(never)]
pub(super) fn spread_all(density: &[f32; PLACES], out: &mut EdgeDensity) {
    let at = |k: Option<usize>| k.and_then(|k| density.get(k)).copied().unwrap_or(0.0);
    let mut around: f32 = density.iter().take(ODD_PLACES).sum();
    for (place, value) in out.iter_mut().enumerate() {
        around += at(Some(place + ODD_PLACES)) - at(place.checked_sub(ODD_PLACES + 1));
        let beside = at(place.checked_sub(1)) + at(Some(place + 1));
        let small = (1.0 - 2.0 * BESIDE_SHARE) * at(Some(place)) + BESIDE_SHARE * beside;
        let sum = (1.0 - ODD_SHARE) * small + EACH_ODD * math::max(around, 0.0);
        let nats = if sum > MIN_DENSITY {
            math::ln(sum)
        } else {
            MIN_NATS
        };
        // `as` saturates.
        *value = (nats * PER_NAT) as i16;
    }
}
