//! What comes into the scanner and into the host program from outside, as bytes that nobody chose.
//!
//! A target is a plain function over bytes that panics when something does not hold. `fuzz_targets/` hands
//! them to libFuzzer; `tests/corpus.rs` replays `corpus/` and some thousand [`mutate`]d inputs of it with
//! every `cargo test`; `examples/mutate.rs` does so for as long as one likes. See the README beside it.

pub mod controller;
pub mod input;
pub mod mutate;
pub mod seeds;
pub mod targets;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

/// One way in.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name: that of its program and of its corpus.
    pub name: &'static str,
    /// Does with the bytes what the scanner would, and checks what must hold.
    pub run: fn(&[u8]),
    /// So many mutations are a second's work or less.
    pub quick: u32,
}

/// All of them.
pub const TARGETS: [Target; 11] = [
    target("radar_link", targets::radar_link::run, 2000),
    target("sirad", targets::sirad::run, 1000),
    target("bgt60", targets::bgt60::run, 1000),
    target("commands", targets::commands::run, 4000),
    target("sentences", targets::sentences::run, 4000),
    target("motion", targets::motion::run, 4000),
    target("recordings", targets::recordings::run, 2000),
    target("scenes", targets::scenes::run, 2000),
    target("scanner", targets::scanner::run, 300),
    target("pipeline", targets::pipeline::run, 100),
    target("update", targets::update::run, 300),
];

const fn target(name: &'static str, run: fn(&[u8]), quick: u32) -> Target {
    Target { name, run, quick }
}

/// The directory of a target's corpus.
pub fn corpus_of(target: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(target)
}

/// The inputs of a target's corpus, sorted by name.
///
/// # Errors
/// Names the directory or the file that cannot be read.
pub fn corpus(target: &str) -> Result<Vec<Vec<u8>>> {
    let dir = corpus_of(target);
    let entries = fs::read_dir(&dir).with_context(|| dir.display().to_string())?;
    let mut paths: Vec<PathBuf> = entries
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<_>>()?;
    paths.sort();
    let read = |path: &PathBuf| fs::read(path).with_context(|| path.display().to_string());
    paths.iter().map(read).collect()
}
