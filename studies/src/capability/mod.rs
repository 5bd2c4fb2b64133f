//! The capability sheet: the probability of detection, the response time and the false alarms of
//! each test body, with confidence bounds.
//!
//! The input is a plan of cells ([`plan`]). A cell is a test body ([`body`]) under one condition
//! ([`condition`]) in a number of independent scenes. Each scene is scanned and swept by the
//! scanner's own loop ([`measure`], [`standing`]), each answer is classified by a rule
//! ([`outcome`]), and the counts of a cell get their bounds ([`tally`], [`results`]). The output is
//! one document ([`sheet`], [`figures`]), as Markdown or as an HTML page ([`document`]).
//!
//! [`host_sim::score`] and [`host_sim::sweeps`] measure answers on random scenes. Here one quantity
//! changes at a time, so that a table shows at which value detection fails.

pub mod body;
pub mod condition;
pub mod document;
pub mod figures;
pub mod measure;
pub mod outcome;
pub mod plan;
pub mod results;
pub mod sheet;
pub mod standing;
pub mod tally;
