//! Counts the bytes of the image's code by the crate that they were compiled from.
//!
//! The line table of the debugging information contains the source file and line of each
//! instruction, also where a function was inlined into one of another crate. Symbols would assign
//! such code to the caller.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use gimli::{Dwarf, LineRow, Unit};

use super::graph::ROOT;
use host_sim::crash::image::{Slice, dwarf};
use host_sim::recording::regular;

/// Start address of the chip's flash. Functions that the linker dropped have lower addresses.
const FLASH: u64 = 0x0800_0000;
/// Separator of folders in the paths of source files that the line table names.
const PARTED: char = '/';

/// First address of a range of instructions that one row of the line table covers, and the crate of the row's source
/// file. The range ends at the next entry's address; an entry with `None` only marks such an end.
type Stretch = (u64, Option<String>);

/// Returns the number of bytes of code in flash by crate. The key is `NAME-VERSION` for a package,
/// and the name alone for the image's own crate and for the toolchain's.
///
/// # Errors
/// The file has no line table; the message names it and the cause.
pub fn by_crate(elf: &Path) -> Result<BTreeMap<String, u64>> {
    let name = || elf.display().to_string();
    regular(elf)?;
    let bytes = std::fs::read(elf).with_context(name)?;
    let file = object::File::parse(&*bytes).with_context(name)?;
    let dwarf = dwarf(&file)?;
    let mut sizes = BTreeMap::new();
    let mut units = dwarf.units();
    while let Some(header) = units.next()? {
        let unit = dwarf.unit(header)?;
        let stretches = stretches(&dwarf, &unit)?;
        for pair in stretches.windows(2) {
            if let [(from, Some(of)), (to, _)] = pair
                && *from >= FLASH
            {
                *sizes.entry(of.clone()).or_default() += to.saturating_sub(*from);
            }
        }
    }
    ensure!(
        !sizes.is_empty(),
        "{}: holds no line table of code in flash",
        elf.display()
    );
    Ok(sizes)
}

/// Returns the address ranges of a compilation unit's instructions, each with its crate: one entry for each row of the
/// unit's line table, in the table's order.
fn stretches(dwarf: &Dwarf<Slice<'_>>, unit: &Unit<Slice<'_>>) -> Result<Vec<Stretch>> {
    let Some(program) = unit.line_program.clone() else {
        return Ok(Vec::new());
    };
    let mut stretches = Vec::new();
    let mut rows = program.rows();
    let mut known: BTreeMap<u64, String> = BTreeMap::new();
    while let Some((header, row)) = rows.next_row()? {
        let of = match (row.end_sequence(), known.get(&row.file_index())) {
            (true, _) => None,
            (false, Some(name)) => Some(name.clone()),
            (false, None) => {
                let name = crate_of(&path(dwarf, unit, header, row)?);
                known.insert(row.file_index(), name.clone());
                Some(name)
            }
        };
        stretches.push((row.address(), of));
    }
    Ok(stretches)
}

/// Returns the path of the source file of a row of the line table.
fn path(
    dwarf: &Dwarf<Slice<'_>>,
    unit: &Unit<Slice<'_>>,
    header: &gimli::LineProgramHeader<Slice<'_>>,
    row: &LineRow,
) -> Result<String> {
    let file = row.file(header).context("a line without a file")?;
    let mut path = String::new();
    if let Some(directory) = file.directory(header) {
        path.push_str(&dwarf.attr_string(unit, directory)?.to_string_lossy());
        path.push(PARTED);
    }
    path.push_str(&dwarf.attr_string(unit, file.path_name())?.to_string_lossy());
    Ok(path)
}

/// Returns the crate to which the source file `path` of the line table belongs: `NAME-VERSION` for a package, the name
/// alone for the toolchain's crates and the image's own.
fn crate_of(path: &str) -> String {
    let path = path.replace('\\', "/");
    let parts: Vec<&str> = path.split(PARTED).collect();
    // The toolchain's library: /rustc/COMMIT/library/core/src/…, or …/src/rust/library/core/src/… where its sources are
    // installed.
    for at in parts.windows(4) {
        if let ["rustc", _, "library", name] | [_, "rust", "library", name] = at {
            return name.replace('-', "_");
        }
    }
    // A package: …/NAME-VERSION/src/….
    let package = parts.iter().find(|part| is_package(part));
    package.map_or_else(|| ROOT.to_owned(), |part| (*part).to_owned())
}

/// Whether a folder's name has the form of a package's sources in Cargo's registry, such as
/// `NAME-1.2.3`.
fn is_package(folder: &str) -> bool {
    let Some((name, version)) = folder.rsplit_once('-') else {
        return false;
    };
    let numbers: Vec<&str> = version.split('.').collect();
    !name.is_empty() && numbers.len() == 3 && numbers.iter().all(|n| n.parse::<u32>().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_names_its_crate() {
        for (path, name) in [
            (
                "/home/x/.cargo/registry/src/index-0123/heapless-0.9.3/src/vec.rs",
                "heapless-0.9.3",
            ),
            ("/rustc/0123/library/core/src/num.rs", "core"),
            (
                "/rustc/0123/library/compiler-builtins/libm/src/math/sqrt.rs",
                "compiler_builtins",
            ),
            ("/a/src/infer/mod.rs", "stairscan"),
            ("src/infer/mod.rs", "stairscan"),
        ] {
            assert_eq!(crate_of(path), name, "{path}");
        }
    }
}
