//! Builds the firmware's image, and reads sizes and symbols of its ELF file.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use object::read::{Object, ObjectSection, ObjectSymbol};
use object::{RelocationTarget, SectionFlags, SectionKind, SymbolKind};
use stairscan::scanner::seal::SECTION;

use super::building::watched;
use super::seal::seal;
use super::tools::{TARGET, Tool, WEB};
use crate::recording::regular;

/// Returns the directory of the workspace that this program was built from.
pub fn workspace() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_owned()
}

/// Builds the firmware's image as `cargo firmware` does, seals it with its checksum, and returns its path. `features`
/// are for test builds, whose images go to a separate directory.
pub fn build(features: &[&str]) -> Result<PathBuf> {
    let elf = build_bin("stairscan", "stairscan", features)?;
    seal(&elf)?;
    Ok(elf)
}

/// Seals an image that was built before.
///
/// # Errors
/// The file is missing, for which the message names the remedy, or cannot be sealed.
pub fn seal_built(elf: &Path) -> Result<[u32; stairscan::scanner::seal::WORDS]> {
    ensure!(
        elf.exists(),
        "{}: no such file: `cargo firmware` builds the image, target/{TARGET}/firmware/stairscan",
        elf.display()
    );
    seal(elf)
}

/// Builds the boot loader with the key that the environment names, else the development key; returns its ELF file.
pub fn build_loader() -> Result<PathBuf> {
    build_bin("stairscan-boot", "stairscan-boot", &[])
}

/// Builds any program for the chip with the firmware's profile; returns its ELF file.
pub fn build_bin(package: &str, bin: &str, features: &[&str]) -> Result<PathBuf> {
    Tool::Target.need()?;
    let root = workspace();
    let build_dir = build_dir(&root);
    let mut target = build_dir.clone();
    if !features.is_empty() {
        target = target.join(features.join("-"));
    }
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut build = Command::new(cargo);
    build
        .current_dir(&root)
        // Dependencies of both builds are built once.
        .env("CARGO_BUILD_BUILD_DIR", &build_dir)
        .args(["build", "--quiet", "--profile", "firmware"])
        .args(["--package", package, "--bin", bin])
        .args(["--target", TARGET, "--target-dir"])
        .arg(&target)
        .args(["--features", &features.join(",")]);
    watched(build, package, TARGET)?;
    Ok(target.join(TARGET).join("firmware").join(bin))
}

/// Returns the directory of this workspace's build artifacts.
fn build_dir(root: &Path) -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), |dir| root.join(dir))
}

/// Builds the scanner of the browser's page, a workspace of its own; returns the path of its WebAssembly module.
pub fn build_web() -> Result<PathBuf> {
    const PACKAGE: &str = "stairscan-web";
    Tool::Web.need()?;
    let root = workspace();
    let target = build_dir(&root);
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut build = Command::new(cargo);
    build
        .current_dir(root.join("web"))
        .args([
            "build",
            "--quiet",
            "--locked",
            "--release",
            "--package",
            PACKAGE,
        ])
        .args(["--target", WEB, "--target-dir"])
        .arg(&target);
    watched(build, PACKAGE, WEB)?;
    Ok(target.join(WEB).join("release/stairscan_web.wasm"))
}

/// Parts of the names of allocator functions, of which the image must contain none.
pub const ALLOCATOR: &[&str] = &["__rust_alloc", "__rg_alloc", "__rdl_alloc", "malloc"];
/// Parts of the names of functions for double-precision arithmetic in software, of which the image must contain none.
pub const DOUBLE: &[&str] = &["__aeabi_d", "adddf3", "muldf3", "divdf3", "__aeabi_f2d"];
/// Parts of the names of functions that a panic calls.
const PANIC: &[&str] = &[
    "panicking",
    "rust_begin_unwind",
    "unwrap_failed",
    "expect_failed",
    "slice_index_fail",
    "option_expect",
];
/// Parts of the names of the only functions that may call a panic: the logger's check against re-entry. It cannot
/// trigger on one core with interrupts off.
const LOGGER: &[&str] = &["_defmt_acquire", "_defmt_release"];

/// Memory use and symbols of the firmware's image.
#[derive(Clone, Debug, Default)]
pub struct Image {
    /// Sections that are loaded or reserved: name and size in bytes.
    pub sections: Vec<(String, u64)>,
    /// Flash use, bytes: all sections that are loaded.
    pub flash: u64,
    /// Static RAM, bytes: sections of data, zeroed and uninitialised memory.
    pub ram: u64,
    /// Names of all symbols of the image.
    pub symbols: Vec<String>,
    /// Names of functions that may panic, from the relocations that the linker leaves in the image: every call and
    /// every function address.
    pub may_panic: Vec<String>,
}

/// Address range of the chip's SRAM. The stack's region is not allocated by any section.
const SRAM: std::ops::Range<u64> = 0x2000_0000..0x2002_0000;

fn bytes(elf: &Path) -> Result<Vec<u8>> {
    regular(elf)?;
    std::fs::read(elf).with_context(|| format!("{}", elf.display()))
}

