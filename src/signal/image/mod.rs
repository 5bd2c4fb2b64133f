//! Coherent image of a scan: rows brought to one phase and summed over the angle as complex numbers.
//!
//! Every chirp begins with another phase, which all of its echoes share, the mirror's own echo among them. With that
//! phase taken out of each row, what stands still keeps its phase from row to row, and the rows add up as complex
//! numbers. The image is the matched filter over the angle,
//!
//! ```text
//! y(j, b) = Σ_k h(θ_k - θ_j) X_k(b) e^(-iφ_k),    h = g / ‖g‖,    g(t) = exp(-t² / 2s²),    s = width / √(8 ln 2)
//! ```
//!
//! g is the beam's two-way pattern in voltage, φ_k the phase of the mirror's echo in row k. Behind the filter the lobe of
//! a point has the standard deviation s√2, so that angles θ_j a quarter of the beam's width apart (*nodes*) hold all
//! of it. A point gains Σg² over the power of one cell: 15 (11.8 dB) with a beam of 5° and rows of 0.25°. ‖h‖ = 1, so
//! that the image's noise has a cell's power.
//!
//! | module | from → to |
//! |---|---|
//! | `nodes` | beam, rows → angles of the nodes, and the filter |
//! | `reference` | spectrum of a chirp → its bins, brought to the mirror's phase |
//! | `coherent` | rows → image, in fixed point; its noise |
//! | `drift` | rows → phase that echoes turn while the chair moves |
//! | `response` | window → response of a point over the range |
//! | `walk` | travel → bins through which scatterers walk while the chair moves |
//! | `waiting` | local maxima that wait, the strongest first |
//! | `clean` | image → points, strongest first, by CLEAN |
//! | `memory` | the words in which the image is made |
//! | `points` | points → echoes with standard deviations |
//! | `surface` | image behind CLEAN, echoes → power at a place of a surface |

mod clean;
mod coherent;
mod drift;
mod memory;
mod nodes;
mod points;
mod reference;
mod response;
mod surface;
mod waiting;
mod walk;

#[cfg(test)]
pub(crate) mod tests;

pub use memory::{ImageMemory, WORDS};
pub use points::KeptImage;
pub use reference::CoherentRow;
pub use surface::{Cleaned, Look};
