//! `fit`: fits the measurement model and the verdict's hazards to simulated scans with ground truth, and writes the
//! tables that the firmware compiles.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Result;
use crc::{CRC_32_ISO_HDLC, Crc};
use serde_json::json;
use stairscan::config::Plane;
use stairscan::params::generative::Generative;
use stairscan::params::hazard::{FEATURES, PlattMap, Weights};
use stairscan::params::measured;

use super::emit;
use crate::fit::logistic::LogisticFit;
use crate::fit::measurement::{self, Build};
use crate::fit::{self, TrainingSample};
use crate::harness::{self, Drawn};
use host_sim::emulate::image::workspace;
use host_sim::output::{Outputs, Overwrite};
use host_sim::random::{Kind, random_with};
use host_sim::recording::{self, Recording};
use host_sim::seeds::Draw;

/// Default number of scenes of each kind for fitting the hazards.
const TRAINING: u64 = 300;

/// Returns the number of scenes of a kind for fitting the hazards: twice `scenes` for the height plane, which has two
/// kinds only.
fn training(kind: Kind, scenes: u64) -> u64 {
    match kind {
        Kind::Descending | Kind::Downstairs => 2 * scenes,
        _ => scenes,
    }
}

/// Returns the number of scenes of a kind for calibrating the hazards, given `scenes` for fitting.
fn calibrating(kind: Kind, scenes: u64) -> u64 {
    let of = training(kind, scenes);
    of.div_ceil(5)
}

/// Returns the number of scenes of a kind for testing thresholds, given `scenes` for fitting. It is proportional to
/// the reporting draw, but three times as large for kinds that are mostly answered without steps, of which fewer are
/// `ok`, and eight times as large for the height plane's two kinds.
fn testing(kind: Kind, scenes: u64) -> u64 {
    match kind {
        Kind::None | Kind::Clutter | Kind::Brink | Kind::Hole | Kind::Kerb => 5 * scenes,
        Kind::Ascending => 5 * scenes,
        Kind::Descending | Kind::Downstairs => 12 * scenes,
        _ => (5 * scenes).div_ceil(3),
    }
}

/// Offset of the seeds for testing thresholds from the first seed of the calibration draw; those before it are for
/// calibration.
const BEFORE_TESTING: u64 = 100_000;

/// Arguments of `fit`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Fit to the recordings in these directories in place of simulated ones; every third is for calibration and
    /// thresholds
    #[arg(long, value_name = "DIR", num_args = 1..)]
    on: Vec<PathBuf>,
    /// Number of scenes of each kind to which the hazards are fitted; further ones serve calibration and thresholds
    #[arg(long, default_value_t = TRAINING)]
    scenes: u64,
    /// Write the training data to this file, one JSON object a scan
    #[arg(long, value_name = "FILE")]
    dump: Option<PathBuf>,
    /// Output file of the hazards; without it the firmware's source, which takes --force
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Output file of the measurement model; without it `measured.rs` beside the hazards
    #[arg(long, value_name = "FILE")]
    measured: Option<PathBuf>,
    /// Keep the measurement model and fit only the hazards
    #[arg(long, conflicts_with = "measured")]
    keep: bool,
    /// Fit only the measurement model
    #[arg(long, conflicts_with = "keep")]
    only_model: bool,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// A simulated scan, and the construction of its stairs (open risers, overhang) where it has any.
type Sample = (Recording, Option<Build>);

/// Source of the scans to which the tables are fitted.
enum Source {
    /// Simulated scenes of every kind: for training, for calibration, and for thresholds.
    Simulated([Vec<Sample>; 3]),
    /// Paths of recordings: of every six, four are for training, one for calibration, one for thresholds.
    Recorded(Vec<PathBuf>),
}

/// Samples for fitting the hazards, for calibrating them, and for testing thresholds.
struct TrainingSamples {
    training: Vec<TrainingSample>,
    calibration: Vec<TrainingSample>,
    testing: Vec<TrainingSample>,
}

/// Number of scenes of each kind to which the tables are fitted for their checksum.
const CHECKED: u64 = 2;
const CHECK: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Returns the checksum of the tables of a small draw. The firmware's table contains it, so that a test detects when
/// simulator, estimator or fit have changed since the table was fitted.
///
/// # Errors
/// A scene cannot be scanned; the message names it.
pub fn checksum() -> Result<u32> {
    let source = Source::simulated(CHECKED)?;
    let (model, text, _) = model(&source)?;
    let samples = TrainingSamples::new(&source, model)?;
    let (up, down) = (
        plane(&samples, Plane::Depth).0,
        plane(&samples, Plane::Height).0,
    );
    Ok(CHECK.checksum((text + &fit::write(&up, &down, 0)).as_bytes()))
}

