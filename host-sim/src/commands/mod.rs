//! The program's commands, one module each.

pub mod calibrate;
pub mod convert;
pub mod crash;
pub mod doctor;
pub mod emulate;
pub mod help;
pub mod image;
pub mod inspect;
pub mod keys;
pub mod live;
pub mod logs;
pub mod module;
pub mod profile;
pub mod record;
pub mod replay;
pub mod report;
pub mod score;
pub mod seal;
pub mod settings;
pub mod simulate;
pub mod sirad;
pub mod timing;
pub mod update;
pub mod web;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail, ensure};
use stairscan::config::{Config, EstimatorKind};

pub use crate::console::{Format, busy, emit, progress, progress_after_start, progress_aside};
use crate::convert::suffix;
use crate::recording::{self, Recording};
use crate::replay::{Options, SEED};
use crate::setup;

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
            crate::note!("skipped: {}: no recording", path.display());
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
