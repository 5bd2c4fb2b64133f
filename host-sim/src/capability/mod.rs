//! The capability sheet: for each test body the probability of detection, the response time and the false alarms, with
//! bounds.
//!
//! A plan of cells goes in ([`plan`]): a test body ([`body`]) under one condition ([`condition`]), seen by so many
//! independent scenes. Each scene is scanned and swept by the scanner's own loop ([`measure`], [`standing`]), each answer is judged by a
//! rule ([`outcome`]), and the counts of a cell get their bounds ([`tally`], [`results`]). What is made of them is one document
//! ([`sheet`], [`figures`]), written as Markdown or as a page ([`document`]).
//!
//! It stands beside [`crate::score`] and [`crate::sweeps`], which measure answers on random scenes: here one quantity
//! changes at a time, so that a table says where the scanner stops to see a hazard.

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
