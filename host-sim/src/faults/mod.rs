//! What can go wrong with the instrument, put on recordings.
//!
//! Every fault is a change of a clean recording, drawn from a seed: of its samples (`converter`), of
//! which row got which chirp (`rows`), of what stands in the way (`world`), or of what the scanner
//! believes of its own mounting (`mounting`). `signal` takes a scan apart into what the scanner itself
//! reflects, what the scene does, and noise.

mod converter;
mod kinds;
mod mounting;
mod rows;
mod signal;
mod world;

pub use kinds::{ALL, Fault};

#[cfg(test)]
mod tests;
