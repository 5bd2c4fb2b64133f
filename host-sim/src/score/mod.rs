//! How good answers are, measured against the truth that simulated recordings carry.
//!
//! The rule: a reported step matches the nearest true step by horizontal distance, one to one,
//! nearest pairs first, within 10 cm. A scene is exact when every true step is matched and nothing
//! else is reported; a reported step that matches an uncounted one is ignored. `ok` and `degraded`
//! count as reported, `fault` as nothing. A scene without steps is a false stair when steps or a
//! direction are reported.
//!
//! An answer is wrong when, among what lies up to its horizon (plus 3 cm), a true step is missing,
//! something else is reported, or a matched step is off by more than its expanded uncertainty
//! U = max(3 cm, 3σ), at most 8 cm, in distance or height.
//! Nor may the ground end there (a brink, a hole) where no told drop covers it, within max(10 cm, 3σ), or a drop be told
//! where it covers none. True drops nearer than 1.6 m are counted, and how many of them are told with a probability
//! of at least one half; a drop that is told so and covers none is a false one.
//! A told drop's depth is held against that of the nearest true drop it covers, where that is known.
//! An answer without a horizon vouches for everything. Coverage is the share of true steps that lie
//! within the horizon or are reported.
//!
//! An answer's confidence is the probability that nothing is wrong up to its horizon, or over the first
//! metre if that is farther, and is held against just that. A `MAYBE` is right when a true step stands
//! within 10 cm of it, counted or out of sight; where it says that the ground may end, a step down or a
//! drop. Its height is not judged.

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
