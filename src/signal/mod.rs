//! From the radar module to echoes: everything before a model of what may stand there.
//!
//! In: the bytes of a radar module, and the chair's motion during the scan ([`crate::drive::Drive`]). Out: chirps, the
//! polar map of logarithmic power with its CFAR mask, and point scatterers ([`echoes::Echo`]), each with range, angle,
//! strength, width and the standard deviations of its place. Nothing here knows floor or stairs.
//!
//! | module | from → to |
//! |---|---|
//! | [`radar`] | bytes of a radar module → chirps: modules and their protocols, behind one trait |
//! | [`range`] | chirp → DC removal → window → FFT → power → CA-CFAR → one row of the map |
//! | [`grid`] | rows → the polar map, and where its cells lie |
//! | [`echoes`] | map → echoes: point scatterers, placed below the cell size |

pub mod echoes;
pub mod grid;
pub mod radar;
pub mod range;
