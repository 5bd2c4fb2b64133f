//! `sbom`: lists the crates that are linked into the image, for programs and for
//! docs/generated/supply-chain.md.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::ValueEnum;

use super::emit;
use crate::sbom::{cyclonedx, graph, tables};
use host_sim::emulate::image;

/// Arguments of `sbom`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Part to print
    #[arg(value_enum, default_value_t)]
    what: What,
    /// The image whose code is counted; without it the workspace's image is built
    #[arg(long, value_name = "FILE")]
    elf: Option<PathBuf>,
}

/// Part of the supply chain to print.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum What {
    /// The linked crates as a CycloneDX 1.6 document, kept in docs/generated/image.cdx.json
    #[default]
    Document,
    /// The linked crates as a table: purpose, maintainer, size of the source
    Crates,
    /// The crates that run during the build of the image, as a table
    Build,
    /// Bytes of code of each crate in the image, as a table
    Code,
}

/// Prints the requested list of crates.
///
/// # Errors
/// Cargo, the lock file or the image do not contain the data; the message names them.
pub fn run(args: &Args) -> Result<ExitCode> {
    let root = image::workspace();
    emit(&match args.what {
        What::Document => document(&root)?,
        What::Crates => tables::crates(&root)?,
        What::Build => tables::build_time(&root)?,
        What::Code => {
            let elf = match &args.elf {
                Some(elf) => elf.clone(),
                None => image::build(&[])?,
            };
            tables::code(&elf)?
        }
    });
    Ok(ExitCode::SUCCESS)
}

/// Returns the text of docs/generated/image.cdx.json, the list of crates as a CycloneDX document.
fn document(root: &Path) -> Result<String> {
    let document = cyclonedx::document(&graph::linked(root)?, &toolchain(root)?);
    Ok(format!("{}\n", serde_json::to_string_pretty(&document)?))
}

/// Returns the version of Rust with which the image is built.
fn toolchain(root: &Path) -> Result<String> {
    let path = root.join("rust-toolchain.toml");
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let table: toml::Table = toml::from_str(&text).with_context(|| path.display().to_string())?;
    let channel = table.get("toolchain").and_then(|t| t.get("channel"));
    let channel = channel.and_then(toml::Value::as_str);
    let channel = channel.with_context(|| format!("{}: channel: missing", path.display()))?;
    Ok(channel.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sbom::notes;

    #[test]
    fn the_document_in_the_repository_is_that_of_the_lock_file() {
        let kept = include_str!("../../../docs/generated/image.cdx.json");
        let made = document(&image::workspace()).unwrap();
        assert!(kept == made, "sh docs/make supply-chain");
    }

    /// Every crate of the image needs a note, and every note needs a crate.
    #[test]
    fn each_crate_of_the_image_has_one_note() {
        let crates = graph::linked(&image::workspace()).unwrap();
        let noted: Vec<_> = crates.keys().filter_map(notes::of).collect();
        let missing: Vec<_> = crates.keys().filter(|id| notes::of(id).is_none()).collect();
        assert!(missing.is_empty(), "no note on {missing:?}");
        for note in notes::NOTES.iter() {
            let (name, version) = note.of;
            let count = noted.iter().filter(|other| other.of == note.of).count();
            assert_eq!(count, 1, "{name} {version} is {count} times in the image");
        }
    }

    #[test]
    fn the_tables_of_the_document_are_those_of_the_sources() {
        let root = image::workspace();
        let kept = include_str!("../../../docs/generated/supply-chain.md");
        for (what, table) in [
            ("crates", tables::crates(&root).unwrap()),
            ("build", tables::build_time(&root).unwrap()),
        ] {
            let block = format!("<!-- cargo study sbom {what} -->\n{table}<!-- end -->");
            assert!(kept.contains(&block), "sh docs/make supply-chain");
        }
    }

    #[test]
    fn no_crate_brings_compiled_code() {
        let crates = graph::linked(&image::workspace()).unwrap();
        for (id, of) in crates.iter().filter(|(_, of)| of.checksum.is_some()) {
            let counts = crate::sbom::sources::counts(&of.folder).unwrap();
            assert_eq!(counts.prebuilt, 0, "{} {}", id.name, id.version);
        }
    }
}
