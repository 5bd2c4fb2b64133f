//! Other programs' files to recordings, and recordings to other programs' files.
//!
//! | file | format |
//! |---|---|
//! | `source.rs` | inputs on the disk, whatever their format |
//! | `chirps.rs` | inputs in memory, and the recordings that they become |
//! | `npy.rs` | numpy's arrays, in and out |
//! | `dca1000.rs` | captures of TI's DCA1000, in |
//! | `sigmf.rs` | SigMF of others, in |
//! | `angles.rs` | tables of angles, in |
//! | `tables.rs` | CSV of steps, echoes and map, out |
//! | `mcap.rs` | MCAP, out |
//! | `messages.rs`, `ros.rs` | topics and messages of a scan, in MCAP and live; ROS 2's definitions and encoding |
//! | `staircase.rs` | the answer with covariances, as a message of ROS 2 |
//! | `samples.rs`, `keys.rs` | numbers to 16 bits; what an input does not say of itself |
//! | `scans.rs` | what the scanner makes of a recording, for the outputs |
//!
//! What stands in the outputs is what `replay --format json` and `inspect --format json` print: taken from
//! the same objects, number for number. docs/formats.md is for users.

pub mod angles;
mod chirps;
#[cfg(feature = "program")]
pub mod dca1000;
pub mod keys;
#[cfg(feature = "program")]
pub mod mcap;
#[cfg(feature = "program")]
pub mod messages;
pub mod npy;
#[cfg(feature = "program")]
pub(crate) mod ros;
pub mod samples;
pub mod scans;
pub mod sigmf;
#[cfg(feature = "program")]
mod source;
#[cfg(feature = "program")]
mod staircase;
pub mod tables;

use std::path::Path;

pub use chirps::{Chirps, suffix};
#[cfg(feature = "program")]
pub use source::Source;

use crate::recording::{self, DATA_SUFFIX, META_SUFFIX};

/// The name of a recording written to `path`, or of any file: without directory and suffix.
pub fn name(path: &Path) -> String {
    match suffix(path) {
        META_SUFFIX | DATA_SUFFIX | "npy" | "bin" => recording::name_of(path),
        _ => path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
    }
}

#[cfg(all(test, feature = "program"))]
mod tests;