/// Fits the measurement model and the hazards, prints reports, and writes the tables.
pub fn run(args: &Args) -> Result<ExitCode> {
    let output = match &args.output {
        Some(path) => path.clone(),
        None => workspace().join("src/params/fitted.rs"),
    };
    let beside = || output.with_file_name("measured.rs");
    let model_path = args.measured.clone().unwrap_or_else(beside);
    let outputs = args.overwrite.reading::<&PathBuf>([]);
    let hazards = (!args.only_model).then_some(&output);
    let model_file = (!args.keep).then_some(&model_path);
    let mut files = hazards.into_iter().chain(model_file).chain(&args.dump);
    files.try_for_each(|file| outputs.check(file))?;
    let source = match args.on.is_empty() {
        true => Source::simulated(args.scenes)?,
        false => Source::recorded(&args.on)?,
    };
    let mut counted = &measured::MODEL;
    if !args.keep {
        let (model, text, log) = model(&source)?;
        emit(&log);
        write(&outputs, &model_path, &text)?;
        counted = model;
    }
    if args.only_model {
        return Ok(ExitCode::SUCCESS);
    }
    let samples = TrainingSamples::new(&source, counted)?;
    if let Some(path) = &args.dump {
        outputs.write(path, dump(&samples).as_bytes())?;
    }
    let (up, log_up) = plane(&samples, Plane::Depth);
    let (down, log_down) = plane(&samples, Plane::Height);
    emit(&format!("depth plane\n{log_up}\nheight plane\n{log_down}"));
    write(&outputs, &output, &fit::write(&up, &down, checksum()?))?;
    Ok(ExitCode::SUCCESS)
}

impl TrainingSamples {
    /// Computes the training samples of all scans of `source`, with the measurement model `model`.
    fn new(source: &Source, model: &'static Generative) -> Result<Self> {
        let [training, calibration, testing] =
            source.parts(3, |recording, _| fit::sample(recording, model))?;
        Ok(Self {
            training,
            calibration,
            testing,
        })
    }
}

/// Fits the measurement model. Returns it with the text of its source file and a report.
fn model(source: &Source) -> Result<(&'static Generative, String, String)> {
    let [training, held_back, _] = source.parts(2, fit::measurement_sample)?;
    let measured = measurement::measure(&training);
    let mut log = format!("measurement model: {} scans\n", measured.scans);
    for (k, likelihood) in measured.rounds.iter().enumerate() {
        let _ = writeln!(log, "  round {k}: log-likelihood {likelihood:.3} a scan");
    }
    log.push_str(&measurement::print(&measured.numbers));
    for (name, table) in [("compiled", &measured::MODEL), ("counted", &measured.table)] {
        let c = measurement::contrast(&held_back, table);
        let _ = writeln!(
            log,
            "{name}: {} held-out scans: log-likelihood {:.3}; cost against no steps {:.4}, without \
             the last step {:.4}, with one step more {:.4}, with an irregular rise {:.4}",
            c.scans, c.truth, c.cost[0], c.cost[1], c.cost[2], c.cost[3]
        );
    }
    let text = measurement::write(&measured.table);
    // Leaked, since the estimators need a `'static` model.
    Ok((Box::leak(Box::new(measured.table)), text, log))
}

fn write(outputs: &Outputs, path: &Path, text: &str) -> Result<()> {
    outputs.write(path, text.as_bytes())?;
    emit(&format!("written\n  {}\n", path.display()));
    Ok(())
}

impl Source {
    /// Simulates scenes: `scenes` of each kind for fitting, and those for calibration and thresholds in proportion.
    fn simulated(scenes: u64) -> Result<Self> {
        let held_back = harness::scenes(Draw::Calibration, |kind| calibrating(kind, scenes));
        let seeds = Draw::Calibration.seeds();
        let behind = seeds.start + BEFORE_TESTING..seeds.end;
        Ok(Self::Simulated([
            simulated(&harness::scenes(Draw::Tuning, |kind| {
                training(kind, scenes)
            }))?,
            simulated(&held_back)?,
            simulated(&harness::scenes_of(behind, |kind| testing(kind, scenes)))?,
        ]))
    }

    /// Takes all recordings of these directories.
    fn recorded(directories: &[PathBuf]) -> Result<Self> {
        let mut paths = Vec::new();
        for directory in directories {
            paths.extend(recording::list(directory)?);
        }
        Ok(Self::Recorded(paths))
    }

    /// Applies `look` to the scans of the source's three parts: for fitting, for calibration, for thresholds. Of
    /// simulated scenes only the first `wanted` parts are processed. Returns the results of each part.
    fn parts<R: Send>(
        &self,
        wanted: usize,
        look: impl Fn(&Recording, Option<Build>) -> Result<Option<R>> + Send + Sync,
    ) -> Result<[Vec<R>; 3]> {
        let mut parts = [Vec::new(), Vec::new(), Vec::new()];
        match self {
            Self::Simulated(samples) => {
                for (part, samples) in parts.iter_mut().zip(samples).take(wanted) {
                    let made =
                        harness::each(samples, |(recording, build)| look(recording, *build))?;
                    part.extend(made.into_iter().flatten());
                }
            }
            Self::Recorded(paths) => {
                let each = harness::each(paths, |path| look(&Recording::read(path)?, None))?;
                for (k, made) in each.into_iter().enumerate() {
                    parts[[0, 0, 1, 0, 0, 2][k % 6]].extend(made);
                }
            }
        }
        Ok(parts)
    }
}

