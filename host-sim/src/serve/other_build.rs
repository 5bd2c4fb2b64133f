//! Replaces the running program, built without a feature, by one with it, which Cargo builds.
//!
//! A feature has the name of the flag that needs it, and a directory of that name below the target
//! directory.

use std::convert::Infallible;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::emulate::image::workspace;

/// Builds this program with the feature if necessary, and executes it with the same arguments in place of this one.
///
/// # Errors
/// Cargo's failure; without the source, the command to enter.
pub fn start(feature: &str) -> Result<Infallible> {
    let root = workspace();
    ensure!(
        root.join("host-sim/Cargo.toml").exists(),
        "--{feature}: this program was built without it. In the sources: cargo run --release --package host-sim \
         --features {feature} --bin host-sim -- live ... --{feature}"
    );
    let program = build(root, feature)?;
    let error = Command::new(&program)
        .args(std::env::args_os().skip(1))
        .exec();
    Err(error).with_context(|| format!("{}", program.display()))
}

/// Builds the program with the feature and returns its path. The build has a directory of its own,
/// so that the program under `release/` stays the one without the feature.
fn build(root: PathBuf, feature: &str) -> Result<PathBuf> {
    let build_dir = std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| root.join("target"), |dir| root.join(dir));
    let target = build_dir.join(feature);
    let program = target.join("release/host-sim");
    let built = program.exists();
    if !built {
        crate::note!(
            "--{feature}: building the program with the feature {feature}, once (two to ten minutes)"
        );
    }
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .current_dir(&root)
        // Dependencies of both builds are built once.
        .env("CARGO_BUILD_BUILD_DIR", &build_dir)
        .args(["build", "--locked", "--release"])
        // The first build takes long: it shows its progress.
        .args(built.then_some("--quiet"))
        .args(["--package", "host-sim", "--bin", "host-sim"])
        .args(["--features", feature, "--target-dir"])
        .arg(&target)
        .status()
        .with_context(|| format!("--{feature}: cargo"))?;
    ensure!(
        status.success(),
        "--{feature}: cargo build --features {feature} failed; Cargo's message stands above"
    );
    Ok(program)
}
