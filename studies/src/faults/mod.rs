//! Injects faults of the instrument into recordings.
//!
//! Every fault changes a clean recording, with random numbers from a seed: its samples (`converter`),
//! the assignment of chirps to rows (`rows`), the phase reference (`reference`), the scene (`world`), or the configured
//! mounting (`mounting`). `signal` separates a scan into the scanner's own reflections, the scene's echoes, and
//! noise.

mod converter;
mod kinds;
mod mounting;
mod reference;
mod rows;
mod signal;
mod world;

pub use kinds::{ALL, Fault};

#[cfg(test)]
mod tests;
