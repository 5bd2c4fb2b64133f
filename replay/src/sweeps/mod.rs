//! Truth of guard sweeps ([`truth`]), the score of a scanner's answers on them ([`score`]), also as a plot ([`strip`]).
//!
//! This module stands beside [`crate::score`], which scores full scans: a sweep of some thirty rows has neither steps
//! nor a horizon, only the first hazard.

pub mod ground;
pub mod score;
pub mod strip;
pub mod truth;
