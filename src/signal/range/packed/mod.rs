//! Complex numbers packed into one word, and the arithmetic on them.
//!
//! The Cortex-M4's DSP extension works on two 16-bit halves of a word at a time. Each function of
//! [`Arithmetic`] stands for one of its instructions; [`Portable`] spells out what it means and
//! runs anywhere, `Dsp` is the instruction itself. Both give the same bits.

mod arithmetic;
#[cfg(target_arch = "arm")]
mod dsp;
mod portable;

pub use arithmetic::{Arithmetic, Bin, Packed, magnitude_bits, quarters};
pub(super) use arithmetic::{halves, last_by, stage_by};
#[cfg(target_arch = "arm")]
pub use dsp::Dsp;
pub use portable::Portable;

/// What this target computes with.
#[cfg(target_arch = "arm")]
pub type Native = Dsp;
/// What this target computes with.
#[cfg(not(target_arch = "arm"))]
pub type Native = Portable;
