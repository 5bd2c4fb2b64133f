//! `report REC… -o FILE`: scans as one page for any browser.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use rayon::prelude::*;

use super::{Settings, emit, progress, recordings};
use crate::html::{self, Entry, Rank};
use crate::output::Overwrite;
use crate::recording::{Recording, name_of};
use crate::replay::Options;

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
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Writes the page. A recording that cannot be read stands in it with its reason, and makes the exit status 1.
pub fn run(args: &Args) -> Result<ExitCode> {
    let options = Options {
        single: args.single,
        ..args.settings.options(args.settings.config()?)
    };
    let paths = recordings(&args.recordings)?;
    let outputs = args.overwrite.reading(&paths);
    outputs.check(&args.output)?;
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
        eprintln!("error: {}", entry.data["error"].as_str().unwrap_or(""));
    }
    let page = html::page(entries)?;
    outputs.write(&args.output, page.as_bytes())?;
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
