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

/// Returns the commands of `program` in the running text of a document: in backquotes, with their arguments, without pipes.
pub fn inline_commands(document: &str, program: &str) -> Vec<String> {
    let (mut text, mut fenced) = (String::new(), false);
    for line in document.lines().map(str::trim) {
        if line.starts_with("```") {
            fenced = !fenced;
        } else if !fenced {
            // An odd backquote reaches to the end of its paragraph only.
            text += if line.is_empty() { "\n" } else { " " };
            text += line;
        }
    }
    let quoted = text
        .lines()
        .flat_map(|paragraph| paragraph.split('`').skip(1).step_by(2));
    let own = quoted.filter_map(|code| code.strip_prefix(program)?.strip_prefix(' '));
    // A table's pipe has a backslash before it.
    own.map(|words| {
        let end = [" |", " \\|"].iter().filter_map(|pipe| words.find(pipe));
        words[..end.min().unwrap_or(words.len())].to_owned()
    })
    .collect()
}

/// Returns why `program` does not take the words of a command in running text; `None` if it does. Such text may name a
/// command without all its arguments.
pub fn refusal(program: &clap::Command, words: &str) -> Option<clap::Error> {
    use clap::error::ErrorKind;

    let all = [program.get_name()]
        .into_iter()
        .chain(words.split_whitespace());
    let error = program.clone().try_get_matches_from(all).err()?;
    let short = matches!(
        error.kind(),
        ErrorKind::MissingRequiredArgument
            | ErrorKind::MissingSubcommand
            | ErrorKind::DisplayHelp
            | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
    );
    (!short).then_some(error)
}

/// Asserts that `program` takes every command in running text that begins with one of `names`, except those that begin
/// with an entry of `not_checked`; and that each entry stands in a document. Returns the number of commands.
pub fn check_inline(
    program: &clap::Command,
    names: &[&str],
    not_checked: &[(&str, &str)],
) -> usize {
    let (mut count, mut left) = (0, Vec::new());
    let mut failures = Vec::new();
    for (path, text) in instructions() {
        for words in names.iter().flat_map(|name| inline_commands(&text, name)) {
            let entry = not_checked
                .iter()
                .position(|(begin, _)| words.starts_with(begin));
            left.extend(entry);
            if entry.is_some() {
                continue;
            }
            count += 1;
            let refused = refusal(program, &words);
            failures.extend(refused.map(|error| format!("{}: `{words}`: {error}", path.display())));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    for (k, (begin, why)) in not_checked.iter().enumerate() {
        assert!(
            !why.is_empty() && left.contains(&k),
            "{begin}: in no document"
        );
    }
    count
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
