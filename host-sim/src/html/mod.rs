//! Pages beyond that of one replay ([`stairscan_replay::html`]).
//!
//! | file | contents |
//! |---|---|
//! | `compare.html`, `compare.js` | the body with two views side by side, and their differences |
//! | `twin.rs` | the page with the scanner itself, from `../../web/page/` |

pub mod compare;
mod differences;
pub mod twin;

pub use stairscan_replay::html::*;

#[cfg(test)]
mod tests;
