//! The controller's C parser (`controller/`) held against the scanner's own: the same verdict and the same
//! fields for every line, the same line written again, and the words of its header from the tables here.
//!
//! | module | does |
//! |---|---|
//! | [`tables`] | what the C header says of reasons and keys |
//! | [`oracle`] | what the Rust parsers make of a line, as text |
//! | [`vectors`] | lines worth keeping, with that text: `controller/vectors.tsv` |
//! | [`lines`] | mutations of these lines |
//! | [`page`] | what of `docs/controller.md` a C example prints |
//! | [`program`] | compiles `controller/`, feeds it lines through a pipe, compares |

pub mod lines;
pub mod oracle;
pub mod page;
pub mod program;
pub mod tables;
pub mod vectors;

use std::path::{Path, PathBuf};

/// Which of the two ways a line goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Way {
    /// From the scanner.
    Report,
    /// To the scanner.
    Command,
}

impl Way {
    /// The letter that stands for it in vectors and on the pipe.
    pub const fn letter(self) -> char {
        match self {
            Way::Report => 'R',
            Way::Command => 'C',
        }
    }
}

/// The directory of the C sources.
pub fn directory() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../controller")
}
