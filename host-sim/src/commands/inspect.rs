//! `inspect REC…`: shows how the estimator came to its answer.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Result, ensure};
use stairscan::config::EstimatorKind;

use super::{Format, Settings, emit, progress_aside, recordings};
use crate::coherent::CoherentView;
use crate::counted::counted;
use crate::inspect::Inspection;
use crate::output::{Outputs, Overwrite};
use crate::plots::{self, PaperView, ScanView};
use crate::recording::Recording;
use crate::replay::{self, Scanned};

/// Arguments of `inspect`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Recordings, with or without suffix, or directories of them
    #[arg(required = true)]
    recordings: Vec<PathBuf>,
    #[command(flatten)]
    settings: Settings,
    /// Treat every scan of a recording as if it were the first
    #[arg(long)]
    single: bool,
    /// Show the coherent image and its echoes, too
    #[arg(long)]
    coherent: bool,
    /// Draw scatterers, best hypothesis and runners-up into this directory, one picture a scan
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Prints for every recording how its answers came about. A bad recording sets the exit status to 1; the others are
/// still shown.
pub fn run(args: &Args) -> Result<ExitCode> {
    let mut code = ExitCode::SUCCESS;
    let paths = recordings(&args.recordings)?;
    let outputs = args.overwrite.reading(&paths);
    let bar = progress_aside(paths.len() as u64);
    for path in &paths {
        bar.inc(1);
        if let Err(error) = inspect(path, args, &outputs) {
            crate::note!("error: {error:#}");
            code = ExitCode::FAILURE;
        }
    }
    bar.finish_and_clear();
    Ok(code)
}

fn inspect(path: &std::path::Path, args: &Args, outputs: &Outputs) -> Result<()> {
    let options = replay::Options {
        single: args.single,
        coherent: args.coherent,
        ..args.settings.options(args.settings.config()?)
    };
    ensure!(
        options.config.estimator == EstimatorKind::Likelihood,
        "--estimator: inspect supports only {}",
        EstimatorKind::Likelihood.as_str()
    );
    let recording = Recording::read(path)?;
    let chirps = recording.meta.chirps_per_row.filter(|&n| n > 1);
    let mut drawn = Ok(());
    replay::answers(&recording, &options, |scanned| {
        let Scanned {
            config,
            pipeline,
            answer,
            ..
        } = *scanned;
        let map = pipeline.map();
        let inspection = Inspection::of(scanned);
        let coherent = CoherentView::of(scanned);
        match args.format {
            Format::Json => {
                let mut json = inspection.json(answer);
                if let Some(chirps) = chirps {
                    json["chirps_per_row"] = chirps.into();
                }
                if let Some(view) = &coherent {
                    json["coherent"] = view.json();
                }
                emit(&format!("{json}\n"));
            }
            Format::Text => {
                let chirps = chirps.map_or(String::new(), |n| {
                    format!("{} per row; ", counted(n, "chirp"))
                });
                emit(&format!(
                    "{}\n{chirps}{}\n",
                    answer.name(),
                    inspection.text(answer)
                ));
                if let Some(view) = &coherent {
                    emit(&format!("{}\n", view.text()));
                }
            }
        }
        if let (Some(dir), Ok(())) = (&args.plots, &drawn) {
            let recording = &scanned.recording();
            let paper = &PaperView::default();
            let scan = ScanView {
                recording,
                config,
                map,
                answer,
                paper,
                posterior: &inspection.view().posterior,
            };
            let file = dir.join(format!("{}-inspect.png", recording.name));
            drawn = plots::write_inspect((outputs, &file), &scan, inspection.view());
            let mut files = vec![file];
            if let (Some(view), Ok(())) = (&coherent, &drawn) {
                let (image, name) = (&view.map(), &recording.name);
                match plots::write_coherent((outputs, dir), name, (map, image), &view.echoes) {
                    Ok(written) => files.extend(written),
                    Err(error) => drawn = Err(error),
                }
            }
            if let (Ok(()), Format::Text) = (&drawn, args.format) {
                let files = files.iter().map(|file| format!("  {}\n", file.display()));
                emit(&format!("picture\n{}\n", files.collect::<String>()));
            }
        }
    })?;
    drawn
}
