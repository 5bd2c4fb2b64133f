//! Tests that documents contain the current output of the commands that they name.

use std::path::Path;
use std::process::Command;

use walkdir::WalkDir;

/// Returns the directory of the repository.
fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Returns the standard output of `cargo sim WORDS`, run in the repository.
fn printed(words: &str) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .args(words.split(' '))
        .current_dir(root())
        .output()
        .unwrap();
    assert!(output.status.success(), "cargo sim {words}: {output:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// Returns the blocks of a document that a command prints: its arguments, and the block between `<!--
/// text: cargo sim WORDS -->` and `<!-- end -->`.
fn blocks(document: &str) -> Vec<(&str, &str)> {
    let mut parts = document.split("<!-- text: cargo sim ");
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

#[test]
fn blocks_of_text_are_what_their_commands_print() {
    let documents = WalkDir::new(root().join("docs")).max_depth(1).into_iter();
    let documents = documents.map(|entry| entry.unwrap().into_path());
    let readme = root().join("README.md");
    let mut compared = 0;
    for path in documents.chain([readme]) {
        if path.extension().is_none_or(|suffix| suffix != "md") {
            continue;
        }
        let document = std::fs::read_to_string(&path).unwrap();
        for (words, text) in blocks(&document) {
            let name = path.file_name().unwrap().to_string_lossy();
            assert_eq!(
                text,
                printed(words),
                "{name}: cargo sim {words}: sh docs/make {}",
                name.trim_end_matches(".md").to_lowercase()
            );
            compared += 1;
        }
    }
    assert!(compared > 0, "no document holds a block");
}
