//! The C sources, compiled, and lines through a pipe.

use std::collections::BTreeMap;
use std::io::{self, BufRead, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;

use anyhow::{Context, Result, bail, ensure};

use super::lines::{Lines, corpus};
use super::{Way, directory, oracle};

/// What every compilation asks for.
const FLAGS: [&str; 9] = [
    "-std=c99",
    "-O1",
    "-g",
    "-Wall",
    "-Wextra",
    "-Werror",
    "-pedantic",
    "-Wconversion",
    "-Wshadow",
];
/// Undefined behaviour and bytes out of bounds end the program.
const SANITIZERS: [&str; 2] = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"];

/// The C compiler: what `CC` says, or `cc`; none where it is not there.
pub fn compiler() -> Option<String> {
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let mut ask = Command::new(&compiler);
    ask.arg("--version")
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let there = ask.status().is_ok_and(|status| status.success());
    there.then_some(compiler)
}

/// Compiles `source` of `controller/` with the parser into `into`, with the sanitizers or without.
///
/// # Errors
/// What the compiler says.
pub fn compile(compiler: &str, source: &str, into: &Path, sanitized: bool) -> Result<PathBuf> {
    let name = Path::new(source).file_stem().context("no name")?;
    let program = into.join(name);
    let output = Command::new(compiler)
        .current_dir(directory())
        .args(FLAGS)
        .args(SANITIZERS.iter().filter(|_| sanitized))
        .args(["stairscan.c", source, "-o"])
        .arg(&program)
        .output()
        .with_context(|| compiler.to_owned())?;
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "{compiler} {source}: {said}");
    Ok(program)
}

/// Returns what a program prints, called with `arguments`.
///
/// # Errors
/// An exit status other than 0, with both of its outputs.
pub fn printed(program: &Path, arguments: &[&str]) -> Result<String> {
    let output = Command::new(program)
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .with_context(|| program.display().to_string())?;
    let text = String::from_utf8(output.stdout)?;
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(
        output.status.success(),
        "{}: {text}{said}",
        program.display()
    );
    Ok(text)
}

/// How often each verdict came: a kind of sentence or command, or what was wrong.
pub type Tally = BTreeMap<String, u64>;

/// Feeds `count` mutated lines to the C program at `verdict`, and compares what it says of each with what the
/// Rust parsers say.
///
/// # Errors
/// The first line on which they differ, or how the program ended.
pub fn agree(verdict: &Path, count: usize, seed: u64) -> Result<Tally> {
    let corpus = corpus();
    let lines = || Lines::new(&corpus, seed).take(count);
    let mut child = Command::new(verdict)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .with_context(|| verdict.display().to_string())?;
    let input = child.stdin.take().context("no standard input")?;
    let output = child.stdout.take().context("no standard output")?;
    let tally = thread::scope(|scope| {
        // A program that ends early is told by what it did not say.
        scope.spawn(move || feed(input, lines()));
        compare(BufReader::new(output), lines())
    });
    let ended = child.wait()?;
    let tally = tally?;
    ensure!(ended.success(), "{}: {ended}", verdict.display());
    Ok(tally)
}

fn feed(pipe: impl Write, lines: impl Iterator<Item = (Way, Vec<u8>)>) -> io::Result<()> {
    let mut pipe = BufWriter::new(pipe);
    for (way, line) in lines {
        let length = u16::try_from(line.len()).map_err(io::Error::other)?;
        pipe.write_all(&[way.letter() as u8])?;
        pipe.write_all(&length.to_le_bytes())?;
        pipe.write_all(&line)?;
    }
    pipe.flush()
}

fn compare(said: impl BufRead, lines: impl Iterator<Item = (Way, Vec<u8>)>) -> Result<Tally> {
    let mut said = said.split(b'\n');
    let mut tally = Tally::new();
    for (number, (way, line)) in (1..).zip(lines) {
        let Some(found) = said.next().transpose()? else {
            bail!(
                "the program ended at line {number}: {}",
                line.escape_ascii()
            );
        };
        let expected = oracle::verdict(way, &line);
        if found != expected.as_bytes() {
            let found = found.escape_ascii();
            let line = line.escape_ascii();
            bail!("{way:?} line {number}: {line}\n  Rust: {expected}\n  C:    {found}");
        }
        *tally.entry(kind(&expected)).or_default() += 1;
    }
    Ok(tally)
}

/// The first word of a verdict; all words of one that says what is wrong.
fn kind(verdict: &str) -> String {
    let words = if verdict.starts_with("bad ") { 4 } else { 1 };
    let words: Vec<&str> = verdict.split(' ').take(words).collect();
    words.join(" ")
}
