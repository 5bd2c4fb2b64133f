//! Guard sweeps of random scenes: a kind and a seed in, a recording with its truth out
//! ([`scenes`]), and the score of a scanner's answers on its sweeps ([`score`]), also as a plot
//! ([`strip`]).
//!
//! This module stands beside [`crate::scene`], which simulates the chirps, and [`crate::score`],
//! which scores full scans: a sweep of some thirty rows has neither steps nor a horizon, only the
//! first hazard ([`hazards`]).

pub mod ground;
#[cfg(feature = "program")]
pub mod hazards;
#[cfg(feature = "program")]
pub mod scenes;
pub mod score;
pub mod strip;
pub mod truth;
