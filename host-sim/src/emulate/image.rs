//! Building the image, and reading its sizes and symbols.

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

/// Parts of the names of allocator functions.
pub const ALLOCATOR: &[&str] = &["__rust_alloc", "__rg_alloc", "__rdl_alloc", "malloc"];
/// Parts of the names of double-precision soft-float functions.
pub const DOUBLE: &[&str] = &["__aeabi_d", "adddf3", "muldf3", "divdf3", "__aeabi_f2d"];
/// Parts of the names of what a panic calls. `rust_begin_unwind` is the panic handler: the linker
/// drops it from an image in which nothing can panic.
pub const PANIC: &[&str] = &[
    "panicking",
    "rust_begin_unwind",
    "unwrap_failed",
    "expect_failed",
];

/// Sizes and symbols of an ELF file.
#[derive(Clone, Debug, Default)]
pub struct Sizes {
    /// Bytes of flash: everything that is loaded.
    pub flash: u64,
    /// Bytes of static RAM: data, zeroed and uninitialised memory.
    pub ram: u64,
    /// Names of all symbols.
    pub symbols: Vec<String>,
}

/// Where the chip's SRAM begins; the stack's region is not allocated by any section.
const SRAM: std::ops::Range<u64> = 0x2000_0000..0x2002_0000;

impl Sizes {
    /// Reads an image.
    pub fn read(elf: &Path) -> Result<Self> {
        let bytes = std::fs::read(elf).with_context(|| format!("{}", elf.display()))?;
        Self::parse(&bytes).with_context(|| format!("{}: no ELF file for ARM", elf.display()))
    }

    /// Reads the section headers and the symbol table of a 32-bit little-endian ELF file.
    fn parse(elf: &[u8]) -> Option<Self> {
        let half = |at: usize| Some(u16::from_le_bytes(elf.get(at..at + 2)?.try_into().ok()?));
        let word = |at: usize| Some(u32::from_le_bytes(elf.get(at..at + 4)?.try_into().ok()?));
        const ARM: u16 = 40;
        if elf.get(..6)? != b"\x7fELF\x01\x01" || half(18)? != ARM {
            return None;
        }
        let (table, entry) = (word(32)? as usize, usize::from(half(46)?));
        let count = usize::from(half(48)?);
        let header = |k: usize| -> Option<[u32; 10]> {
            let mut fields = [0; 10];
            for (n, field) in fields.iter_mut().enumerate() {
                *field = word(table + k * entry + 4 * n)?;
            }
            Some(fields)
        };
        let mut sizes = Self::default();
        for k in 0..count {
            let [_, kind, flags, address, offset, size, link, ..] = header(k)?;
            let (allocated, symbols, empty) = (2, 2, 8);
            if flags & allocated != 0 {
                let in_ram = SRAM.contains(&address.into());
                sizes.ram += if in_ram { u64::from(size) } else { 0 };
                sizes.flash += if kind != empty { u64::from(size) } else { 0 };
            }
            if kind == symbols {
                let [_, _, _, _, names, ..] = header(link as usize)?;
                for at in (offset..offset + size).step_by(16) {
                    let name = elf.get(names as usize + word(at as usize)? as usize..)?;
                    let end = name.iter().position(|&b| b == 0)?;
                    sizes
                        .symbols
                        .push(String::from_utf8_lossy(&name[..end]).into_owned());
                }
            }
        }
        Some(sizes)
    }

    /// How many symbols hold one of `parts`.
    pub fn count(&self, parts: &[&str]) -> u64 {
        let holds = |name: &&String| parts.iter().any(|part| name.contains(part));
        self.symbols.iter().filter(holds).count() as u64
    }
}
