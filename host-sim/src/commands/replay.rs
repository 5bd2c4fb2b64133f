//! `replay REC…`: scans recordings with the scanner's own loop.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Result, ensure};
use stairscan::config::EstimatorKind;
use stairscan::motion::Mode;

use super::{Format, Settings, emit, logs, progress_aside, recordings};
use crate::answer::Answer;
use crate::film::Film;
use crate::guarded::{self, Guarded};
use crate::inspect::Inspection;
use crate::motion::Fault;
use crate::output::{Outputs, Overwrite};
use crate::plots::{self, PaperView, ScanView};
use crate::recording::{Recording, Truth};
use crate::replay::{self, Scanned};
use crate::setup::{self, Kind};
use crate::views::PosteriorView;

/// Arguments of `replay`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Recordings, with or without suffix, or directories of them
    #[arg(required_unless_present = "log")]
    recordings: Vec<PathBuf>,
    /// Print the answers in this log of sentences, of `live --record` or any serial logger, instead of a recording's
    #[arg(long, value_name = "FILE", conflicts_with_all = ["recordings", "scans", "backwards",
        "single", "motion", "motion_fault", "by_trigger", "plots", "film"])]
    log: Option<PathBuf>,
    #[command(flatten)]
    settings: Settings,
    /// Number of consecutive scans in alternating direction; without it those of the recording
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1000))]
    scans: Option<u32>,
    /// Reverse the direction of the mirror
    #[arg(long)]
    backwards: bool,
    /// Treat every scan of a recording as if it were the first
    #[arg(long)]
    single: bool,
    /// Mode without motion input: auto, required or standing; without it `standing` for a single scan without motion
    /// keys and `auto` for all others
    #[arg(long, value_parser = parse_mode)]
    motion: Option<Mode>,
    /// Inject this fault into the motion sentences
    #[arg(long, value_enum)]
    motion_fault: Option<Fault>,
    /// Send motion sentences with the triggers, as `emulate` does, not at the recording's times
    #[arg(long, conflicts_with = "motion_fault")]
    by_trigger: bool,
    /// Draw the paper's figures for each scan of the recordings into this directory
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    /// Draw an animation of the scans: an SVG file (.svg) for a page or a README
    #[arg(long, value_name = "FILE")]
    film: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

fn parse_mode(word: &str) -> Result<Mode, String> {
    let mut settings = stairscan::scanner::Settings::default();
    match settings.set("motion", word) {
        Ok(()) => Ok(settings.motion),
        Err(error) => Err(format!("expected {}", error.expected)),
    }
}

/// Scans every recording. A bad recording or a fault sets the exit status to 1; the others are still
/// scanned.
pub fn run(args: &Args) -> Result<ExitCode> {
    let options = replay::Options {
        scans: args.scans,
        backwards: args.backwards,
        single: args.single,
        motion: args.motion,
        motion_fault: args.motion_fault,
        by_trigger: args.by_trigger,
        ..args.settings.options(args.settings.config()?)
    };
    if let Some(path) = &args.log {
        return logged(path, args.format);
    }
    let mut code = ExitCode::SUCCESS;
    let paths = recordings(&args.recordings)?;
    ensure!(
        args.film.is_none() || paths.len() == 1,
        "--film: expected one recording, not {}",
        paths.len()
    );
    let outputs = args.overwrite.reading(&paths);
    if let Some(file) = &args.film {
        outputs.check_kind(file, &["svg"])?;
        outputs.ready(file)?;
    }
    let bar = progress_aside(paths.len() as u64);
    for path in &paths {
        let shown = scan(path, args, &options, &outputs);
        bar.inc(1);
        if !shown.unwrap_or_else(|error| show(Err(error), None, args.format)) {
            code = ExitCode::FAILURE;
        }
    }
    bar.finish_and_clear();
    Ok(code)
}

