//! The posterior over staircases.

mod model;
mod moves;
pub mod staircase;

pub use model::Model;
pub use moves::{Mass, CELLS, CELL_M, FIRST_END_M, assess, Candidate, weight};
pub use staircase::{Kind, Staircase};
