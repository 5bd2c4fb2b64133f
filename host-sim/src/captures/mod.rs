//! Readers of chirps that other programs recorded from radar modules.

pub mod mat;
pub mod sirad;
