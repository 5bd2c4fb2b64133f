//! The posterior over staircases.

pub mod labels;
mod model;
mod moves;
mod places;
pub mod staircase;

pub use model::{LEAST_DB, Model, level_density, tailed};
pub use moves::{CELL_M, CELLS, Candidate, FIRST_END_M, Mass, assess, weight};
pub use places::Class;
pub use staircase::{Kind, Staircase};
