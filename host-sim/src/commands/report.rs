//! `report REC… -o FILE`: writes scans as one page for any browser; with `--compare` two of them side by side.

mod sides;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Result, ensure};
use rayon::prelude::*;
use stairscan::config::Config;

use self::sides::{Set, Wanted, sides};
use super::{Settings, emit, logs, progress, recordings};
use crate::html::compare::{Comparison, compare};
use crate::html::{self, Entry, Rank};
use crate::live::log::Log;
use crate::output::{Outputs, Overwrite};
use crate::recording::{Recording, meta_path, name_of};
use crate::replay::{Options, SEED};

/// Arguments of `report`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Recordings, with or without suffix, or logs of sentences, or directories of either
    #[arg(required = true)]
    recordings: Vec<PathBuf>,
    /// Output file; without it named after the recordings and what is compared, such as stair_a.html, in this directory
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Treat every scan of a recording as if it were the first
    #[arg(long)]
    single: bool,
    /// Compare two recordings, or one recording under two settings, differences first. Of one recording --estimator,
    /// --seed and --single apply to the second side, and the first has the defaults
    #[arg(long)]
    compare: bool,
    /// Settings of the second side, with keys and units as in `cargo sim settings`; given twice, those of the first and
    /// of the second side
    #[arg(long, value_name = "KEY=VALUE,…", requires = "compare")]
    with: Vec<Set>,
    #[command(flatten)]
    settings: Settings,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Writes all scans as one page. A recording that cannot be read is listed with the cause, and sets the exit status to
/// 1.
pub fn run(args: &Args) -> Result<ExitCode> {
    let options = Options {
        single: args.single,
        ..args.settings.options(args.settings.config()?)
    };
    if let Some(logs) = logs::all(&args.recordings)? {
        ensure!(!args.compare, "--compare: expected recordings, found logs");
        return of_logs(args, &logs);
    }
    let paths = recordings(&args.recordings)?;
    let outputs = args.overwrite.reading(&paths);
    let file = args.output.clone().unwrap_or_else(|| own_name(args));
    outputs.check_kind(&file, &["html", "htm"])?;
    outputs.ready(&file)?;
    if args.compare {
        return beside(args, &options, &paths, (&outputs, &file));
    }
    let bar = progress(paths.len() as u64);
    let entries: Vec<Entry> = paths
        .par_iter()
        .map(|path| {
            let entry = Recording::read(path).and_then(|r| html::entry(&r, &options));
            bar.inc(1);
            entry.unwrap_or_else(|error| html::failed(&name_of(path), &format!("{error:#}")))
        })
        .collect();
    bar.finish_and_clear();
    let mut unreadable = false;
    for entry in entries.iter().filter(|e| e.rank == Rank::Unreadable) {
        unreadable = true;
        crate::note!("error: {}", entry.data["error"].as_str().unwrap_or(""));
    }
    if entries.iter().all(|e| e.rank == Rank::Unreadable) {
        // A page without a scan would only be in the way of the next try.
        return Ok(ExitCode::FAILURE);
    }
    let page = html::page(entries)?;
    emit(&save(&outputs, &file, &page, "")?);
    Ok(if unreadable {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    })
}

/// Writes a page that holds also what `with` says, and returns a line that tells where it is.
pub fn save(outputs: &Outputs, file: &Path, page: &str, with: &str) -> Result<String> {
    outputs.write(file, page.as_bytes())?;
    Ok(format!(
        "{} ({} KB){with}: open it in a browser\n",
        file.display(),
        page.len().div_ceil(1000)
    ))
}

/// Writes the page of logs: answers over time.
fn of_logs(args: &Args, logs: &[Log]) -> Result<ExitCode> {
    let outputs = args.overwrite.reading(&args.recordings);
    let file = args.output.clone().unwrap_or_else(|| own_name(args));
    outputs.check_kind(&file, &["html", "htm"])?;
    let page = html::logged(logs)?;
    emit(&save(&outputs, &file, &page, "")?);
    Ok(ExitCode::SUCCESS)
}

/// Writes the page that compares two sides, and prints the differences.
fn beside(
    args: &Args,
    options: &Options,
    paths: &[PathBuf],
    (outputs, file): (&Outputs, &Path),
) -> Result<ExitCode> {
    let defaults = defaults();
    let sides = sides(&Wanted {
        paths,
        given: (*options, words(args, &defaults)),
        defaults,
        sets: &args.with,
    })?;
    let Comparison { page, differences } = compare(&sides)?;
    let saved = save(outputs, file, &page, "")?;
    let [first, second] = sides.each_ref().map(|side| &side.name);
    let mut text = format!("{first} | {second}\n");
    for row in &differences {
        text += &format!("  {}\n", row.text());
    }
    if differences.is_empty() {
        text += "  nothing differs\n";
    }
    emit(&(text + &saved));
    Ok(ExitCode::SUCCESS)
}

/// Returns the options of a scan without any on the command line.
fn defaults() -> Options {
    Options {
        config: Config {
            seed: SEED,
            ..Config::default()
        },
        ..Options::default()
    }
}

/// Returns the name of a recording or directory, without a suffix of recordings.
pub fn plain_name(path: &Path) -> String {
    let path: PathBuf = path.components().collect();
    let name = name_of(&meta_path(&path));
    match name.trim_matches('.') {
        "" => "scans".to_owned(),
        name => name.to_owned(),
    }
}

/// Returns the name of a page without `--output`: the recordings or directories, and the options that differ from the
/// defaults, so that pages of different commands have different names.
fn own_name(args: &Args) -> PathBuf {
    let mut parts: Vec<String> = match args.recordings.as_slice() {
        [first, _, _, .., last] => vec![plain_name(first), "to".into(), plain_name(last)],
        few => few.iter().map(|path| plain_name(path)).collect(),
    };
    parts.extend(args.compare.then(|| "compared".to_owned()));
    parts.extend(args.with.iter().map(|set| set.words().to_owned()));
    parts.push(words(args, &defaults()));
    let plain = |c: char| {
        if c.is_alphanumeric() || "_.=".contains(c) {
            c
        } else {
            '-'
        }
    };
    let parts = parts.iter().filter(|part| !part.is_empty());
    let name: Vec<String> = parts
        .map(|part| part.chars().map(plain).collect())
        .collect();
    PathBuf::from(format!("{}.html", name.join("-")))
}

/// Returns the command line's options for scanning that differ from the defaults, in the syntax of `--with`.
fn words(args: &Args, defaults: &Options) -> String {
    let (name, seed) = (args.settings.estimator_name(), args.settings.seed());
    let all = [
        (name != defaults.config.estimator.as_str()).then(|| format!("estimator={name}")),
        (seed != defaults.config.seed).then(|| format!("seed={seed}")),
        args.single.then(|| "single".to_owned()),
    ];
    all.into_iter().flatten().collect::<Vec<_>>().join(", ")
}
