//! `replay REC…`: recorded scans through the scanner's own loop.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Result;
use stairscan::config::Config;
use stairscan::pipeline::Pipeline;

use super::{Format, Settings, emit};
use crate::answer::Answer;
use crate::plots::{self, PaperView, ScanView};
use crate::recording::Recording;
use crate::replay;
use crate::setup;

/// Arguments of `replay`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Recordings, with or without suffix
    #[arg(required = true)]
    recordings: Vec<PathBuf>,
    #[command(flatten)]
    settings: Settings,
    /// Scans one after the other, each the other way round
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    scans: u32,
    /// Turn the mirror from the last angle to the first
    #[arg(long)]
    backwards: bool,
    /// Draw what the paper's figures show of each recording's first scan into this directory
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    /// How to print
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Scans every recording; a bad one or a fault makes the exit status 1 and the rest goes on.
pub fn run(args: &Args) -> Result<ExitCode> {
    let options = replay::Options {
        scans: args.scans,
        backwards: args.backwards,
        ..args.settings.options(args.settings.config()?)
    };
    let mut code = ExitCode::SUCCESS;
    for path in &args.recordings {
        let mut pictures = None;
        let answers = Recording::read(path).and_then(|recording| {
            replay::answers(&recording, &options, |pipeline, answer| {
                if let (Some(dir), None) = (&args.plots, &pictures) {
                    pictures = Some(draw(dir, &recording, &options.config, pipeline, answer));
                }
            })
        });
        let mut shown = true;
        match answers {
            Ok(answers) => answers
                .into_iter()
                .for_each(|a| shown &= show(Ok(a), args.format)),
            Err(error) => shown = show(Err(error), args.format),
        }
        shown &= pictures.is_none_or(|pictures| list(pictures, args.format));
        if !shown {
            code = ExitCode::FAILURE;
        }
    }
    Ok(code)
}

/// Draws a scan's pictures.
fn draw(
    dir: &Path,
    recording: &Recording,
    base: &Config,
    pipeline: &Pipeline,
    answer: &Answer,
) -> Result<Vec<PathBuf>> {
    let (config, _) = setup::config(recording, base)?;
    let scan = ScanView {
        recording,
        config: &config,
        map: pipeline.map(),
        answer,
        paper: &PaperView::of(pipeline.map(), &config, answer.scan.scan),
    };
    plots::write_scan(dir, &scan)
}

/// Lists the pictures for people, or prints why there are none; whether there are.
fn list(pictures: Result<Vec<PathBuf>>, format: Format) -> bool {
    match pictures {
        Ok(files) => {
            if format == Format::Text {
                let lines = files.iter().map(|f| format!("  {}\n", f.display()));
                emit(&format!("pictures\n{}\n", lines.collect::<String>()));
            }
            true
        }
        Err(error) => {
            eprintln!("error: {error:#}");
            false
        }
    }
}

/// Prints an answer or the error; whether it was an answer and no fault.
pub fn show(answer: Result<Answer>, format: Format) -> bool {
    match answer {
        Ok(answer) => {
            match format {
                Format::Json => emit(&format!("{}\n", answer.json())),
                Format::Text => emit(&format!("{}\n", answer.text())),
            }
            !answer.is_fault()
        }
        Err(error) => {
            eprintln!("error: {error:#}");
            false
        }
    }
}
