//! From the likelihoods of hazards by place to the free distance.
//!
//! The first hazard across the way is in one slot at most: with w_k = ρ exp(L_k) for each slot and kind, L its
//! log-likelihood against ground that goes on, P(first hazard in k) = w_k / (1 + Σ w). Things that stand beside ground
//! which still shows are independent of it: P_k = w_k / (1 + w_k). The free distance ends in the slot in which the sum of
//! both passes the risk.

use crate::math;
use crate::model::Surfaces;
use crate::model::lines::{Above, Lines};
use crate::model::surfaces::{SLOT_M, SLOTS};
use crate::verdict::{Ending, FreeGround};

/// Density of rises, and of drops, ahead of a chair, per metre: what corridors, kerbs and stairs are to a day's way is
/// not counted anywhere; four times as many or as few change the free distance of 3 % of tuning sweeps (docs/guard.md).
const ACROSS_PER_M: f32 = 0.3;
/// The same of things beside which the ground still shows.
const BESIDE_PER_M: f32 = 0.0003;
/// The free distance ends where a hazard before it has this probability: half of what the contract allows of 1 in 100
/// is kept for what the model does not know.
const RISK: f32 = 0.002;
/// So far before it, metres: a slot's half, and how far a beam's foot shows ground beyond an edge.
const MARGIN_M: f32 = 0.08;
/// A kind of hazard is named from this probability on …
const NAMED: f32 = 0.5;
/// … if it is within this of the free distance's end, metres.
const NAMED_WITHIN_M: f32 = 0.35;
/// Free ground that ends here or farther is ended by nothing that a sweep sees, metres: its cells end there.
const FARTHEST_M: f32 = 1.9;
/// No log-likelihood counts more, nats: e to this and a slot's weight stay finite.
const MOST_NATS: f32 = 40.0;

/// What may end the free ground.
const HAZARDS: [Ending; 3] = [Ending::Rise, Ending::Obstacle, Ending::Drop];

/// Where the sum of the hazards' probabilities passes the risk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Metres from the mirror.
    pub end_m: f32,
    /// Probability of a hazard before it.
    pub before: f32,
}

/// Probabilities of hazards by place.
#[derive(Debug)]
pub struct Hazards<'a> {
    surfaces: &'a Surfaces,
    /// Probability of a thing beside the ground, by slot.
    beside: [f32; SLOTS],
    /// 1 + Σ w over everything across the way.
    total: f32,
}

impl<'a> Hazards<'a> {
    /// Of a sweep.
    pub fn new(surfaces: &'a Surfaces, above: &Above, lines: &Lines) -> Self {
        let mut beside = [0.0; SLOTS];
        above.things(lines, |b, nats| {
            // `as` saturates.
            let slot = (lines.x_m(lines.range_m(b)) / SLOT_M) as usize;
            if let Some(place) = beside.get_mut(slot) {
                let odds = weight(BESIDE_PER_M, nats);
                *place = math::max(*place, odds / (1.0 + odds));
            }
        });
        let mut hazards = Self {
            surfaces,
            beside,
            total: 1.0,
        };
        hazards.total += (0..SLOTS).map(|k| hazards.across(k)).sum::<f32>();
        hazards
    }

    /// Weight of a kind of hazard across the way in slot `k`.
    fn weight(&self, kind: Ending, k: usize) -> f32 {
        let x_m = (k as f32 + 0.5) * SLOT_M;
        match kind {
            Ending::Rise => weight(ACROSS_PER_M, self.surfaces.rise_at(x_m)),
            Ending::Drop => weight(ACROSS_PER_M, self.surfaces.drop_at(x_m)),
            Ending::Obstacle | Ending::None | Ending::Unknown => 0.0,
        }
    }

    /// Weight of a hazard across the way in slot `k`.
    fn across(&self, k: usize) -> f32 {
        self.weight(Ending::Rise, k) + self.weight(Ending::Drop, k)
    }

    /// Probability of a kind of hazard in slot `k`.
    fn probability(&self, kind: Ending, k: usize) -> f32 {
        match kind {
            Ending::Obstacle => self.beside.get(k).copied().unwrap_or(0.0),
            kind => self.weight(kind, k) / self.total,
        }
    }

    /// Where the risk is reached.
    pub fn reach(&self) -> Reach {
        let mut before = 0.0;
        for k in 0..SLOTS {
            let beside = self.probability(Ending::Obstacle, k);
            let here = self.across(k) / self.total + beside;
            if before + here > RISK {
                let end_m = k as f32 * SLOT_M;
                return Reach { end_m, before };
            }
            before += here;
        }
        Reach {
            end_m: SLOTS as f32 * SLOT_M,
            before,
        }
    }

    /// The free distance of this sweep, where the one before it ended at `last_m`, metres from where the mirror is now.
    pub fn free(&self, reach: Reach, last_m: Option<f32>) -> FreeGround {
        let end_m = last_m.map_or(reach.end_m, |last_m| math::min(last_m, reach.end_m));
        let free_m = math::max(end_m - MARGIN_M, 0.0);
        // `as` saturates.
        let near = ((free_m + NAMED_WITHIN_M) / SLOT_M) as usize;
        let of = |kind| {
            (0..near.min(SLOTS))
                .map(|k| self.probability(kind, k))
                .sum::<f32>()
        };
        let what = HAZARDS.map(|kind| (kind, of(kind)));
        let likeliest = what.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let named = likeliest.filter(|(_, p)| *p > NAMED);
        FreeGround {
            free_m,
            ending: match named {
                Some((kind, _)) => kind,
                None if end_m >= FARTHEST_M => Ending::None,
                None => Ending::Unknown,
            },
            confidence: 1.0 - reach.before,
        }
    }
}

/// Weight of a hazard in a slot.
#[inline(never)]
fn weight(per_m: f32, nats: f32) -> f32 {
    per_m * SLOT_M * math::exp(math::min(nats, MOST_NATS))
}
