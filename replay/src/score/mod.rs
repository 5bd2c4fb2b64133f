//! Scores answers against the ground truth of simulated recordings.
//!
//! Matching: a reported step matches the nearest true step by horizontal distance, one to one, nearest pairs first,
//! within 10 cm. A scene is exact when every true step is matched and nothing else is reported. A reported step that
//! matches an uncounted one is ignored. `ok` and `degraded` count as reported, `fault` as nothing. A scene without
//! steps is a false stair when steps or a direction are reported.
//!
//! An answer is wrong if, up to its horizon (plus 3 cm), a true step is missing, another one is reported, or a
//! matched step is off by more than its expanded uncertainty U = max(3 cm, 3σ), at most 8 cm, in distance or height.
//! It is also wrong if the ground ends there (an edge, a hole) and no reported drop covers it, within max(10 cm, 3σ),
//! or if a reported drop covers none.
//!
//! True drops nearer than 1.6 m are counted, with the share reported with a probability of at least one half. A drop
//! reported with this probability that covers none is a false one. The depth of a reported drop is compared with that
//! of the nearest true drop it covers, if known.
//!
//! An answer without a horizon is checked over all distances. Coverage is the share of true steps that lie within the
//! horizon or are reported.
//!
//! The confidence of an answer is the probability that nothing is wrong up to its horizon, or over the first metre if
//! that is farther. It is compared with the outcome over this distance. A `MAYBE` is correct when a true step is
//! within 10 cm of it, counted or out of sight; if it reports a possible end of the ground, a step down or a drop.
//! Its height is not checked.

mod compare;
mod judge;
mod reliability;
mod set;
mod share;
mod text;

pub use compare::{Change, Comparison};
pub use judge::{
    DEPTH_M, LIMIT_M, MATCH_M, Match, NEAR_DROP_M, SceneScore, false_stairs, maybes, nearest,
    scene, wrong_up_to,
};
pub use reliability::{Bin, Prediction, Reliability};
pub use set::{AnswerType, SetScore, Spread, by_set, quantile};
pub use share::{Share, at_most, upper_bound};
pub use text::{confusions, confusions_json, drops, median_table, table};

#[cfg(test)]
mod tests;
