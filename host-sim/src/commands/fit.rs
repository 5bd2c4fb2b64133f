//! `fit`: counts the verdict's hazards from simulated scans with known truth and writes the table
//! that the firmware compiles.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};
use indicatif::ParallelProgressIterator;
use rayon::prelude::*;
use serde_json::json;
use stairscan::config::Plane;
use stairscan::params::hazard::{FEATURES, Weights};

use super::{emit, progress};
use crate::emulate::image::workspace;
use crate::fit::logistic::Fit;
use crate::fit::{self, Lesson};
use crate::recording::{self, Recording};
use crate::scene::command::random_scan;
use crate::scene::random::Kind;
use crate::seeds::Draw;

/// Scenes of each kind that hazards are counted from …
const TRAINING: u64 = 160;
/// … and that they are calibrated on.
const CALIBRATION: u64 = 80;

/// Arguments of `fit`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Count from the recordings in these directories in place of simulated ones; every third is for
    /// calibration
    #[arg(long, value_name = "DIR", num_args = 1..)]
    on: Vec<PathBuf>,
    /// Scenes of each kind; half as many for calibration
    #[arg(long, default_value_t = TRAINING)]
    scenes: u64,
    /// Write what was counted from, one JSON object a scan, to this file
    #[arg(long, value_name = "FILE")]
    dump: Option<PathBuf>,
    /// Where to write the table; the firmware's source if not given
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// What hazards are counted from, and what they are calibrated on.
struct Lessons {
    training: Vec<Lesson>,
    calibration: Vec<Lesson>,
}

/// Counts, prints, writes.
pub fn run(args: &Args) -> Result<ExitCode> {
    let lessons = if args.on.is_empty() {
        simulated(args.scenes)?
    } else {
        recorded(&args.on)?
    };
    if let Some(path) = &args.dump {
        dump(path, &lessons)?;
    }
    let (up, told_up) = plane(&lessons, Plane::Depth);
    let (down, told_down) = plane(&lessons, Plane::Height);
    emit(&format!(
        "depth plane\n{told_up}\nheight plane\n{told_down}"
    ));
    let path = match &args.output {
        Some(path) => path.clone(),
        None => workspace().join("src/params/fitted.rs"),
    };
    std::fs::write(&path, fit::write(&up, &down)).with_context(|| path.display().to_string())?;
    emit(&format!("written\n  {}\n", path.display()));
    Ok(ExitCode::SUCCESS)
}

/// Lessons of simulated scenes of every kind.
fn simulated(scenes: u64) -> Result<Lessons> {
    let of = |draw: Draw, count: u64| -> Result<Vec<Lesson>> {
        let seeds = || draw.seeds().take(count as usize);
        let jobs: Vec<(Kind, u64)> = Kind::ALL
            .iter()
            .flat_map(|&kind| seeds().map(move |seed| (kind, seed)))
            .collect();
        let bar = progress(jobs.len() as u64);
        let lessons: Result<Vec<Option<Lesson>>> = jobs
            .par_iter()
            .progress_with(bar.clone())
            .map(|&(kind, seed)| fit::lesson(&random_scan(kind, kind.variety(), seed)?))
            .collect();
        bar.finish_and_clear();
        Ok(lessons?.into_iter().flatten().collect())
    };
    Ok(Lessons {
        training: of(Draw::Tuning, scenes)?,
        calibration: of(Draw::Validation, scenes * CALIBRATION / TRAINING)?,
    })
}

/// Lessons of recordings with truth.
fn recorded(directories: &[PathBuf]) -> Result<Lessons> {
    let mut paths = Vec::new();
    for directory in directories {
        paths.extend(recording::list(directory)?);
    }
    let bar = progress(paths.len() as u64);
    let lessons: Result<Vec<Option<Lesson>>> = paths
        .par_iter()
        .progress_with(bar.clone())
        .map(|path| fit::lesson(&Recording::read(path)?))
        .collect();
    bar.finish_and_clear();
    let mut parts = Lessons {
        training: Vec::new(),
        calibration: Vec::new(),
    };
    for (k, lesson) in lessons?.into_iter().enumerate() {
        match k % 3 {
            2 => parts.calibration.extend(lesson),
            _ => parts.training.extend(lesson),
        }
    }
    Ok(parts)
}

/// The weights of one plane, and what there is to say of them.
fn plane(lessons: &Lessons, plane: Plane) -> (Weights, String) {
    let of = |all: &'_ [Lesson]| -> Vec<Lesson> {
        all.iter().filter(|l| l.plane == plane).cloned().collect()
    };
    let (training, calibration) = (of(&lessons.training), of(&lessons.calibration));
    let hazards = fit::hazards(&training.iter().collect::<Vec<_>>());
    let mut weights = Weights {
        hazard: [0.0; FEATURES],
        slope: 1.0,
        offset: 0.0,
        ok_from: f32::INFINITY,
    };
    for (weight, &fitted) in weights.hazard.iter_mut().zip(&hazards.weights) {
        *weight = fitted as f32;
    }
    let map = fit::calibration(&calibration.iter().collect::<Vec<_>>(), &weights);
    if let [slope, offset] = map.weights[..] {
        (weights.slope, weights.offset) = (slope as f32, offset as f32);
    }
    let least = fit::threshold(&calibration.iter().collect::<Vec<_>>(), &weights);
    weights.ok_from = least.from;
    let mut told = format!(
        "ok from {:.3} on: {} scans of common forms for calibration, {} of them wrong\n",
        least.from, least.ok, least.wrong
    );
    table(&mut told, "hazard", training.len(), &hazards);
    table(&mut told, "calibration", calibration.len(), &map);
    (weights, told)
}

/// Weights with their standard errors.
fn table(out: &mut String, name: &str, scans: usize, fit: &Fit) {
    let _ = writeln!(
        out,
        "{name}: {scans} scans, {} cells, {} of them {}",
        fit.samples,
        fit.happened,
        if name == "hazard" { "wrong" } else { "right" }
    );
    for (k, (weight, error)) in fit.weights.iter().zip(&fit.errors).enumerate() {
        let _ = writeln!(out, "  {k:>3} {weight:>9.3} ± {error:.3}");
    }
}

/// What was counted from.
fn dump(path: &Path, lessons: &Lessons) -> Result<()> {
    let mut text = String::new();
    for (part, lessons) in [
        ("training", &lessons.training),
        ("calibration", &lessons.calibration),
    ] {
        for lesson in lessons {
            let cells: Vec<_> = lesson
                .cells
                .iter()
                .map(|c| json!({"end_m": c.end_m, "features": c.features.to_vec()}))
                .collect();
            let line = json!({
                "part": part,
                "plane": format!("{:?}", lesson.plane),
                "name": lesson.name,
                "wrong": lesson.wrong,
                "cells": cells,
            });
            let _ = writeln!(text, "{line}");
        }
    }
    std::fs::write(path, text).with_context(|| path.display().to_string())
}
