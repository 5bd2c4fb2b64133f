//! Compiles the C sources and sends them lines through a pipe.

use std::collections::BTreeMap;
use std::io::{self, BufRead, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;

use anyhow::{Context, Result, bail, ensure};

use super::lines::{Lines, corpus};
use super::{Way, directory, oracle};

/// Compiler flags of every compilation.
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
/// Sanitizers that end the program at undefined behaviour and out-of-bounds accesses.
const SANITIZERS: [&str; 2] = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"];

/// Returns the C compiler: `CC`, or `cc`; `None` if it is not installed.
pub fn compiler() -> Option<String> {
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let mut ask = Command::new(&compiler);
    ask.arg("--version")
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let there = ask.status().is_ok_and(|status| status.success());
    there.then_some(compiler)
}

/// Compiles `source` of `controller/` with the parser into `into`, with or without the sanitizers.
///
/// # Errors
/// The compiler's error message.
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

/// Returns the output of a program called with `arguments`.
///
/// # Errors
/// The exit status is not 0; the message contains both outputs.
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

/// Number of lines by verdict: a kind of sentence or command, or an error.
pub type Tally = BTreeMap<String, u64>;

/// Sends `count` mutated lines to the C program at `verdict`, and compares its verdict on each with the Rust
/// parsers'.
///
/// # Errors
/// The first line with a difference, or the program's exit status.
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
        // If a program ends early, the missing output shows it.
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

/// Returns the first word of a verdict; for an error all of its words.
fn kind(verdict: &str) -> String {
    let words = if verdict.starts_with("bad ") { 4 } else { 1 };
    let words: Vec<&str> = verdict.split(' ').take(words).collect();
    words.join(" ")
}
