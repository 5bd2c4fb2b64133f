//! The posterior over staircases, computed by particles.
//!
//! | module | does |
//! |---|---|
//! | `staircase` | a hypothesis, and where it contradicts an answer |
//! | `feature`, `model`, `places` | how likely the echoes are under a hypothesis |
//! | `prior` | what stairs people build |
//! | `refine` | the Gaussian over a hypothesis's continuous part |
//! | `proposals` | what else may stand there |
//! | `cloud` | weighted particles, resampled, and what they say of an answer |

mod cloud;
mod feature;
mod model;
mod places;
mod prior;
mod proposals;
mod refine;
mod staircase;

#[cfg(test)]
mod tests;

pub use cloud::{CELL_M, CELLS, Cloud, FIRST_END_M, LEAST_DOUBT, PARTICLES, Told};
pub use feature::{Class, FeaturePlace, before};
pub use model::{
    BEHIND_M, LEAST_DB, LEAST_SEEN, MAX_SEEN, MOST_SEEN, Model, NEAR, Seen, level_density,
    logistic, tailed,
};
pub use proposals::{Base, Proposals, weight};
pub use refine::refine;
pub use staircase::{
    Edge, GroundKind, MAX_STEPS, RIGHT_M, SAME_M, Sigmas, Staircase, ToldStep, View,
};
