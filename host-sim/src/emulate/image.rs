//! Building the image.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

/// The workspace that this program was built from.
pub fn workspace() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_owned()
}

/// Builds the image as `cargo firmware` does and returns its path. `features` are for test builds,
/// which go to a directory of their own.
pub fn build(features: &[&str]) -> Result<PathBuf> {
    const TARGET: &str = "thumbv7em-none-eabihf";
    let root = workspace();
    let mut target = std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| root.join("target"), |dir| root.join(dir));
    if !features.is_empty() {
        target = target.join(features.join("-"));
    }
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .current_dir(&root)
        .args(["build", "--quiet", "--profile", "firmware"])
        .args(["--package", "stairscan", "--bin", "stairscan"])
        .args(["--target", TARGET, "--target-dir"])
        .arg(&target)
        .args(["--features", &features.join(",")])
        .output()
        .context("cargo build of the image")?;
    ensure!(
        output.status.success(),
        "cargo build of the image: {}",
        String::from_utf8_lossy(&output.stderr).trim()
    );
    Ok(target.join(TARGET).join("firmware").join("stairscan"))
}
