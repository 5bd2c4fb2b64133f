//! Seals a firmware image: adds the checksum with which it verifies itself at boot (`stairscan::scanner::seal`).

use std::fs::{self, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use object::Endianness;
use object::read::elf::{ElfFile32, ProgramHeader};
use object::read::{Object, ObjectSection};
use stairscan::scanner::seal::{CODE, CODE_END, SECTION, VECTORS, WORDS, seal as of_parts};
use stairscan_boot::slot::Slot;

use crate::recording::regular;
use crate::update::keys;
use crate::update::package::Package;

/// Size of a seal, the words that hold an image's checksum, in the file, bytes.
const BYTES: usize = WORDS * size_of::<u32>();

/// Writes the seal, the words that hold an image's checksum, into its ELF file unless it is already there; returns
/// it. Only these bytes are written, so that a concurrent reader sees a complete file.
///
/// # Errors
/// The file cannot be sealed; the message names the cause.
pub fn seal(elf: &Path) -> Result<[u32; WORDS]> {
    regular(elf)?;
    let name = || elf.display().to_string();
    let bytes = fs::read(elf).with_context(name)?;
    let (place, seal) = of_file(&bytes).with_context(name)?;
    let words = seal.map(u32::to_le_bytes);
    replace(elf, &bytes, place, words.as_flattened()).with_context(name)?;
    Ok(seal)
}

/// Writes `new` to the offset `place` of the file `path`, whose content is `bytes`, unless it is there.
fn replace(path: &Path, bytes: &[u8], place: usize, new: &[u8]) -> Result<()> {
    if bytes.get(place..place + new.len()) != Some(new) {
        let mut file = OpenOptions::new().write(true).open(path)?;
        file.seek(SeekFrom::Start(place as u64))?;
        file.write_all(new)?;
    }
    Ok(())
}

/// Name of the ELF section of the signed header.
const HEADER: &str = ".header";

/// Signs the image in an ELF file with the development key for flash slot A, and writes the signed header into the
/// file. `order` ranks it above an image that was confirmed before.
///
/// # Errors
/// Names the reason for which the image cannot be signed.
pub fn sign(elf: &Path, order: u32) -> Result<()> {
    let name = || elf.display().to_string();
    let package = Package::sign(elf, 0, &keys::development()?)?;
    let slot = package.image(Slot::A).slot(order);
    let bytes = fs::read(elf).with_context(name)?;
    let file = ElfFile32::<Endianness>::parse(&*bytes).with_context(name)?;
    let section = file.section_by_name(HEADER).context("no section .header")?;
    let (place, size) = section.file_range().context("an empty header")?;
    let head = slot
        .get(..usize::try_from(size)?)
        .context("a long header")?;
    replace(elf, &bytes, usize::try_from(place)?, head).with_context(name)
}

/// Returns the offset of the seal in an ELF file, bytes, and its correct words.
fn of_file(bytes: &[u8]) -> Result<(usize, [u32; WORDS])> {
    let file = ElfFile32::<Endianness>::parse(bytes).context("no ELF file of 32 bits")?;
    let section = file
        .section_by_name(SECTION)
        .with_context(|| format!("no section {SECTION}: no image of this scanner"))?;
    let (place, size) = section.file_range().context("an empty seal")?;
    ensure!(
        size == BYTES as u64,
        "a seal of {size} bytes instead of {BYTES}"
    );
    let mut loaded = loaded(&file)?;
    loaded.sort_by_key(|(address, _)| *address);
    let seal_at = u32::try_from(section.address())?;
    let vectors = joined(&loaded, VECTORS, seal_at)?;
    // Behind the slot a demo image has its recording.
    let code = joined(&loaded, CODE, CODE_END)?;
    let seal = of_parts(&vectors, &code).context("longer than the flash has room")?;
    Ok((usize::try_from(place)?, seal))
}

/// Returns the segments that the file loads into flash: addresses and bytes.
fn loaded<'data>(file: &ElfFile32<'data, Endianness>) -> Result<Vec<(u32, &'data [u8])>> {
    let (endian, data) = (file.endian(), file.data());
    let mut parts = Vec::new();
    for header in file.elf_program_headers() {
        let load = header.p_type(endian) == object::elf::PT_LOAD;
        if load && header.p_filesz(endian) > 0 {
            let bytes = header.data(endian, data);
            let bytes = bytes.map_err(|()| anyhow::anyhow!("a segment beyond the file's end"))?;
            parts.push((header.p_paddr(endian), bytes));
        }
    }
    Ok(parts)
}

/// Returns the segments that an ELF file loads into flash, in the order of their addresses: address and bytes.
///
/// # Errors
/// Names the file, which is missing or no ELF file.
pub fn segments(elf: &Path) -> Result<Vec<(u32, Vec<u8>)>> {
    let name = || elf.display().to_string();
    regular(elf)?;
    let bytes = fs::read(elf).with_context(name)?;
    let file = ElfFile32::<Endianness>::parse(&*bytes).with_context(name)?;
    let parts = loaded(&file).with_context(name)?;
    let mut parts: Vec<_> = parts.into_iter().map(|(at, b)| (at, b.to_vec())).collect();
    parts.sort();
    Ok(parts)
}

/// Returns the number of bytes that two images load into flash, if both load the same ones to the same addresses.
///
/// # Errors
/// A file is not an image, or the images differ; the message names the first address at which they do.
pub fn same(one: &Path, other: &Path) -> Result<usize> {
    let (ours, theirs) = (segments(one)?, segments(other)?);
    let name = |elf: &Path| elf.display().to_string();
    for ((at, a), (there, b)) in ours.iter().zip(&theirs) {
        let differs = a.iter().zip(b).position(|(a, b)| a != b);
        let short = (a.len() != b.len()).then(|| a.len().min(b.len()));
        let first = (at != there).then_some(0).or(differs).or(short);
        if let Some(first) = first {
            bail!(
                "{} and {} differ in flash, first at 0x{:08x}",
                name(one),
                name(other),
                *at as usize + first
            );
        }
    }
    let count = |parts: &[(u32, Vec<u8>)]| parts.iter().map(|(_, b)| b.len()).sum::<usize>();
    let (ours, theirs) = (count(&ours), count(&theirs));
    ensure!(
        ours == theirs && ours > 0,
        "{} brings {ours} bytes into flash, {} {theirs}",
        name(one),
        name(other)
    );
    Ok(ours)
}

/// Returns the contiguous bytes of `parts` from address `from` up to, but without, `to`, or up to the last one.
fn joined(parts: &[(u32, &[u8])], from: u32, to: u32) -> Result<Vec<u8>> {
    let mut all = Vec::new();
    for (address, bytes) in parts.iter().filter(|(at, _)| (from..to).contains(at)) {
        let at = (address - from) as usize;
        if at != all.len() {
            bail!("a gap in the image before 0x{address:08x}");
        }
        let room = (to - address) as usize;
        all.extend(bytes.iter().take(room));
    }
    ensure!(!all.is_empty(), "nothing at 0x{from:08x}");
    Ok(all)
}
