//! The search: flights of stairs that explain the echoes, the best of each number of steps.
//!
//! | module | does |
//! |---|---|
//! | `scene` | echoes placed, weighed, sorted, gathered into columns |
//! | `roles` | what an echo is if a flight goes up there: the one classifier |
//! | `null` | what else may be there: level ground, ramps |
//! | `stairs` | what a kind of stairs is to the search |
//! | `ascending`, `descending` | how well a flight of each kind explains the echoes |
//! | `search` | the best flights, face by face |
//!
//! Its scores are set by hand and only say what is worth weighing; going up the posterior decides.

pub mod ascending;
pub mod descending;
pub mod null;
pub mod roles;
pub mod scene;
pub mod search;
pub mod stairs;
