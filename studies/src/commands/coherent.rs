//! `coherent REC…`: top edges that the echoes show, and ground that the coherent image shows, on recordings with truth.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Result, ensure};
use host_sim::recording::Recording;
use host_sim::replay::{self, Options};
use host_sim::setup::{self, Kind};

use super::{emit, progress_aside, recordings};
use crate::coherent::Counts;

/// Arguments of `coherent`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Recordings with ground truth, with or without suffix, or directories of them
    #[arg(required = true)]
    recordings: Vec<PathBuf>,
}

/// Prints what the coherent image of the recordings shows.
pub fn run(args: &Args) -> Result<ExitCode> {
    let paths = recordings(&args.recordings)?;
    let mut counts = Counts::default();
    let bar = progress_aside(paths.len() as u64);
    for path in &paths {
        bar.inc(1);
        let recording = Recording::read(path)?;
        if setup::kind(&recording)? == Kind::Guard {
            continue;
        }
        let options = Options {
            scans: Some(1),
            coherent: true,
            ..Options::default()
        };
        replay::answers(&recording, &options, |scanned| counts.add(scanned))?;
    }
    bar.finish_and_clear();
    ensure!(
        !counts.is_empty(),
        "no recording of the depth plane with ground truth"
    );
    emit(&counts.text());
    Ok(ExitCode::SUCCESS)
}
