//! Runs Cargo for the chip or the browser, and shows elapsed and remaining time.

use std::io::{BufRead, BufReader, Read as _};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};

use crate::console::progress;

/// Runs `build`, a `cargo build` for `target`, and shows the finished packages relative to all dependencies of
/// `package`.
///
/// # Errors
/// The build fails; the message is Cargo's.
pub fn watched(mut build: Command, package: &str, target: &str) -> Result<()> {
    let total = packages(&build, package, target);
    let bar = progress(total.unwrap_or(1)).with_prefix(format!("building {package}"));
    let mut child = build
        // One line for each finished package; diagnostics stay text.
        .args(["--message-format", "json-render-diagnostics"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .with_context(|| format!("cargo build of {package}"))?;
    let stderr = child.stderr.take();
    let complaints = std::thread::spawn(move || {
        let mut text = String::new();
        if let Some(mut stderr) = stderr {
            // Reading continues after invalid UTF-8; otherwise Cargo would block on the pipe.
            let mut bytes = Vec::new();
            let _ = stderr.read_to_end(&mut bytes);
            text = String::from_utf8_lossy(&bytes).into_owned();
        }
        text
    });
    for line in child
        .stdout
        .take()
        .into_iter()
        .flat_map(|out| BufReader::new(out).lines())
    {
        let finished = line.is_ok_and(|line| line.contains("\"reason\":\"compiler-artifact\""));
        // The image itself is last; libraries with a build script are reported twice.
        if finished && bar.position() + 1 < bar.length().unwrap_or(0) {
            bar.inc(1);
        }
    }
    let status = child.wait()?;
    bar.finish_and_clear();
    let complaints = complaints.join().unwrap_or_default();
    ensure!(
        status.success(),
        "cargo build of {package}: {}",
        complaints.trim()
    );
    Ok(())
}

/// Returns the number of packages that `package` depends on, including itself; `None` if Cargo does not report it.
fn packages(build: &Command, package: &str, target: &str) -> Option<u64> {
    let mut tree = Command::new(build.get_program());
    tree.current_dir(build.get_current_dir()?);
    tree.args(["tree", "--package", package, "--target", target]);
    tree.args(["--edges", "normal,build", "--prefix", "none", "--no-dedupe"]);
    let output = tree
        .output()
        .ok()
        .filter(|output| output.status.success())?;
    let text = String::from_utf8(output.stdout).ok()?;
    let mut names: Vec<&str> = text.lines().collect();
    names.sort_unstable();
    names.dedup();
    u64::try_from(names.len()).ok()
}
