//! Counts the contents of a crate's sources in the folder that Cargo compiles.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

/// Suffixes of the names of files that hold compiled code.
const PREBUILT: [&str; 6] = ["a", "o", "so", "lib", "dll", "dylib"];

/// Counts of lines and files of a crate's sources.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Lines of Rust in `src/` that are neither empty nor comments.
    pub lines: usize,
    /// Number of lines of Rust in `src/`, without comments, that contain the word `unsafe`.
    pub unsafes: usize,
    /// Number of files with compiled code, anywhere in the package.
    pub prebuilt: usize,
}

/// Counts the sources of the crate in `folder`.
///
/// # Errors
/// A file or folder cannot be read; the message names it.
pub fn counts(folder: &Path) -> Result<Counts> {
    let mut counts = Counts::default();
    for path in files(&folder.join("src"))? {
        if suffix(&path) == "rs" {
            let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            let (lines, unsafes) = code_lines(&text);
            counts.lines += lines;
            counts.unsafes += unsafes;
        }
    }
    let prebuilt = |path: &&PathBuf| PREBUILT.contains(&suffix(path));
    counts.prebuilt = files(folder)?.iter().filter(prebuilt).count();
    Ok(counts)
}

/// Returns the number of lines of code in a text, and the number of those with the word `unsafe`.
fn code_lines(text: &str) -> (usize, usize) {
    let code = text
        .lines()
        .map(str::trim)
        .filter(|line| !line.is_empty() && !line.starts_with("//"));
    let word = |line: &&str| {
        let part = |c: char| !(c.is_alphanumeric() || c == '_');
        line.split(part).any(|word| word == "unsafe")
    };
    (code.clone().count(), code.filter(word).count())
}

fn suffix(path: &Path) -> &str {
    path.extension()
        .and_then(|suffix| suffix.to_str())
        .unwrap_or_default()
}

/// Returns the paths of all files below a folder.
fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let entries = fs::read_dir(&folder).with_context(|| folder.display().to_string())?;
        for entry in entries {
            let entry = entry?;
            match entry.file_type()?.is_dir() {
                true => folders.push(entry.path()),
                false => found.push(entry.path()),
            }
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_names_with_unsafe_in_them_do_not_count() {
        let text = "// unsafe\n\nunsafe { a() }\nlet unsafe_code = 1;\n    /// x\nfn b() {}\n";
        assert_eq!(code_lines(text), (3, 1));
    }
}
