//! Functions that several tests share.

pub mod scanner;
pub mod shared;
pub mod shared_documents;

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

pub use shared::*;

/// Runs the program.
pub fn sim(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .args(args)
        .output()
        .unwrap()
}

/// Starts the program without a terminal; it runs until it is ended.
pub fn started(args: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .args(args)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Asserts that `replay` refuses the recording with a message that contains all of `words`.
pub fn refused(recording: &Path, words: &[&str]) {
    let out = sim(&["replay", recording.to_str().unwrap()]);
    let message = String::from_utf8(out.stderr).unwrap();
    assert_eq!(out.status.code(), Some(1), "{message}");
    assert!(
        out.stdout.is_empty(),
        "{}",
        String::from_utf8_lossy(&out.stdout)
    );
    assert_eq!(message.lines().count(), 1, "{message}");
    for word in words {
        assert!(message.contains(word), "{word:?} is not in {message:?}");
    }
}