/// Simulates the scans of these scenes, in their order.
fn simulated(scenes: &[Drawn]) -> Result<Vec<Sample>> {
    harness::each(scenes, |drawn| {
        let (kind, seed) = (drawn.kind, drawn.seed);
        let build = Build::of(&random_with(kind, kind.variety(), seed));
        Ok((drawn.scan()?, build))
    })
}

/// Hazard weights fitted for one scan plane, with the logistic regressions from which they and their calibration are.
struct Counted {
    weights: Weights,
    hazards: LogisticFit,
    /// Calibration of the hazards, `[0]` for answers without steps, `[1]` with: number of scans, and fit of slope and
    /// offset.
    maps: Vec<(usize, LogisticFit)>,
    /// Calibration of the probabilities of `MAYBE`s: fit of slope and offset.
    maybe: LogisticFit,
}

/// Fits the hazards to `training` and their calibration to `calibration`; the threshold of `ok` is determined later.
fn count(training: &[&TrainingSample], calibration: &[&TrainingSample]) -> Counted {
    let hazards = fit::hazards(training);
    let mut weights = Weights {
        hazard: [0.0; FEATURES],
        maps: [PlattMap::IDENTITY; 2],
        maybe_map: PlattMap::IDENTITY,
        ok_from: [f32::INFINITY; 2],
    };
    for (weight, &fitted) in weights.hazard.iter_mut().zip(&hazards.weights) {
        *weight = fitted as f32;
    }
    let mut maps = Vec::new();
    let bare = weights.clone();
    for (stairs, map) in [false, true].into_iter().zip(&mut weights.maps) {
        let samples = calibration.iter().filter(|l| l.stairs == stairs);
        let samples: Vec<_> = samples.copied().collect();
        let counted = fit::calibration(&samples, &bare);
        if let [slope, offset] = counted.weights[..] {
            (map.slope, map.offset) = (slope as f32, offset as f32);
        }
        maps.push((samples.len(), counted));
    }
    let maybe = fit::maybes(training);
    if let [slope, offset] = maybe.weights[..] {
        weights.maybe_map = PlattMap {
            slope: slope as f32,
            offset: offset as f32,
        };
    }
    Counted {
        weights,
        hazards,
        maps,
        maybe,
    }
}

/// Returns the fitted hazard weights of one scan plane, and a report as text.
fn plane(samples: &TrainingSamples, plane: Plane) -> (Weights, String) {
    let parts = [&samples.training, &samples.calibration, &samples.testing];
    let [training, calibration, testing] =
        parts.map(|part| part.iter().filter(|l| l.plane == plane).collect::<Vec<_>>());
    let Counted {
        mut weights,
        hazards,
        maps,
        maybe,
    } = count(&training, &calibration);
    let mut log = String::new();
    for (stairs, name) in [(false, "without steps"), (true, "with steps")] {
        let threshold = fit::threshold(&testing, &weights, stairs);
        weights.ok_from[usize::from(stairs)] = threshold.from;
        let _ = writeln!(
            log,
            "{name}: ok from {:.3} on: {} of {} scans, {} of them wrong",
            threshold.from,
            threshold.ok,
            testing.iter().filter(|l| l.stairs == stairs).count(),
            threshold.wrong
        );
    }
    let cells = "cells, of them wrong";
    table(&mut log, "hazard", (training.len(), cells), &hazards);
    let cells = "cells, of them right";
    for (scans, map) in &maps {
        table(&mut log, "calibration", (*scans, cells), map);
    }
    let maybes = "MAYBEs, of them right";
    table(&mut log, "MAYBE", (training.len(), maybes), &maybe);
    (weights, log)
}

/// Adds a logistic fit to the report `out`: its `name`, the number of `scans`, the number of samples and the name for
/// them, and the weights with their standard errors.
fn table(out: &mut String, name: &str, (scans, samples): (usize, &str), fit: &LogisticFit) {
    let _ = writeln!(
        out,
        "{name}: {scans} scans, {} {samples} {}",
        fit.samples, fit.positives
    );
    for (k, (weight, error)) in fit.weights.iter().zip(&fit.errors).enumerate() {
        let _ = writeln!(out, "  {k:>3} {weight:>9.3} ± {error:.3}");
    }
}

/// Returns the training samples as text: for each scan a line with one JSON object.
fn dump(samples: &TrainingSamples) -> String {
    let mut text = String::new();
    for (part, samples) in [
        ("training", &samples.training),
        ("calibration", &samples.calibration),
        ("testing", &samples.testing),
    ] {
        for sample in samples {
            let cells: Vec<_> = sample
                .cells
                .iter()
                .map(|c| json!({"end_m": c.end_m, "features": c.features.to_vec()}))
                .collect();
            let line = json!({
                "part": part,
                "plane": format!("{:?}", sample.plane),
                "name": sample.name,
                "wrong": sample.wrong,
                "cells": cells,
            });
            let _ = writeln!(text, "{line}");
        }
    }
    text
}
