//! What several tests do with the program.

use std::process::{Command, Output};

/// Runs the program.
pub fn sim(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .args(args)
        .output()
        .unwrap()
}
