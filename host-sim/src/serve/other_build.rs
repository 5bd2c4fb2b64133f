//! From a program without the server to one with it: Cargo builds it, and it takes this one's place.

use std::convert::Infallible;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::emulate::image::workspace;

/// The feature with the server, and the directory below the target directory for programs with it.
const FEATURE: &str = "foxglove";

/// Builds this program with the feature, where that has not been done yet, and starts it with the same arguments in
/// place of this one.
///
/// # Errors
/// Cargo's failure; where there is no source, the command to type.
pub fn start() -> Result<Infallible> {
    let root = workspace();
    ensure!(
        root.join("host-sim/Cargo.toml").exists(),
        "--foxglove: this program was built without it. In the sources: cargo run --release --package host-sim \
         --features {FEATURE} --bin host-sim -- live ... --foxglove"
    );
    let program = build(root)?;
    let error = Command::new(&program)
        .args(std::env::args_os().skip(1))
        .exec();
    Err(error).with_context(|| format!("{}", program.display()))
}

/// Builds into a directory of its own, so that the program under `release/` stays the one without the feature.
fn build(root: PathBuf) -> Result<PathBuf> {
    let build_dir = std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| root.join("target"), |dir| root.join(dir));
    let target = build_dir.join(FEATURE);
    let program = target.join("release/host-sim");
    let built = program.exists();
    if !built {
        eprintln!(
            "--foxglove: building the program with the feature {FEATURE}, once (a minute or more)"
        );
    }
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .current_dir(&root)
        // What both builds rest on is built once.
        .env("CARGO_BUILD_BUILD_DIR", &build_dir)
        .args(["build", "--locked", "--release"])
        // Of the first build, which takes long, one sees how far it is.
        .args(built.then_some("--quiet"))
        .args(["--package", "host-sim", "--bin", "host-sim"])
        .args(["--features", FEATURE, "--target-dir"])
        .arg(&target)
        .status()
        .context("--foxglove: cargo")?;
    ensure!(
        status.success(),
        "--foxglove: cargo build --features {FEATURE} failed; Cargo's message stands above"
    );
    Ok(program)
}