/// Prints the answers and guard sweeps of a log. A fault sets the exit status to 1.
fn logged(path: &Path, format: Format) -> Result<ExitCode> {
    let log = logs::expect(path)?;
    let mut good = true;
    for (_, answer) in log.answers() {
        good &= show(Ok(answer), None, format);
    }
    let sweeps: Vec<String> = log.sweeps().map(|(line, _)| line.text.clone()).collect();
    if !sweeps.is_empty() {
        let words = Guarded::parse(0, sweeps)?.into_iter();
        let named = |word| Guarded {
            recording: log.name.clone(),
            ..word
        };
        good &= show_guarded(&words.map(named).collect::<Vec<_>>(), format);
    }
    Ok(if good {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// Scans one recording and prints the answers. Returns whether all answers are without a fault, and all requested
/// pictures written.
fn scan(path: &Path, args: &Args, options: &replay::Options, outputs: &Outputs) -> Result<bool> {
    let recording = Recording::read(path)?;
    if setup::kind(&recording)? == Kind::Guard {
        let pictures = args.plots.is_some() || args.film.is_some();
        ensure!(
            !pictures,
            "{}: --plots and --film: expected full scans, found guard sweeps",
            recording.name
        );
        return Ok(show_guarded(
            &replay::guarded(&recording, options)?,
            args.format,
        ));
    }
    let mut pictures = Vec::new();
    let mut film = Film::new(&recording);
    let answers = replay::answers(&recording, options, |scanned| {
        if args.film.is_some() {
            film.take(&recording, scanned);
        }
        // Repetitions of a single scan look the same.
        if let Some(dir) = &args.plots
            && pictures.len() < recording.scans()
        {
            pictures.push(draw(outputs, dir, scanned));
        }
    });
    let mut good = true;
    match answers {
        Ok(answers) => answers.into_iter().for_each(|answer| {
            let truth = recording.truth(answer.scan_of_recording());
            good &= show(Ok(answer), truth, args.format);
        }),
        Err(error) => good = show(Err(error), None, args.format),
    }
    if let Some(file) = &args.film {
        let written = outputs
            .write(file, film.svg().as_bytes())
            .map(|()| vec![file.clone()]);
        pictures.push(written);
    }
    if !pictures.is_empty() {
        good &= list(pictures, args.format);
    }
    Ok(good)
}

/// Draws the paper's figures of a scan into the directory `dir`, and returns the paths of the files.
fn draw(outputs: &Outputs, dir: &Path, scanned: &Scanned<'_>) -> Result<Vec<PathBuf>> {
    let Scanned {
        config,
        pipeline,
        answer,
        ..
    } = *scanned;
    let map = pipeline.map();
    let inspection =
        (config.estimator == EstimatorKind::Likelihood).then(|| Inspection::of(scanned));
    let posterior = inspection.map_or(PosteriorView::default(), |i| i.view().posterior.clone());
    let scan = ScanView {
        recording: &scanned.recording(),
        config,
        map,
        answer,
        paper: &PaperView::of(map, config, answer.scan.scan),
        posterior: &posterior,
    };
    plots::write_scan((outputs, dir), &scan)
}

/// Prints the paths of all drawn pictures, or the first error if one could not be written; `pictures` holds the paths
/// for each scan. Returns whether all were written.
fn list(pictures: Vec<Result<Vec<PathBuf>>>, format: Format) -> bool {
    match pictures.into_iter().collect::<Result<Vec<_>>>() {
        Ok(files) => {
            if format == Format::Text {
                let lines = files
                    .iter()
                    .flatten()
                    .map(|f| format!("  {}\n", f.display()));
                emit(&format!("pictures\n{}\n", lines.collect::<String>()));
            }
            true
        }
        Err(error) => {
            crate::note!("error: {error:#}");
            false
        }
    }
}

/// Prints the answers to guard sweeps. Returns whether none was a fault.
pub fn show_guarded(words: &[Guarded], format: Format) -> bool {
    match format {
        Format::Json => words
            .iter()
            .for_each(|word| emit(&format!("{}\n", word.json()))),
        Format::Text => emit(&format!("{}\n", guarded::text(words))),
    }
    !words.iter().any(Guarded::is_fault)
}

/// Prints an answer, as text together with the ground truth, or the error. Returns whether it was an
/// answer without a fault.
pub fn show(answer: Result<Answer>, truth: Option<&Truth>, format: Format) -> bool {
    match answer {
        Ok(answer) => {
            match format {
                Format::Json => emit(&format!("{}\n", answer.json())),
                Format::Text => {
                    let truth = truth.map(|t| format!("  truth: {}\n", t.summary()));
                    emit(&format!("{}{}\n", answer.text(), truth.unwrap_or_default()));
                }
            }
            !answer.is_fault()
        }
        Err(error) => {
            crate::note!("error: {error:#}");
            false
        }
    }
}
