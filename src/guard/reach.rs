//! Free distance from the likelihoods of hazards by place.
//!
//! At most one slot holds the first hazard across the way: with w_k = ρ exp(L_k) for each slot and kind, L its log-
//! likelihood ratio to ground that goes on, P(first hazard in k) = w_k / (1 + Σ w). Objects beside ground that is
//! still visible are independent of it: P_k = w_k / (1 + w_k). The free distance ends in the slot in which the sum of
//! both exceeds the risk.

use crate::math;
use crate::model::Surfaces;
use crate::model::above::Above;
use crate::model::lines::Lines;
use crate::model::surfaces::{SLOT_M, SLOTS};
use crate::params::guard::{
    ACROSS_PER_M, BESIDE_PER_M, FARTHEST_M, MARGIN_M, NAMED, NAMED_WITHIN_M, RISK,
};
use crate::verdict::{FreeGround, HazardKind};

/// Maximum log-likelihood ratio of a hazard, nats: its exponential and the weight of a slot stay finite.
const MAX_NATS: f32 = 40.0;

/// End of the free ground: place at which the sum of the hazards' probabilities exceeds [`RISK`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeEnd {
    /// Distance from the mirror, metres.
    pub end_m: f32,
    /// Probability of a hazard nearer than `end_m`.
    pub before: f32,
}

/// Kinds of hazards, in the order of the first index of [`Hazards`]' probabilities.
const KINDS: [HazardKind; 3] = [HazardKind::Rise, HazardKind::Drop, HazardKind::Obstacle];

/// Probability of a hazard by kind, in the order of [`KINDS`], and by slot: slot `k` begins `k` · [`SLOT_M`] metres
/// from the mirror. For rises and drops that of the first hazard across the way, for obstacles that of any.
#[derive(Debug)]
pub struct Hazards {
    probabilities: [[f32; SLOTS]; KINDS.len()],
}

impl Hazards {
    /// Computes the probabilities of a sweep from the log-likelihood ratios of rises and drops (`surfaces`) and of
    /// obstacles (`above`).
    pub fn new(surfaces: &Surfaces, above: &Above, lines: &Lines) -> Self {
        let mut probabilities = [[0.0; SLOTS]; KINDS.len()];
        let [rise, drop, beside] = &mut probabilities;
        let mut total = 1.0;
        for (k, (rise, drop)) in rise.iter_mut().zip(drop.iter_mut()).enumerate() {
            let x_m = (k as f32 + 0.5) * SLOT_M;
            *rise = weight(ACROSS_PER_M, surfaces.rise_at(x_m));
            *drop = weight(ACROSS_PER_M, surfaces.drop_at(x_m));
            total += *rise + *drop;
        }
        let share = 1.0 / total;
        let across = rise.iter_mut().chain(drop.iter_mut());
        across.for_each(|weight| *weight *= share);
        above.things(lines, |b, nats| {
            // `as` saturates.
            let slot = (lines.x_m(lines.range_m(b)) / SLOT_M) as usize;
            if let Some(place) = beside.get_mut(slot) {
                let odds = weight(BESIDE_PER_M, nats);
                *place = math::max(*place, odds / (1.0 + odds));
            }
        });
        Self { probabilities }
    }

    /// Returns the end of the free ground: the beginning of the slot in which the sum of the probabilities exceeds
    /// [`RISK`].
    pub fn reach(&self) -> FreeEnd {
        let [rise, drop, beside] = &self.probabilities;
        let across = rise.iter().zip(drop).map(|(rise, drop)| rise + drop);
        let mut before = 0.0;
        for (k, here) in across.zip(beside).map(|(a, b)| a + b).enumerate() {
            if before + here > RISK {
                let end_m = k as f32 * SLOT_M;
                return FreeEnd { end_m, before };
            }
            before += here;
        }
        FreeEnd {
            end_m: SLOTS as f32 * SLOT_M,
            before,
        }
    }

    /// Returns the free distance, its hazard's kind and the confidence. `reach` is the end of the free ground in this
    /// sweep, `last_m` that found by the sweep before, metres from the mirror's present position; the nearer of both
    /// counts.
    pub fn free(&self, reach: FreeEnd, last_m: Option<f32>) -> FreeGround {
        let end_m = last_m.map_or(reach.end_m, |last_m| math::min(last_m, reach.end_m));
        let free_m = math::max(end_m - MARGIN_M, 0.0);
        // `as` saturates.
        let near = ((free_m + NAMED_WITHIN_M) / SLOT_M) as usize;
        let sums = self
            .probabilities
            .iter()
            .map(|kind| kind.iter().take(near).sum::<f32>());
        let named = KINDS
            .into_iter()
            .zip(sums)
            .max_by(|a, b| a.1.total_cmp(&b.1));
        FreeGround {
            free_m,
            hazard: match named.filter(|(_, p)| *p > NAMED) {
                Some((kind, _)) => kind,
                None if end_m >= FARTHEST_M => HazardKind::None,
                None => HazardKind::Unknown,
            },
            confidence: 1.0 - reach.before,
        }
    }
}

/// Returns the prior weight of a hazard in one slot times its likelihood ratio, from its density per metre and its
/// log-likelihood ratio, nats.
#[inline(never)]
fn weight(per_m: f32, nats: f32) -> f32 {
    per_m * SLOT_M * math::exp(math::min(nats, MAX_NATS))
}
