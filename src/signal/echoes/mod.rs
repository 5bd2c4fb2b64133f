//! Echoes: point scatterers of a scan, as [`crate::signal::image`] finds them, and what follows from them for the
//! instrument.
//!
//! | module | from → to |
//! |---|---|
//! | `echo` | one point scatterer |
//! | `beam` | widths of strong echoes → whether the mirror's step is as configured |
//! | `place` | echoes from a chair that moves → as seen from the mirror at the last row |

mod beam;
mod echo;
mod place;

#[cfg(test)]
pub(crate) mod tests;

pub use beam::Lobes;
pub use echo::{Echo, Echoes, FoundEchoes, MAX_ECHOES};
pub(crate) use place::row_of;
pub use place::{MotionCompensation, forward};
