//! Guard sweeps of random scenes: a kind and a seed in, a recording with its truth out ([`scenes`]), and the score of a
//! scanner's words on its sweeps ([`score`]), also as a picture ([`strip`]).
//!
//! It stands beside [`crate::scene`], which makes the chirps, and [`crate::score`], which judges full scans: a sweep of
//! some thirty rows has neither steps nor a horizon, only the first hazard ([`hazards`]).

pub mod ground;
#[cfg(feature = "program")]
pub mod hazards;
#[cfg(feature = "program")]
pub mod scenes;
pub mod score;
pub mod strip;
pub mod truth;
