//! `report REC… -o FILE`: scans as one page for any browser.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Result;
use rayon::prelude::*;

use super::{Settings, emit, progress, recordings};
use crate::html::{self, Entry, Rank};
use crate::playback::Playback;
use crate::recording::{Recording, write_whole};
use crate::replay::{self, Options};

/// Arguments of `report`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Recordings, with or without suffix, or directories of them
    #[arg(required = true)]
    recordings: Vec<PathBuf>,
    /// The page
    #[arg(short, long, value_name = "FILE", default_value = "scan.html")]
    output: PathBuf,
    /// Treat every scan of a recording as if it were the first
    #[arg(long)]
    single: bool,
    #[command(flatten)]
    settings: Settings,
}

/// Writes the page. A recording that cannot be read stands in it with its reason, and makes the exit status 1.
pub fn run(args: &Args) -> Result<ExitCode> {
    let options = Options {
        single: args.single,
        ..args.settings.options(args.settings.config()?)
    };
    let paths = recordings(&args.recordings)?;
    let bar = progress(paths.len() as u64);
    let entries: Vec<Entry> = paths
        .par_iter()
        .map(|path| {
            let entry = entry(path, &options);
            bar.inc(1);
            entry.unwrap_or_else(|error| html::failed(&name(path), &format!("{error:#}")))
        })
        .collect();
    bar.finish_and_clear();
    let mut unreadable = false;
    for entry in entries.iter().filter(|e| e.rank == Rank::Unreadable) {
        unreadable = true;
        eprintln!("error: {}", entry.data["error"].as_str().unwrap_or(""));
    }
    let page = html::page(entries)?;
    write_whole(&args.output, page.as_bytes())?;
    emit(&format!(
        "{} ({} KB): open it in a browser\n",
        args.output.display(),
        page.len().div_ceil(1000)
    ));
    Ok(if unreadable {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    })
}

/// What the page shows of the recording at `path`.
fn entry(path: &Path, options: &Options) -> Result<Entry> {
    let recording = Recording::read(path)?;
    let settings = Playback::new(&recording, &options.config)?.settings();
    let mut scans = Vec::new();
    replay::answers(&recording, options, |scanned| {
        scans.push(html::scan(scanned));
    })?;
    Ok(html::recording(&recording, &settings, scans))
}

/// A path's base name without suffix.
fn name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or(path.as_os_str());
    stem.to_string_lossy().into_owned()
}
