//! The other ends of the radar modules' own protocols: what the real ones would say, and what they do wrong.

pub mod bgt60;
pub mod sirad;
