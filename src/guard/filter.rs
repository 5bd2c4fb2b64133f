//! The first hazard's place, from sweep to sweep.

use super::{Ahead, HazardKind};
use crate::math;
use crate::model::surfaces::{SLOT_M, SLOTS};

/// Kinds of hazards.
const KINDS: usize = HazardKind::ALL.len();
/// What a sweep said counts so much in the next one.
const KEPT: f32 = 0.6;
/// One sweep says at most so many nats for or against a place.
const MOST_NATS: f32 = 12.0;
/// Prior probability that the first hazard stands in a slot, by kind.
const PRIOR: [f32; KINDS] = [0.3 * SLOT_M, 0.1 * SLOT_M, 0.25 * SLOT_M];
/// The free ground ends where a hazard nearer has this probability …
const RISK: f32 = 0.002;
/// … less this, metres.
const MARGIN_M: f32 = 0.08;
/// A kind is named from this probability on.
const NAMED: f32 = 0.5;
/// Hazards so far behind the free distance end it, metres.
const ENDS_M: f32 = 0.35;

/// How far the ground is free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// Up to where, metres from the mirror.
    pub free_m: f32,
    /// What ends it, if that is known.
    pub what: Option<HazardKind>,
    /// Probability that no hazard stands nearer.
    pub confidence: f32,
}

/// Log-likelihood ratio of a hazard by kind and place against free ground, over all sweeps.
#[derive(Clone, Debug)]
pub struct Filter {
    nats: [[f32; SLOTS]; KINDS],
    /// Free distance one sweep ago, metres from where the mirror is now; none before the first.
    last_m: Option<f32>,
}

impl Default for Filter {
    fn default() -> Self {
        Self::new()
    }
}

impl Filter {
    /// Before the first sweep.
    pub const fn new() -> Self {
        Self {
            nats: [[0.0; SLOTS]; KINDS],
            last_m: None,
        }
    }

    /// Takes in a sweep; `moved_m` is the travel since the one before, if it is known.
    pub fn take(&mut self, ahead: &Ahead, moved_m: Option<f32>) -> Free {
        self.carry(moved_m);
        let free = math::max(ahead.free, f32::MIN_POSITIVE);
        for ((nats, weights), prior) in self.nats.iter_mut().zip(&ahead.hazards).zip(PRIOR) {
            for (nats, weight) in nats.iter_mut().zip(weights) {
                let ratio = math::max(*weight, f32::MIN_POSITIVE) / free / prior;
                let said = math::ln(math::max(ratio, f32::MIN_POSITIVE));
                *nats += said.clamp(-MOST_NATS, MOST_NATS);
            }
        }
        let now = self.read();
        let m = self.last_m.map_or(now.free_m, |last| math::min(last, now.free_m));
        self.last_m = Some(now.free_m);
        Free { free_m: math::max(m - MARGIN_M, 0.0), ..now }
    }

    /// Moves what earlier sweeps said with the chair, and lets it fade.
    fn carry(&mut self, moved_m: Option<f32>) {
        let kept = if moved_m.is_some() { KEPT } else { 0.5 * KEPT };
        let moved_m = moved_m.unwrap_or(0.0);
        for nats in &mut self.nats {
            let old = *nats;
            for (k, nats) in nats.iter_mut().enumerate() {
                let place = k as f32 + moved_m / SLOT_M;
                let below = math::floor(place);
                let share = place - below;
                let at = |k: f32| {
                    let inside = k >= 0.0 && k < SLOTS as f32;
                    let nats = old.get(k as usize).copied().unwrap_or(0.0);
                    if inside { nats } else { 0.0 }
                };
                *nats = kept * ((1.0 - share) * at(below) + share * at(below + 1.0));
            }
        }
        self.last_m = self.last_m.map(|last| last - moved_m);
    }

    /// How far the ground is free by now.
    fn read(&self) -> Free {
        let slot = |kind: usize, k: usize| {
            let nats = self.nats.get(kind).and_then(|n| n.get(k)).copied().unwrap_or(0.0);
            PRIOR.get(kind).copied().unwrap_or(0.0) * math::exp(math::min(nats, 40.0))
        };
        let sum = |k: usize| (0..KINDS).map(|kind| slot(kind, k)).sum::<f32>();
        let total: f32 = 1.0 + (0..SLOTS).map(sum).sum::<f32>();
        let (mut so_far, mut end) = (0.0, SLOTS);
        let mut before = 0.0;
        for k in 0..SLOTS {
            before = so_far;
            so_far += sum(k) / total;
            if so_far > RISK {
                end = k;
                break;
            }
        }
        let free_m = end as f32 * SLOT_M;
        let near = ((free_m + ENDS_M) / SLOT_M) as usize;
        let of = |kind: usize| (0..near.min(SLOTS)).map(|k| slot(kind, k)).sum::<f32>() / total;
        let mut what = None;
        for kind in HazardKind::ALL {
            if of(kind as usize) > NAMED {
                what = Some(kind);
            }
        }
        Free { free_m, what, confidence: 1.0 - before }
    }
}
