//! The guard: a coarse sweep of the ground ahead, many times a second, and how far the ground is free.
//!
//! In: the weight of a first hazard at each place by one sweep ([`Ahead`]), and the chair's travel since the sweep
//! before. [`Filter`] is a recursive Bayes filter over the place of the first hazard: what earlier sweeps said moves
//! with the chair and fades, what this one says is multiplied to it. Out: free distance, what ends it, confidence.

mod filter;

pub use filter::{Filter, Free};

pub use crate::infer::ahead::{Ahead, HazardKind};
