//! Formats the tables of docs/generated/supply-chain.md, as Markdown.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result};

use super::{code, graph, notes, sources};
use host_sim::emulate::image::Image;

/// Bytes per kilobyte of flash.
const KB: f64 = 1024.0;

/// Licence of most crates; the document names it once, and the tables the others.
const USUAL: &str = "MIT OR Apache-2.0";

/// Returns a crate's licence as a table cell: empty for the [usual](USUAL) one.
fn licence(of: &str) -> &str {
    match of {
        USUAL | "Apache-2.0 OR MIT" => "",
        other => other,
    }
}

/// Returns the table of the image's crates: purpose, maintainer, and contents of their sources.
///
/// # Errors
/// A crate has no entry in [`notes::NOTES`], or its sources cannot be counted; the message names
/// it.
pub fn crates(root: &Path) -> Result<String> {
    let crates = graph::linked(root)?;
    let mut out = String::from(
        "| crate | licence | why | maintained by | lines | `unsafe` | build script |\n\
         |---|---|---|---|--:|--:|---|\n",
    );
    for (id, of) in &crates {
        let note = notes::of(id).with_context(|| {
            format!(
                "{} {}: not in studies/src/sbom/notes.txt: why is it in the image, and who maintains it?",
                id.name, id.version
            )
        })?;
        let by = match of.repository.is_empty() {
            true => note.by.to_owned(),
            false => format!("[{}]({})", note.by, of.repository),
        };
        // Not counted for this repository's own sources, which change with every commit.
        let counted = match of.checksum.is_some() {
            true => {
                let counts = sources::counts(&of.folder)?;
                format!("{} | {}", counts.lines, counts.unsafes)
            }
            false => "– | –".to_owned(),
        };
        let _ = writeln!(
            out,
            "| `{}` {} | {} | {} | {by} | {counted} | {} |",
            id.name,
            id.version,
            licence(&of.licence),
            note.why,
            if of.build_script { "yes" } else { "" },
        );
    }
    Ok(out)
}

/// Returns the table of crates that run on the build machine and are not part of the image.
///
/// # Errors
/// Those of [`graph::built_with`].
pub fn build_time(root: &Path) -> Result<String> {
    let crates = graph::built_with(root, &graph::linked(root)?)?;
    let mut out = String::from(
        "| crate | licence | procedural macro | build script | needed by |\n|---|---|---|---|---|\n",
    );
    for (id, of) in &crates {
        let used_by: Vec<String> = of.used_by.iter().map(|name| format!("`{name}`")).collect();
        let yes = |holds: bool| if holds { "yes" } else { "" };
        let _ = writeln!(
            out,
            "| `{}` {} | {} | {} | {} | {} |",
            id.name,
            id.version,
            licence(&of.licence),
            yes(of.proc_macro),
            yes(of.build_script),
            used_by.join(", "),
        );
    }
    Ok(out)
}

/// Returns the table of the image's code and constants by crate, in descending order.
///
/// # Errors
/// The file is not an image with a line table; the message names the cause.
pub fn code(elf: &Path) -> Result<String> {
    let sizes = code::by_crate(elf)?;
    let image = Image::read(elf)?;
    let mut rows: Vec<(String, u64)> = sizes.into_iter().collect();
    let total: u64 = rows.iter().map(|(_, bytes)| bytes).sum();
    rows.push((
        "constants, vectors, code without lines".to_owned(),
        image.flash.saturating_sub(total),
    ));
    rows.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    let mut out = String::from("| crate | bytes | share of flash |\n|---|--:|--:|\n");
    for (name, bytes) in &rows {
        let share = 100.0 * *bytes as f64 / image.flash as f64;
        let _ = writeln!(out, "| {name} | {bytes} | {share:.1} % |");
    }
    let _ = writeln!(
        out,
        "| all | {} ({:.1} KB) | 100 % |",
        image.flash,
        image.flash as f64 / KB
    );
    Ok(out)
}
