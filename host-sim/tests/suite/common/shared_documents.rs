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

/// Every Markdown file of the repository that tells people what to type: README, CONTRIBUTING, `docs/` and the READMEs
/// of folders.
pub fn instructions() -> Vec<(PathBuf, String)> {
    let mut all = documents();
    let folders = std::fs::read_dir(root()).unwrap();
    let mut more: Vec<PathBuf> = folders
        .map(|entry| entry.unwrap().path().join("README.md"))
        .filter(|path| path.is_file())
        .chain([root().join("CONTRIBUTING.md")])
        .collect();
    more.sort();
    let known = |path: &PathBuf| all.iter().any(|(other, _)| other == path);
    more.retain(|path| !known(path));
    all.extend(more.into_iter().map(|path| {
        let text = std::fs::read_to_string(&path).unwrap();
        (path, text)
    }));
    all
}

/// First words of commands in blocks that are indented only.
const PROGRAMS: &[&str] = &[
    "cargo ", "sh ", "bash ", "git ", "chip/", "./", "APPROVE=", "VERBOSE=",
];

/// Returns the commands that a document prints in blocks: those of shell, and indented lines that begin with a program;
/// continued lines joined.
pub fn commands(document: &str) -> Vec<String> {
    let (mut found, mut fence): (Vec<String>, Option<bool>) = (Vec::new(), None);
    let mut continued = false;
    for line in document.lines() {
        let text = line.trim();
        if let Some(language) = text.strip_prefix("```") {
            fence = fence.is_none().then_some(language == "sh");
            continue;
        }
        let indented = line.starts_with("    ") && PROGRAMS.iter().any(|p| text.starts_with(p));
        if text.is_empty() || !(fence == Some(true) || fence.is_none() && (indented || continued)) {
            continue;
        }
        let (part, more) = text
            .strip_suffix('\\')
            .map_or((text, false), |part| (part, true));
        match found.last_mut().filter(|_| continued) {
            Some(last) => last.push_str(part),
            None => found.push(part.to_owned()),
        }
        continued = more;
    }
    found
}

/// Returns the words of the commands of `cargo ALIAS` in all blocks, without comments and pipes.
pub fn commands_of(alias: &str) -> Vec<Vec<String>> {
    let mark = format!("cargo {alias} ");
    let all = instructions()
        .into_iter()
        .flat_map(|(_, text)| commands(&text));
    let own = all.filter_map(|line| Some(line.strip_prefix(&mark)?.to_owned()));
    own.map(|line| {
        let end = [" #", " |"].iter().filter_map(|end| line.find(end)).min();
        let words = line[..end.unwrap_or(line.len())].split_whitespace();
        words.map(str::to_owned).collect()
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
