//! Documents of the repository, and the blocks in them that commands print.

#![allow(
    dead_code,
    reason = "compiled into two test programs, of which each uses a part"
)]

use std::path::{Path, PathBuf};
use std::process::Command;

use walkdir::WalkDir;

/// Returns the directory of the repository.
pub fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Returns the standard output of `PROGRAM WORDS`, run in the repository.
pub fn printed(program: &str, words: &str) -> String {
    let output = Command::new(program)
        .args(words.split(' '))
        .current_dir(root())
        .output()
        .unwrap();
    assert!(output.status.success(), "{program} {words}: {output:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// Returns the blocks of a document that a command prints: its arguments, and the block between `<!--
/// text: cargo ALIAS WORDS -->` and `<!-- end -->`.
pub fn blocks<'a>(document: &'a str, alias: &str) -> Vec<(&'a str, &'a str)> {
    let mark = format!("<!-- text: cargo {alias} ");
    let mut parts = document.split(&*mark);
    parts.next();
    parts
        .map(|part| {
            let (words, rest) = part.split_once(" -->\n").unwrap();
            let (filled, _) = rest.split_once("<!-- end -->").unwrap();
            let text = filled.strip_prefix("```text\n").unwrap_or(filled);
            (words, text.strip_suffix("```\n").unwrap_or(text))
        })
        .collect()
}

/// README and the documents of `docs/`: path and text.
pub fn documents() -> Vec<(PathBuf, String)> {
    let documents = WalkDir::new(root().join("docs"))
        .sort_by_file_name()
        .into_iter();
    let documents = documents.map(|entry| entry.unwrap().into_path());
    let markdown = |path: &PathBuf| path.extension().is_some_and(|suffix| suffix == "md");
    let documents = documents.filter(markdown).chain([root().join("README.md")]);
    documents
        .map(|path| {
            let text = std::fs::read_to_string(&path).unwrap();
            (path, text)
        })
        .collect()
}

pub fn name(path: &Path) -> String {
    path.file_name().unwrap().to_string_lossy().into_owned()
}

/// Asserts that every block of the alias is what the program prints.
pub fn compare(alias: &str, program: &str) {
    let mut compared = 0;
    for (path, document) in documents() {
        for (words, text) in blocks(&document, alias) {
            let name = name(&path);
            assert_eq!(
                text,
                printed(program, words),
                "{name}: cargo {alias} {words}: sh docs/make {}",
                name.trim_end_matches(".md").to_lowercase()
            );
            compared += 1;
        }
    }
    assert!(compared > 0, "no document holds a block of cargo {alias}");
}
