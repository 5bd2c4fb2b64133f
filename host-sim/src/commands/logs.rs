//! Logs of a scanner's sentences as inputs of commands, in place of recordings.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use stairscan::report::GuardLine;

use crate::convert::scans::{SECOND_NS, Scan};
use crate::convert::suffix;
use crate::counted::counted;
use crate::guarded::Guarded;
use crate::live::log::{self, Log, Logged};
use crate::recording::{self, DATA_SUFFIX, META_SUFFIX, regular};

/// Suffixes of files that are no logs.
const OTHERS: [&str; 7] = [
    META_SUFFIX,
    DATA_SUFFIX,
    "npy",
    "npz",
    "bin",
    "toml",
    "html",
];
/// Suffixes of the logs in a directory: those of `live --record`, of `record`, and of most loggers.
const IN_DIRECTORIES: [&str; 3] = ["txt", "log", "sentences"];

/// Whether a path is a file that may be a log: not a recording, nor named like one.
fn is_file(path: &Path) -> bool {
    path.is_file() && !OTHERS.contains(&suffix(path)) && !is_recording(path)
}

/// Returns the bytes of the log `path`; `None` if it is none, as a recording.
fn bytes(path: &Path) -> Result<Option<Vec<u8>>> {
    if !is_file(path) {
        return Ok(None);
    }
    let bytes = fs::read(path).with_context(|| path.display().to_string())?;
    // Named like a log, it is one, and what it lacks is explained.
    let named = IN_DIRECTORIES.contains(&suffix(path));
    Ok((named || log::may_be(&bytes)).then_some(bytes))
}

/// Reads the log `path`; `None` if it is a recording.
///
/// # Errors
/// The file cannot be read, or has no sentence of a scanner.
pub fn read(path: &Path) -> Result<Option<Log>> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let log = bytes(path)?.map(|bytes| Log::read(&name, &bytes));
    log.transpose()
}

/// Reads the log `path`, which must be one.
///
/// # Errors
/// The file is missing, for which the message has the system's reason, or of another kind, which the message names;
/// those of [`read`].
pub fn expect(path: &Path) -> Result<Log> {
    let log = read(path)?;
    log.map_or_else(|| other(path, "a log of sentences"), Ok)
}

/// Explains a path that [`read`] takes for no log, where `expected` was expected.
///
/// # Errors
/// Always: what the path is instead.
pub fn other(path: &Path, expected: &str) -> Result<Log> {
    let name = path.display();
    ensure!(
        !is_recording(path),
        "{name}: a recording, expected {expected}"
    );
    let found = fs::metadata(path).with_context(|| name.to_string())?;
    ensure!(!found.is_dir(), "{name}: a directory, expected {expected}");
    regular(path)?;
    let suffix = suffix(path);
    ensure!(
        !OTHERS.contains(&suffix),
        "{name}: a .{suffix}, expected {expected}"
    );
    let bytes = fs::read(path).with_context(|| name.to_string())?;
    Log::read(&name.to_string(), &bytes)
}

/// Whether a path names the files of a recording that is there.
pub fn is_recording(path: &Path) -> bool {
    recording::meta_path(path).is_file()
}

/// Returns the logs that `paths` name, those of a directory without recordings in order; `None` if they are recordings.
///
/// # Errors
/// A file cannot be read, has no sentence of a scanner, or stands beside recordings.
pub fn all(paths: &[PathBuf]) -> Result<Option<Vec<Log>>> {
    let (mut logs, mut others) = (Vec::new(), Vec::new());
    for path in paths {
        if path.is_dir() && recording::list(path).is_err() {
            let entries = fs::read_dir(path).with_context(|| path.display().to_string())?;
            let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
            files.retain(|file| IN_DIRECTORIES.contains(&suffix(file)));
            files.sort();
            let before = logs.len();
            let mut unread = Vec::new();
            for file in files {
                match read(&file) {
                    Ok(log) => logs.extend(log),
                    Err(error) => unread.push(error),
                }
            }
            unread
                .iter()
                .for_each(|error| crate::note!("skipped: {error:#}"));
            ensure!(
                logs.len() > before || unread.is_empty(),
                "{}: no log with a sentence",
                path.display()
            );
        } else if let Some(log) = read(path)? {
            logs.push(log);
        } else {
            others.push(path);
        }
    }
    if let (Some(log), Some(other)) = (logs.first(), others.first()) {
        if !is_recording(other) && !other.is_dir() {
            self::other(other, "a log of sentences")?;
        }
        bail!(
            "{}: a recording, and {} a log of sentences: expected one kind",
            other.display(),
            log.name
        );
    }
    Ok((!logs.is_empty()).then_some(logs))
}

/// Returns the answers of a log, with their times: since 1970 if the log has dates, else since its beginning.
///
/// # Errors
/// The log has no complete answer.
pub fn scans(log: &Log) -> Result<Vec<Scan>> {
    let begun_ms = log.begun_ms.unwrap_or(0);
    let answers = log.answers();
    let sweeps = match log.sweeps().count() {
        0 => "no guard sweep".to_owned(),
        some => format!(
            "{}: cargo sim convert -o FILE.mcap, or --table sweeps -o FILE.csv",
            counted(some, "guard sweep")
        ),
    };
    ensure!(
        !answers.is_empty(),
        "{}: no complete answer in {} lines ({sweeps})",
        log.name,
        log.lines.len()
    );
    let scan = |(at, answer)| Scan::from_sentences(&answer, (begun_ms + at) * (SECOND_NS / 1000));
    Ok(answers.into_iter().map(scan).collect())
}

/// Returns the guard sweeps of a log, with their times, ns, as [`scans`] counts them.
///
/// # Errors
/// The log has no guard sweep.
pub fn sweeps(log: &Log) -> Result<Vec<(u64, Guarded)>> {
    let begun_ms = log.begun_ms.unwrap_or(0);
    let sweep = |(line, contents): (&Logged, GuardLine)| {
        let stamp_ns = (begun_ms + line.at) * (SECOND_NS / 1000);
        let guarded = Guarded {
            recording: log.name.clone(),
            sentence: line.text.clone(),
            sweep: contents.sweep,
            line: contents,
        };
        (stamp_ns, guarded)
    };
    let sweeps: Vec<_> = log.sweeps().map(sweep).collect();
    ensure!(
        !sweeps.is_empty(),
        "{}: --table sweeps: no guard sweep in {} lines",
        log.name,
        log.lines.len()
    );
    Ok(sweeps)
}
