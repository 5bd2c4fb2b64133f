//! Complex numbers packed into one 32-bit word, and the arithmetic on them.
//!
//! The Cortex-M4's DSP extension works on the two 16-bit halves of a word at a time. Each function of
//! [`Arithmetic`] corresponds to one of its instructions: [`Portable`] defines it in plain Rust and runs
//! anywhere, `Dsp` uses the instruction. Both give the same bits.

mod arithmetic;
#[cfg(target_arch = "arm")]
mod dsp;
mod portable;

pub use arithmetic::{Arithmetic, Bin, Packed, magnitude_bits, quarters, turn};
pub(super) use arithmetic::{halves, last_by, stage_by};
#[cfg(target_arch = "arm")]
pub use dsp::Dsp;
pub use portable::Portable;

/// Arithmetic of the scanner's processor: DSP instructions.
#[cfg(target_arch = "arm")]
pub type Native = Dsp;
/// Arithmetic of other targets: plain Rust.
#[cfg(not(target_arch = "arm"))]
pub type Native = Portable;
