//! Fuzz targets: the inputs of the scanner and of the host program.
//!
//! A target is a function over bytes that panics if a check fails. `fuzz_targets/` runs them with
//! libFuzzer. `tests/corpus.rs` runs `corpus/` and some thousand [`mutate`]d inputs of it with every
//! `cargo test`; `examples/mutate.rs` does so without a limit. See the README in this folder.

pub mod controller;
pub mod input;
pub mod mutate;
pub mod seeds;
pub mod targets;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

/// A fuzz target.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Name of the target, its program and its corpus.
    pub name: &'static str,
    /// Processes the bytes as the scanner would, and checks the result.
    pub run: fn(&[u8]),
    /// Number of mutations that takes at most a second.
    pub quick: u32,
}

/// All targets.
pub const TARGETS: [Target; 12] = [
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
    target("files", targets::files::run, 300),
];

const fn target(name: &'static str, run: fn(&[u8]), quick: u32) -> Target {
    Target { name, run, quick }
}

/// Returns the directory of a target's corpus.
pub fn corpus_of(target: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(target)
}

/// Returns the inputs of a target's corpus, sorted by name.
///
/// # Errors
/// The directory or a file cannot be read; the message names it.
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
