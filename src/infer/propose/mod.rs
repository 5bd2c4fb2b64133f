//! The search: flights of stairs that explain the echoes, the best one of each number of steps.
//!
//! | module | content |
//! |---|---|
//! | `scene` | echoes with position, credibility and standard deviations, sorted and grouped into columns |
//! | `roles` | classification of an echo, given a flight going up |
//! | `null` | the score of level ground |
//! | `stairs` | a flight going up: its faces, shape and score |
//! | `ascending` | score of a flight going up |
//! | `descending` | proposal of stairs going down from the levels of the echoes |
//! | `search` | the best flights going up, face by face |
//!
//! Going up, the search's scores are tuned by hand and only select hypotheses: the posterior decides.

pub mod ascending;
pub mod descending;
pub mod null;
pub mod roles;
pub mod scene;
pub mod search;
pub mod stairs;
