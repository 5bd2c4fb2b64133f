//! Functions that several tests share.

#[path = "../../../host-sim/tests/suite/common/shared.rs"]
pub mod shared;
#[path = "../../../host-sim/tests/suite/common/shared_documents.rs"]
pub mod shared_documents;

use std::process::{Command, Output};

pub use shared::*;

/// Runs the program.
pub fn study(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_study"))
        .args(args)
        .output()
        .unwrap()
}
