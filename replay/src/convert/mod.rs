//! Samples in other programs' formats, in memory: to recordings, and from a recording's answers to tables.
//!
//! | file | format |
//! |---|---|
//! | `chirps.rs` | inputs in memory, and their conversion to recordings |
//! | `npy.rs` | numpy's arrays, in and out |
//! | `sigmf.rs` | SigMF of other programs, in |
//! | `angles.rs` | tables of angles, in |
//! | `tables.rs` | CSV of steps, echoes and map, out |
//! | `samples.rs`, `keys.rs` | conversion of numbers to 16 bits; keys that an input lacks |
//! | `mirrored.rs` | warning where the samples are no I and Q in turn |
//! | `scans.rs` | the scanner's results of a recording, for the outputs |
//!
//! The outputs contain the same values as `replay --format json` and `inspect --format json`, taken
//! from the same objects. docs/user/formats.md is for users.

pub mod angles;
mod chirps;
pub mod keys;
pub mod mirrored;
pub mod npy;
pub mod samples;
pub mod scans;
pub mod sigmf;
pub mod tables;

use std::path::Path;

pub use chirps::{Chirps, suffix};

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
