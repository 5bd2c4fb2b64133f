//! Compares the controller's C parser (`controller/`) with the scanner's own: the same verdict and fields
//! for every line, the same line when written again, and the texts of its header from the tables here.
//!
//! | module | does |
//! |---|---|
//! | [`tables`] | the tables of reasons and keys in the C header |
//! | [`oracle`] | the Rust parsers' result for a line, as text |
//! | [`vectors`] | selected lines with their results: `controller/vectors.tsv` |
//! | [`lines`] | mutations of these lines |
//! | [`page`] | the table of `docs/user/controller.md` that a C example prints |
//! | [`program`] | compiles `controller/`, sends it lines through a pipe, compares |

pub mod lines;
pub mod oracle;
pub mod page;
pub mod program;
pub mod tables;
pub mod vectors;

use std::path::{Path, PathBuf};

/// Direction of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Way {
    /// From the scanner.
    Report,
    /// To the scanner.
    Command,
}

impl Way {
    /// Returns its letter in vectors and on the pipe.
    pub const fn letter(self) -> char {
        match self {
            Way::Report => 'R',
            Way::Command => 'C',
        }
    }
}

/// Returns the directory of the C sources.
pub fn directory() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../controller")
}