/// Parses the bytes of the ELF file `elf`.
fn parse<'data>(elf: &Path, bytes: &'data [u8]) -> Result<object::File<'data>> {
    let file =
        object::File::parse(bytes).with_context(|| format!("{}: no ELF file", elf.display()))?;
    ensure!(
        file.architecture() == object::Architecture::Arm,
        "{}: no ELF file for ARM: expected the image that `cargo firmware` builds",
        elf.display()
    );
    Ok(file)
}

/// Checks that the emulator can boot a file as an image of the scanner.
///
/// # Errors
/// The file is missing, or those of [`file()`].
pub fn check(elf: &Path) -> Result<()> {
    file(elf, &bytes(elf)?).map(|_| ())
}

/// Parses the bytes of the ELF file `elf`, which must be an image of the scanner: it has the section of the image's own
/// checksum.
///
/// # Errors
/// The file is not an ELF file, is for another processor, or is another program; the message names it.
pub fn file<'data>(elf: &Path, bytes: &'data [u8]) -> Result<object::File<'data>> {
    let file = parse(elf, bytes)?;
    ensure!(
        file.section_by_name(SECTION).is_some(),
        "{}: no image of this scanner, which has a section {SECTION}: expected that which `cargo firmware` builds",
        elf.display()
    );
    Ok(file)
}

impl Image {
    /// Reads memory use and symbols of an ELF file.
    pub fn read(elf: &Path) -> Result<Self> {
        let bytes = bytes(elf)?;
        let file = parse(elf, &bytes)?;
        let mut image = Self::default();
        let functions = functions(&file);
        let mut relocations = 0;
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags, .. } = section.flags() else {
                continue;
            };
            if sh_flags.contains(object::elf::SHF_ALLOC) && section.size() > 0 {
                let name = section.name()?.to_owned();
                image.sections.push((name, section.size()));
                let in_ram = SRAM.contains(&section.address());
                let loaded = section.kind() != SectionKind::UninitializedData;
                image.ram += if in_ram { section.size() } else { 0 };
                image.flash += if loaded { section.size() } else { 0 };
            }
            for (address, relocation) in section.relocations() {
                relocations += 1;
                let RelocationTarget::Symbol(target) = relocation.target() else {
                    continue;
                };
                if !holds(file.symbol_by_index(target)?.name()?, PANIC) {
                    continue;
                }
                let caller = functions.range(..=address).next_back();
                let caller = caller.map_or("?", |(_, name)| *name);
                if section.kind() == SectionKind::Text && !holds(caller, PANIC) {
                    image.may_panic.push(caller.to_owned());
                }
            }
        }
        ensure!(
            relocations > 0,
            "{}: without relocations, possible panics are unknown",
            elf.display()
        );
        image.may_panic.retain(|name| !holds(name, LOGGER));
        let names = file.symbols().filter_map(|symbol| symbol.name().ok());
        image.symbols = names.map(str::to_owned).collect();
        Ok(image)
    }

    /// Returns the number of symbols whose names contain one of `parts`.
    pub fn count(&self, parts: &[&str]) -> u64 {
        let holds = |name: &&String| holds(name, parts);
        self.symbols.iter().filter(holds).count() as u64
    }
}

/// Copies the image `elf` to `to` and changes one of its variables, which is given by parts of its symbol and its
/// size in bytes.
///
/// # Errors
/// The file is missing, is not an ELF file, or does not contain exactly one such variable of `size` bytes; the
/// message names it.
pub fn patch(
    elf: &Path,
    to: &Path,
    (symbol, size): (&[&str], usize),
    change: impl FnOnce(&mut [u8]),
) -> Result<()> {
    let mut image = bytes(elf)?;
    let at = place(&parse(elf, &image)?, symbol, size)
        .with_context(|| format!("{}: not one {symbol:?} of {size} bytes", elf.display()))?;
    change(&mut image[at..at + size]);
    crate::recording::write_whole(to, &image)
}

/// Returns the file offset of the only variable with this size and these parts in its symbol.
fn place(file: &object::File<'_>, symbol: &[&str], size: usize) -> Option<usize> {
    let named = |name: &str| symbol.iter().all(|part| name.contains(part));
    let mut found = file.symbols().filter(|s| s.name().is_ok_and(named));
    let variable = found.next().filter(|s| s.size() == size as u64)?;
    let section = file.section_by_index(variable.section_index()?).ok()?;
    let (begin, length) = section.file_range()?;
    let within = variable.address().checked_sub(section.address())?;
    let whole = within + variable.size() <= length && found.next().is_none();
    whole.then_some((begin + within) as usize)
}

fn holds(name: &str, parts: &[&str]) -> bool {
    parts.iter().any(|part| name.contains(part))
}

/// Returns the names of an image's functions by their start addresses.
fn functions<'data>(file: &object::File<'data>) -> BTreeMap<u64, &'data str> {
    let text = file.symbols().filter(|s| s.kind() == SymbolKind::Text);
    // The lowest bit marks Thumb code.
    text.filter_map(|s| Some((s.address() & !1, s.name().ok()?)))
        .filter(|(_, name)| !name.starts_with('$'))
        .collect()
}
