//! The posterior over staircases, computed by particles.
//!
//! | module | does |
//! |---|---|
//! | `staircase` | a hypothesis, and where it contradicts an answer |
//! | `feature`, `model`, `places` | how likely the echoes are under a hypothesis |
//! | `prior` | what stairs people build |
//! | `readings` | what each riser's own echoes say of its place and height |
//! | [`gauss`] | the Gaussian over the levels of a flight, any one riser or tread odd |
//! | `refine` | a hypothesis moved to where the echoes put it |
//! | `proposals` | what else may stand there |
//! | `cloud` | weighted particles, resampled, and what they say of an answer |

mod cloud;
mod feature;
pub mod gauss;
mod model;
mod places;
mod prior;
mod proposals;
mod readings;
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
pub use readings::{Face, Readings};
pub use refine::refine;
pub use staircase::{
    Edge, GroundKind, MAX_STEPS, RIGHT_M, SAME_M, Sigmas, Staircase, ToldStep, View,
};
