//! Guard sweeps of random scenes: a kind and a seed in, a recording with its truth out ([`scenes`]).
//!
//! This module stands beside [`crate::scene`], which simulates the chirps, and [`stairscan_replay::sweeps`], which
//! scores the answers.

pub mod hazards;
pub mod scenes;

pub use stairscan_replay::sweeps::*;
