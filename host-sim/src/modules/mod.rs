//! Models of the radar modules at the other end of their protocols, with their faults.

pub mod bgt60;
pub mod sirad;
