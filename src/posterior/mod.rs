//! The posterior over staircases, computed by particles.
//!
//! | module | does |
//! |---|---|
//! | `staircase` | a hypothesis, and where it contradicts an answer |
//! | `model` | how likely the echoes are under a hypothesis |
//! | `prior` | what stairs people build |
//! | `refine` | the Gaussian over a hypothesis's continuous part |
//! | `proposals` | what else may stand there |
//! | `cloud` | weighted particles, resampled, and what they say of an answer |

mod cloud;
mod model;
mod prior;
mod proposals;
mod refine;
mod staircase;

pub use cloud::{CELL_M, CELLS, Cloud, FIRST_END_M, PARTICLES, Told};
pub use model::Model;
pub use proposals::{Base, Proposals};
pub use refine::refine;
pub use staircase::{Edge, Kind, MAX_STEPS, Sigmas, Staircase, View};
