//! Tools that are needed besides the host's own Rust: the compiler's targets for the chip and for browsers, and the
//! emulator.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Rust target triple of the chip.
pub const TARGET: &str = "thumbv7em-none-eabihf";
/// Rust target triple of a browser.
pub const WEB: &str = "wasm32-unknown-unknown";
/// Name of the emulator's program.
pub const EMULATOR: &str = "qemu-system-arm";

/// A tool that may be missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tool {
    /// Rust's standard library for the chip.
    Target,
    /// Rust's standard library for WebAssembly.
    Web,
    /// QEMU's system emulator for ARM.
    Emulator,
}

impl Tool {
    /// Whether the tool is installed.
    pub fn available(self) -> bool {
        match self {
            Tool::Target => target_libdir(TARGET).is_some_and(|dir| holds_core(&dir)),
            Tool::Web => target_libdir(WEB).is_some_and(|dir| holds_core(&dir)),
            Tool::Emulator => succeeds(Command::new(EMULATOR).arg("--version")),
        }
    }

    /// Returns the text that the tool is missing, and how to install it.
    pub fn how_to_get(self) -> &'static str {
        match self {
            Tool::Target => {
                "no Rust target thumbv7em-none-eabihf: `rustup target add thumbv7em-none-eabihf`, \
                 or `./check`"
            }
            Tool::Web => {
                "no Rust target wasm32-unknown-unknown: `rustup target add wasm32-unknown-unknown`"
            }
            Tool::Emulator => {
                "no qemu-system-arm: `sudo apt-get install qemu-system-arm` or `./check` (Debian, \
                 Ubuntu), `brew install qemu` (macOS)"
            }
        }
    }

    /// Checks that the tool is installed.
    ///
    /// # Errors
    /// It is missing; the message explains how to install it.
    pub fn need(self) -> anyhow::Result<()> {
        anyhow::ensure!(self.available(), "{}", self.how_to_get());
        Ok(())
    }
}

fn succeeds(command: &mut Command) -> bool {
    let quiet = command.stdout(Stdio::null()).stderr(Stdio::null());
    quiet.status().is_ok_and(|status| status.success())
}

/// Returns the directory of a target's standard library, as the compiler of this workspace reports it. The compiler
/// reports it even if it does not exist.
fn target_libdir(target: &str) -> Option<PathBuf> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["--print", "target-libdir", "--target", target])
        .output()
        .ok()
        .filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().into())
}

fn holds_core(dir: &Path) -> bool {
    let entries = std::fs::read_dir(dir).into_iter().flatten().flatten();
    let mut names = entries.map(|entry| entry.file_name());
    names.any(|name| name.to_string_lossy().starts_with("libcore-"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_is_there_when_its_library_is() {
        let root = std::env::temp_dir().join(format!("stairscan-target-{}", std::process::id()));
        assert!(!holds_core(&root));
        std::fs::create_dir_all(&root).unwrap();
        assert!(!holds_core(&root));
        std::fs::write(root.join("libcore-0123456789abcdef.rlib"), []).unwrap();
        assert!(holds_core(&root));
        std::fs::remove_dir_all(&root).unwrap();
    }
}
