//! Hardware of a scanner for docs/user/build.md: parts, power, wiring and the optics' drawing.
//!
//! | module | content |
//! |---|---|
//! | [`table`] | the table of parts, loads and wires (`table.toml`) |
//! | [`tables`] | parts with their cost and the power budget, as Markdown |
//! | [`wiring`] | the wiring diagram |
//! | [`optics`] | lens and mirror with their dimensions, from beam and wavelength |
//! | [`sheet`] | lines, text and dimensions of a drawing |

pub mod optics;
pub mod sheet;
pub mod table;
pub mod tables;
pub mod wiring;

#[cfg(test)]
mod tests;
