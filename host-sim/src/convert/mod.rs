//! Conversion of other programs' files to recordings, and of recordings to other programs' files, beyond those in
//! memory ([`stairscan_replay::convert`]).
//!
//! | file | format |
//! |---|---|
//! | `source.rs` | inputs on the disk, of any format |
//! | `dca1000.rs` | captures of TI's DCA1000, in |
//! | `mcap.rs` | MCAP, out |
//! | `messages.rs`, `ros.rs` | topics and messages of a scan, in MCAP and live; ROS 2's definitions and encoding |
//! | `staircase.rs` | the answer with covariances, as a message of ROS 2 |

pub mod dca1000;
pub mod mcap;
pub mod messages;
pub(crate) mod ros;
mod source;
mod staircase;

pub use source::Source;
pub use stairscan_replay::convert::*;

#[cfg(test)]
mod tests;
