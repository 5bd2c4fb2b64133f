//! Builds images for the emulator and runs them there.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};

/// The chip's target.
const TARGET: &str = "thumbv7em-none-eabihf";

/// The directory of the workspace, where this program was built.
pub fn workspace() -> &'static Path {
    let host_sim = Path::new(env!("CARGO_MANIFEST_DIR"));
    host_sim.parent().unwrap_or(host_sim)
}

/// Builds a program for the chip with the firmware's profile; returns its ELF file.
pub fn build(package: &str, bin: &str) -> Result<PathBuf> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .current_dir(workspace())
        .args([
            "build",
            "--quiet",
            "--profile",
            "firmware",
            "--target",
            TARGET,
        ])
        .args(["--package", package, "--bin", bin])
        .stdout(Stdio::null())
        .status()
        .context("cargo build")?;
    ensure!(status.success(), "cargo build of {package} {bin}: {status}");
    let target = std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| workspace().join("target"), PathBuf::from);
    Ok(target.join(TARGET).join("firmware").join(bin))
}

/// Runs an image that ends by itself; returns what it printed through semihosting.
///
/// Time in the emulator is the number of instructions, one a nanosecond (`-icount shift=0`).
pub fn run(elf: &Path, directory: &Path, limit: Duration) -> Result<String> {
    let log = directory.join("output");
    let file = std::fs::File::create(&log).with_context(|| log.display().to_string())?;
    let mut child = Command::new("qemu-system-arm")
        .current_dir(directory)
        .args([
            "-machine",
            "netduinoplus2",
            "-nographic",
            "-monitor",
            "none",
        ])
        .args(["-serial", "none", "-icount", "shift=0"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(elf)
        .stdin(Stdio::null())
        .stdout(file.try_clone()?)
        .stderr(file)
        .spawn()
        .context("qemu-system-arm (Debian package qemu-system-arm)")?;
    let deadline = Instant::now() + limit;
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if Instant::now() > deadline {
            child.kill()?;
            child.wait()?;
            bail!("{}: no end after {} s", elf.display(), limit.as_secs());
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    let output = std::fs::read_to_string(&log)?;
    ensure!(status.success(), "{}: {status}\n{output}", elf.display());
    Ok(output)
}

/// Bytes that an ELF file takes of the chip.
#[derive(Clone, Debug)]
pub struct Footprint {
    /// Sections that are loaded, with their size.
    pub sections: Vec<(String, u64)>,
    /// Flash: code, constants and the initial values of variables.
    pub flash: u64,
    /// Static RAM: variables, with and without initial value.
    pub ram: u64,
}

/// Measures an ELF file.
pub fn footprint(elf: &Path) -> Result<Footprint> {
    use object::{Object, ObjectSection, SectionKind};
    let bytes = std::fs::read(elf).with_context(|| elf.display().to_string())?;
    let file = object::File::parse(&*bytes).with_context(|| elf.display().to_string())?;
    let mut found = Footprint {
        sections: Vec::new(),
        flash: 0,
        ram: 0,
    };
    for section in file.sections().filter(|s| s.size() > 0) {
        // What is loaded or reserved; debug information and tables of names are not.
        let (in_flash, in_ram) = match section.kind() {
            SectionKind::Text | SectionKind::ReadOnlyData => (true, false),
            SectionKind::Data => (true, true),
            SectionKind::UninitializedData => (false, true),
            _ => continue,
        };
        found.flash += if in_flash { section.size() } else { 0 };
        found.ram += if in_ram { section.size() } else { 0 };
        found
            .sections
            .push((section.name()?.to_owned(), section.size()));
    }
    Ok(found)
}
