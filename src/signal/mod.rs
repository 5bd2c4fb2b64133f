//! Signal processing from the radar module's bytes to echoes, without a model of the scene.
//!
//! In: the bytes of a radar module, and the chair's motion during the scan ([`crate::drive::Drive`]). Out:
//! chirps, the polar map of logarithmic power with its CFAR mask, and point scatterers ([`echoes::Echo`]), each
//! with range, angle, level, width and the standard deviations of its position. No module here uses a model of
//! ground or stairs.
//!
//! | module | from → to |
//! |---|---|
//! | [`radar`] | bytes of a radar module → chirps: modules and their protocols, behind one trait |
//! | [`range`] | chirp → DC removal → window → FFT → power → CA-CFAR → one row of the map |
//! | [`grid`] | rows → the polar map, and the position of its cells |
//! | [`image`] | spectra of rows → the coherent image, and its points by CLEAN |
//! | [`echoes`] | map → echoes: point scatterers, with positions finer than a cell |

pub mod echoes;
pub mod grid;
pub mod image;
pub mod radar;
pub mod range;
