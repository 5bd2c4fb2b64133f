//! Functions, lines and panics of an ELF file.

use std::ops::Range;
use std::path::Path;

use addr2line::Context;
use anyhow::{Context as _, Result};
use gimli::{Dwarf, EndianSlice, LittleEndian, Section as _};
use object::SectionFlags;
use object::read::{Object, ObjectSection, ObjectSymbol};
use stairscan::crc;

use crate::emulate::image::file;

/// Bytes of a section.
pub type Slice<'data> = EndianSlice<'data, LittleEndian>;

/// Returns the debugging information of an ELF file; a section that it lacks is empty.
///
/// # Errors
/// The debugging information is damaged.
pub fn dwarf<'data>(file: &object::File<'data>) -> Result<Dwarf<Slice<'data>>, gimli::Error> {
    Dwarf::load(|id| {
        let data = (file.section_by_name(id.name())).and_then(|section| section.data().ok());
        Ok(EndianSlice::new(data.unwrap_or_default(), LittleEndian))
    })
}

/// Longest name of a source file, bytes.
const LONGEST_NAME: usize = 400;

/// An image with its debugging information.
pub struct Image<'data> {
    file: object::File<'data>,
    lines: Context<Slice<'data>>,
}

impl<'data> Image<'data> {
    /// Parses the bytes of the ELF file `elf`.
    ///
    /// # Errors
    /// The file is no ELF file, no image of this scanner, or has no debugging information; the message names it.
    pub fn parse(elf: &Path, bytes: &'data [u8]) -> Result<Self> {
        let name = || format!("{}: no image with debugging information", elf.display());
        let file = file(elf, bytes)?;
        let dwarf = dwarf(&file).with_context(name)?;
        anyhow::ensure!(!dwarf.debug_info.reader().is_empty(), name());
        let lines = Context::from_dwarf(dwarf).with_context(name)?;
        Ok(Self { file, lines })
    }

    /// Returns the functions that contain an address, the innermost first: name, file, line and column.
    ///
    /// # Errors
    /// The debugging information is damaged.
    pub fn frames(&self, address: u32) -> Result<Vec<String>> {
        let mut frames = self.lines.find_frames(address.into()).skip_all_loads()?;
        let mut found = Vec::new();
        while let Some(frame) = frames.next()? {
            let name = frame.function.as_ref().map(|name| name.demangle());
            let name = match name {
                Some(name) => name?.into_owned(),
                None => "?".to_owned(),
            };
            let at = frame.location.and_then(|at| {
                let (file, line) = (at.file?, at.line?);
                let column = at.column.map(|column| format!(":{column}"));
                Some(format!("{file}:{line}{}", column.unwrap_or_default()))
            });
            found.push(format!("{name}, {}", at.as_deref().unwrap_or("no line")));
        }
        Ok(found)
    }

    /// Returns sections that the chip has in memory, with their addresses.
    fn sections(&self) -> impl Iterator<Item = (u64, &'data [u8])> {
        self.file.sections().filter_map(|section| {
            let SectionFlags::Elf { sh_flags, .. } = section.flags() else {
                return None;
            };
            let held = sh_flags.contains(object::elf::SHF_ALLOC);
            Some((section.address(), section.data().ok().filter(|_| held)?))
        })
    }

    /// Whether the image contains these bytes.
    pub fn contains(&self, bytes: &[u8]) -> bool {
        !bytes.is_empty()
            && (self.sections()).any(|(_, data)| data.windows(bytes.len()).any(|w| w == bytes))
    }

    /// Returns the bytes of an address range of the image.
    fn at(&self, address: u32, length: usize) -> Option<&'data [u8]> {
        self.sections().find_map(|(start, data)| {
            let from = u64::from(address).checked_sub(start)?;
            data.get(usize::try_from(from).ok()?..)?.get(..length)
        })
    }

    /// Returns the place of the panic with this hash ([`crc::of_place`]) as `file:line:column`: the image holds each
    /// place as four words, address and length of the file's name, line and column.
    pub fn panic_at(&self, hash: u32) -> Option<String> {
        self.sections().find_map(|(_, data)| {
            data.windows(16).step_by(4).find_map(|bytes| {
                let (words, _) = bytes.as_chunks::<4>();
                let &[name, length, line, column] = words else {
                    return None;
                };
                let [name, length, line, column] =
                    [name, length, line, column].map(u32::from_le_bytes);
                let length = usize::try_from(length)
                    .ok()
                    .filter(|&l| l <= LONGEST_NAME)?;
                let file = str::from_utf8(self.at(name, length)?).ok()?;
                let known = file.ends_with(".rs") && crc::of_place(file, line, column) == hash;
                known.then(|| format!("{file}:{line}:{column}"))
            })
        })
    }

    /// Returns the addresses below the stack that memory protection closes; none if the image does not name them.
    pub fn guard(&self) -> Range<u32> {
        let find = |name: &str| {
            let symbol = self.file.symbols().find(|s| s.name() == Ok(name))?;
            u32::try_from(symbol.address()).ok()
        };
        match (find("_stack_bottom"), find("_stack_end")) {
            (Some(bottom), Some(end)) => bottom..end,
            _ => 0..0,
        }
    }
}
