//! `live --foxglove`: what a scanner reports, or a recording, over Foxglove's WebSocket protocol.
//!
//! | module | what it is |
//! |---|---|
//! | [`address`] | where to listen |
//! | [`streams`] | the topics: those of MCAP files, and on request the map as an image and the raw chirps |
//! | [`player`] | a recording at its true speed |
//! | `server` | the crate `foxglove` behind [`streams::Outlet`]; with the feature `foxglove` only |
//! | `other_build` | the program with that feature, built and started by one without it |
//!
//! All but `server` is independent of the network, and in every build.

pub mod address;
#[cfg(not(feature = "foxglove"))]
pub mod other_build;
pub mod player;
#[cfg(feature = "foxglove")]
pub mod server;
pub mod streams;

#[cfg(test)]
mod tests;
