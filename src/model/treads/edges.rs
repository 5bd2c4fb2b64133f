//! Places where an edge may lie, 1 cm apart, densities over them, and how far edges depart from equal goings.

use crate::math;

/// Places at which an edge may lie: from behind the mirror of a chair that stands before the stairs to the end of the
/// scanned sector …
pub(super) const PLACES: usize = 201;
/// … metres from the mirror …
pub(super) const FIRST_PLACE_M: f32 = -0.30;
/// … a centimetre apart, which is about as well as the echoes know them.
pub(super) const PLACE_M: f32 = 0.01;
/// Logarithm of the density of an edge's place over its largest, by place, in 64ths of a nat.
pub(super) type EdgeDensity = [i16; PLACES];
/// Logarithms are kept in 64ths of a nat …
pub(super) const PER_NAT: f32 = 64.0;
/// … down to here, where nothing counts any more …
pub(super) const LEAST_NATS: f32 = -20.0;
/// … and its density.
const LEAST_DENSITY: f32 = 2e-9;
/// Share of edges that depart from equal goings by up to [`ODD_PLACES`].
const ODD: f32 = 0.05;
/// See [`ODD`].
const ODD_PLACES: usize = 7;
/// Share of them at each place.
const EACH_ODD: f32 = ODD / (2 * ODD_PLACES + 1) as f32;
/// The others depart by 6 mm, half a place included: share of them at each place beside.
const BESIDE: f32 = 0.166;

/// Distance of a place from the mirror, metres.
pub(super) fn place_m(k: usize) -> f32 {
    FIRST_PLACE_M + PLACE_M * k as f32
}

/// The first place beyond a distance from the mirror, metres.
pub(super) fn place_beyond(x_m: f32) -> usize {
    // `as` saturates.
    (math::ceil((x_m - FIRST_PLACE_M) * (1.0 / PLACE_M)) as usize).min(PLACES)
}

/// Edges spread over what they depart from equal goings: most by half a place, some by a few.
pub(super) struct EdgeSpread<'d> {
    pub density: &'d [f32; PLACES],
}

impl EdgeSpread<'_> {
    /// Density where a flight puts an edge at a place.
    pub fn at(&self, place: usize) -> f32 {
        let mut sum = 0.0;
        self.each(place, &mut |_, density| sum += density);
        math::max(sum, f32::MIN_POSITIVE)
    }

    /// Its parts, by where the edge really lies.
    pub fn each(&self, place: usize, part: &mut dyn FnMut(usize, f32)) {
        let first = place.saturating_sub(ODD_PLACES);
        let near = self.density.iter().enumerate().skip(first);
        for (k, &density) in near.take(place + ODD_PLACES + 1 - first) {
            let small = match k.abs_diff(place) {
                0 => 1.0 - 2.0 * BESIDE,
                1 => BESIDE,
                _ => 0.0,
            };
            part(k, density * ((1.0 - ODD) * small + EACH_ODD));
        }
    }
}

/// The same at all places, as logarithms.
#[inline(never)]
pub(super) fn spread_all(density: &[f32; PLACES], out: &mut EdgeDensity) {
    let at = |k: Option<usize>| k.and_then(|k| density.get(k)).copied().unwrap_or(0.0);
    let mut around: f32 = density.iter().take(ODD_PLACES).sum();
    for (place, value) in out.iter_mut().enumerate() {
        around += at(Some(place + ODD_PLACES)) - at(place.checked_sub(ODD_PLACES + 1));
        let beside = at(place.checked_sub(1)) + at(Some(place + 1));
        let small = (1.0 - 2.0 * BESIDE) * at(Some(place)) + BESIDE * beside;
        let sum = (1.0 - ODD) * small + EACH_ODD * math::max(around, 0.0);
        let nats = if sum > LEAST_DENSITY {
            math::ln(sum)
        } else {
            LEAST_NATS
        };
        // `as` saturates.
        *value = (nats * PER_NAT) as i16;
    }
}
