//! `live --foxglove` and `live --ros2`: publishes the reports of a scanner, or a recording, for Foxglove or
//! ROS 2.
//!
//! | module | what it is |
//! |---|---|
//! | [`address`] | the address, interface and domain to listen on |
//! | [`streams`] | the topics: those of MCAP files, and on request the map as an image and the raw chirps |
//! | [`player`] | plays a recording at its true speed |
//! | [`frames`] | the frames of ROS 2's transforms |
//! | `server` | the crate `foxglove` as a [`streams::Service`]; with the feature `foxglove` only |
//! | `node` | the crate `ros2-client` as a [`streams::Service`]; with the feature `ros2` only |
//! | `other_build` | builds and starts the program with such a feature from one without it |
//!
//! All modules except `server` and `node` are independent of the network and part of every build.

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
