//! The guard: a coarse sweep of the ground ahead, many times a second, and how far the ground is free.
//!
//! In: the weight of a first hazard at each place by one sweep ([`Ahead`]), and the chair's travel since the sweep
//! before. [`Filter`] is a recursive Bayes filter over the place of the first hazard: what earlier sweeps said moves
//! with the chair and fades, what this one says is multiplied to it. Out: free distance, what ends it, confidence.

mod filter;

pub use filter::{Filter, Free};

pub use crate::infer::ahead::{Ahead, HazardKind};

use crate::model::surfaces::{SLOT_M, SLOTS};
use crate::verdict::{Ending, FreeGround};

/// Free ground that ends so near the end of the range that a sweep sees, or farther, is ended by nothing, metres: the
/// margin that [`Filter`] keeps, and a slot.
const END_M: f32 = 0.15;

/// The filter's result as the verdict takes it.
pub fn ground(free: Free) -> FreeGround {
    let seen_m = SLOTS as f32 * SLOT_M - END_M;
    FreeGround {
        free_m: free.free_m,
        ending: match free.what {
            Some(HazardKind::Rise) => Ending::Rise,
            Some(HazardKind::Obstacle) => Ending::Obstacle,
            Some(HazardKind::Drop) => Ending::Drop,
            None if free.free_m >= seen_m => Ending::None,
            None => Ending::Unknown,
        },
        confidence: free.confidence,
    }
}
