//! Conversion of other programs' files to recordings, and of recordings to other programs' files.
//!
//! | file | format |
//! |---|---|
//! | `source.rs` | inputs on the disk, of any format |
//! | `chirps.rs` | inputs in memory, and their conversion to recordings |
//! | `npy.rs` | numpy's arrays, in and out |
//! | `dca1000.rs` | captures of TI's DCA1000, in |
//! | `sigmf.rs` | SigMF of other programs, in |
//! | `angles.rs` | tables of angles, in |
//! | `tables.rs` | CSV of steps, echoes and map, out |
//! | `mcap.rs` | MCAP, out |
//! | `messages.rs`, `ros.rs` | topics and messages of a scan, in MCAP and live; ROS 2's definitions and encoding |
//! | `staircase.rs` | the answer with covariances, as a message of ROS 2 |
//! | `samples.rs`, `keys.rs` | conversion of numbers to 16 bits; keys that an input lacks |
//! | `scans.rs` | the scanner's results of a recording, for the outputs |
//!
//! The outputs contain the same values as `replay --format json` and `inspect --format json`, taken
//! from the same objects. docs/user/formats.md is for users.

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

/// Returns the name of a file without directory and, for recordings, arrays and captures, without its suffix.
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
