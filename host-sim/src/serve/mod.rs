//! `live --foxglove` and `live --ros2`: reports of a scanner, or a recording, for Foxglove or ROS 2.
//!
//! | module | what it is |
//! |---|---|
//! | [`address`] | where to listen, on which interface and domain |
//! | [`streams`] | the topics: those of MCAP files, and on request the map as an image and the raw chirps |
//! | [`player`] | a recording at its true speed |
//! | [`frames`] | the frames of ROS 2's transforms |
//! | `server` | the crate `foxglove` behind [`streams::Service`]; with the feature `foxglove` only |
//! | `node` | the crate `ros2-client` behind it; with the feature `ros2` only |
//! | `other_build` | the program with such a feature, built and started by one without it |
//!
//! All but `server` and `node` is independent of the network, and in every build.

pub mod address;
pub mod frames;
#[cfg(feature = "ros2")]
pub mod node;
#[cfg(not(all(feature = "foxglove", feature = "ros2")))]
pub mod other_build;
pub mod player;
#[cfg(feature = "foxglove")]
pub mod server;
pub mod streams;

#[cfg(test)]
mod tests;
