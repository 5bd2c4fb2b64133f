//! `inspect REC…`: why a scan came out as it did.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Result, ensure};
use stairscan::config::EstimatorKind;

use super::{Format, Settings, emit};
use crate::inspect::Inspection;
use crate::plots::{self, PaperView, ScanView};
use crate::recording::Recording;
use crate::replay;
use crate::setup;

/// Arguments of `inspect`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Recordings, with or without suffix
    #[arg(required = true)]
    recordings: Vec<PathBuf>,
    #[command(flatten)]
    settings: Settings,
    /// Draw scatterers, winner and rivals into this directory, one picture a recording
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    /// How to print
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Shows every recording; a bad one makes the exit status 1 and the rest goes on.
pub fn run(args: &Args) -> Result<ExitCode> {
    let mut code = ExitCode::SUCCESS;
    for path in &args.recordings {
        if let Err(error) = inspect(path, args) {
            eprintln!("error: {error:#}");
            code = ExitCode::FAILURE;
        }
    }
    Ok(code)
}

fn inspect(path: &std::path::Path, args: &Args) -> Result<()> {
    let options = args.settings.options(args.settings.config()?);
    ensure!(
        options.config.estimator == EstimatorKind::Likelihood,
        "--estimator: inspect looks over the shoulder of {} only",
        EstimatorKind::Likelihood.as_str()
    );
    let recording = Recording::read(path)?;
    let (config, _) = setup::config(&recording, &options.config)?;
    let mut drawn = Ok(());
    replay::answers(&recording, &options, |pipeline, answer| {
        let map = pipeline.map();
        let inspection = Inspection::of(map, &config, answer.scan.scan);
        match args.format {
            Format::Json => emit(&format!("{}\n", inspection.json(&recording.name))),
            Format::Text => emit(&format!("{}\n{}\n", recording.name, inspection.text())),
        }
        if let Some(dir) = &args.plots {
            let scan = ScanView {
                recording: &recording,
                config: &config,
                map,
                answer,
                paper: &PaperView::default(),
            };
            let file = dir.join(format!("{}-inspect.png", recording.name));
            drawn = plots::write_inspect(&file, &scan, inspection.view());
            if let (Ok(()), Format::Text) = (&drawn, args.format) {
                emit(&format!("picture\n  {}\n\n", file.display()));
            }
        }
    })?;
    drawn
}
