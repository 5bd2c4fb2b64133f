//! The program's commands, one module each.

pub mod ablate;
pub mod accuracy;
pub mod bench;
pub mod budget;
pub mod calibrate;
pub mod capability;
pub mod compare;
pub mod convergence;
pub mod convert;
pub mod crash;
pub mod doctor;
pub mod drives;
pub mod emulate;
pub mod faults;
pub mod fit;
pub mod guard;
pub mod hardware;
pub mod harness;
pub mod help;
pub mod image;
pub mod inspect;
pub mod instrument;
pub mod keys;
pub mod live;
pub mod modes;
pub mod module;
pub mod params;
pub mod profile;
pub mod reasons;
pub mod record;
pub mod replay;
pub mod report;
pub mod sbom;
pub mod score;
pub mod seal;
pub mod sequences;
pub mod settings;
pub mod simulate;
pub mod sirad;
pub mod snr;
pub mod soak;
pub mod table1;
pub mod timing;
pub mod twins;
pub mod update;
pub mod web;

use std::collections::HashSet;
use std::io::{IsTerminal as _, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Result, bail, ensure};
use clap::ValueEnum;
use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use stairscan::config::{Config, EstimatorKind};

use crate::convert::suffix;
use crate::recording::{self, Recording};
use crate::replay::{Options, SEED};
use crate::setup;

/// How results are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Text
    #[default]
    Text,
    /// JSON; nothing else goes to stdout
    Json,
}

/// Writes to stdout. If the reader closes the pipe (`| head`) the program ends without an error message.
pub fn emit(text: &str) {
    let mut out = std::io::stdout().lock();
    if let Err(error) = out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        let broken_pipe = error.kind() == std::io::ErrorKind::BrokenPipe;
        if !broken_pipe {
            eprintln!("error: stdout: {error}");
        }
        std::process::exit(if broken_pipe { 0 } else { 1 });
    }
}

/// Update interval of the time on a progress bar.
const TICK: Duration = Duration::from_millis(200);

/// Returns a progress bar with elapsed and remaining time, on stderr if that is a terminal; otherwise a hidden one.
pub fn progress(length: u64) -> ProgressBar {
    timed(
        ProgressBar::new(length),
        "{prefix} {bar:40} {pos}/{len}, {elapsed} gone, {left} to go",
    )
}

/// Returns [`progress`] for commands that print results one by one. It is hidden if stdout is a terminal, where the
/// results show the progress.
pub fn progress_aside(length: u64) -> ProgressBar {
    if std::io::stdout().is_terminal() {
        return ProgressBar::hidden();
    }
    progress(length)
}

/// Returns a spinner with a text and the elapsed time, for work of unknown length.
pub fn busy(what: &str) -> ProgressBar {
    timed(
        ProgressBar::new_spinner(),
        "{spinner} {msg}: {elapsed} gone",
    )
    .with_message(what.to_owned())
}

fn timed(bar: ProgressBar, style: &str) -> ProgressBar {
    // Without a finished item the remaining time is unknown.
    let left = |state: &ProgressState, text: &mut dyn std::fmt::Write| {
        let _ = match state.pos() {
            0 => write!(text, "?"),
            _ => write!(text, "{:#}", HumanDuration(state.eta())),
        };
    };
    let style = ProgressStyle::with_template(style);
    let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.set_style(style.with_key("left", left));
    // The time advances also during a long item. Hidden bars need no thread.
    if !bar.is_hidden() {
        bar.enable_steady_tick(TICK);
    }
    bar
}

/// Returns the recordings that `paths` name, each once, those of a directory in order. Other files, as matched by the
/// shell's `*`, are skipped with a line on stderr. A single path is not checked.
///
/// # Errors
/// A directory cannot be read or contains no recordings, no path can be a recording, or a single file contains
/// samples that `convert` reads.
pub fn recordings(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    if let [path] = paths
        && matches!(suffix(path), "npy" | "npz" | "bin")
    {
        let path = path.display();
        bail!(
            "{path}: samples without metadata, expected a recording: `cargo sim convert {path} … -o \
             NAME` makes one (docs/user/formats.md)"
        );
    }
    let mut found: Vec<PathBuf> = Vec::new();
    for path in paths {
        if path.is_dir() {
            found.extend(recording::list(path)?);
        } else if paths.len() == 1 || recording::may_be(path) {
            found.push(recording::meta_path(path));
        } else {
            eprintln!("skipped: {}: no recording", path.display());
        }
    }
    let mut seen = HashSet::new();
    found.retain(|path| seen.insert(path.clone()));
    ensure!(
        !found.is_empty(),
        "none of the paths is a recording (a pair NAME.sigmf-meta, NAME.sigmf-data)"
    );
    Ok(found)
}

/// Returns the recordings of a directory except those of guard sweeps.
///
/// # Errors
/// The directory cannot be read or contains no recordings.
pub fn full_scans(dir: &Path) -> Result<Vec<PathBuf>> {
    let mut found = recording::list(dir)?;
    // An unreadable file is reported where it is used.
    found.retain(|path| Recording::read(path).map_or(true, |r| setup::full_scans(&r).is_ok()));
    Ok(found)
}

/// What can be chosen for every scan.
#[derive(clap::Args, Clone, Debug)]
pub struct Settings {
    /// Estimator of the steps
    #[arg(long, value_parser = parse_estimator, default_value = EstimatorKind::default().as_str())]
    estimator: EstimatorKind,
    /// Seed of the particles' random numbers
    #[arg(long, default_value_t = SEED)]
    seed: u32,
}

fn parse_estimator(name: &str) -> Result<EstimatorKind, String> {
    let names: Vec<&str> = EstimatorKind::ALL.iter().map(|k| k.as_str()).collect();
    EstimatorKind::from_name(name).ok_or_else(|| format!("expected one of {}", names.join(", ")))
}

impl Settings {
    /// Returns the default configuration with the chosen estimator and seed; the values in a recording override it.
    pub fn config(&self) -> Result<Config> {
        Ok(Config {
            estimator: self.estimator,
            seed: self.seed,
            ..Config::default()
        })
    }

    /// Returns the default options of replay with this configuration.
    pub fn options(&self, config: Config) -> Options {
        Options {
            config,
            ..Options::default()
        }
    }

    /// Returns the name of the chosen estimator.
    pub fn estimator_name(&self) -> &'static str {
        self.estimator.as_str()
    }

    /// Returns the chosen seed of the particles' random numbers.
    pub fn seed(&self) -> u32 {
        self.seed
    }
}
