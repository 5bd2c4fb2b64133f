//! Library of `cargo study`: fits of the estimator's numbers, its accuracy on random scenes, faults of the instrument,
//! budgets of the image, and the documents made from their results.

// `emit` and `note!` end or go on where stdout or stderr is closed; the macros would panic.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

pub mod accuracy;
pub mod capability;
pub mod coherent;
pub mod commands;
pub mod drives;
pub mod faults;
pub mod fit;
pub mod hardware;
pub mod harness;
pub mod help;
pub mod images;
pub mod instrument;
pub mod sbom;
pub mod shift;
pub mod soak;
