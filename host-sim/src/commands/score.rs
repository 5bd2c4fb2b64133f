//! `score DIR`: scores all recordings of a directory against their ground truth.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Result, ensure};
use indicatif::ParallelProgressIterator;
use rayon::prelude::*;
use serde_json::json;

use super::{Format, Settings, emit, progress};
use crate::recording::{self, Recording};
use crate::replay;
use crate::score::{self, SceneScore, SetScore};
use crate::setup::{self, Kind};
use crate::sweeps::score::{self as sweeps, GuardAnswer, Scored, Sums};
use crate::sweeps::{ground, truth};

/// Arguments of `score`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Directory of recordings with ground truth
    dir: PathBuf,
    #[command(flatten)]
    settings: Settings,
    /// Repeat with this number of seeds, from --seed on, and also show the median of each figure
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    seeds: u32,
    /// Treat every scan of a recording as if it were the first
    #[arg(long)]
    single: bool,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Scores every recording and prints the scores; exit status 1 if a recording could not be read.
pub fn run(args: &Args) -> Result<ExitCode> {
    let base = args.settings.config()?;
    let is_guard = |path: &PathBuf| {
        // An unreadable file is reported where it is scored.
        Recording::read(path).is_ok_and(|r| setup::kind(&r).is_ok_and(|kind| kind == Kind::Guard))
    };
    let (sweeps, recordings): (Vec<PathBuf>, Vec<PathBuf>) =
        recording::list(&args.dir)?.into_iter().partition(is_guard);
    if !sweeps.is_empty() {
        emit(&guard(&sweeps, args, &args.settings.options(base))?);
        if recordings.is_empty() {
            return Ok(ExitCode::SUCCESS);
        }
    }
    let jobs: Vec<(u32, &PathBuf)> = (0..args.seeds)
        .flat_map(|n| {
            recordings
                .iter()
                .map(move |path| (base.seed.wrapping_add(n), path))
        })
        .collect();
    let bar = progress(jobs.len() as u64);
    let results: Vec<(u32, Result<Vec<SceneScore>>)> = jobs
        .par_iter()
        .progress_with(bar.clone())
        .map(|&(seed, path)| {
            let options = replay::Options {
                config: stairscan::config::Config { seed, ..base },
                single: args.single,
                ..args.settings.options(base)
            };
            (seed, score_one(path, &options))
        })
        .collect();
    bar.finish_and_clear();
    let mut failed = false;
    let mut runs: Vec<Vec<SceneScore>> = Vec::new();
    let mut last_seed = None;
    for (seed, result) in results {
        if last_seed != Some(seed) {
            runs.push(Vec::new());
            last_seed = Some(seed);
        }
        match result {
            Ok(scores) => {
                if let Some(run) = runs.last_mut() {
                    run.extend(scores);
                }
            }
            Err(error) => {
                failed = true;
                crate::note!("error: {error:#}");
            }
        }
    }
    ensure!(
        runs.iter().any(|run| !run.is_empty()),
        "{}: no recording has ground truth (stairscan:truth, or stairscan:truth_scans where it \
         holds several scans)",
        args.dir.display()
    );
    emit(&text(args, &runs));
    Ok(if failed {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    })
}

/// Returns the score of all recordings of guard sweeps together, as text; those without ground truth are left out.
fn guard(paths: &[PathBuf], args: &Args, options: &replay::Options) -> Result<String> {
    let one = |path: &PathBuf| {
        let recording = Recording::read(path)?;
        let Some(truth) = truth::read(&recording)? else {
            return Ok(None);
        };
        let options = replay::Options {
            single: args.single,
            ..*options
        };
        let words = replay::guarded(&recording, &options)?;
        let words: Vec<GuardAnswer> = words.iter().map(GuardAnswer::of).collect();
        let ground_echo_range_m = ground::of(&recording)?;
        Ok(Some(sweeps::recording(
            &recording.name,
            &words,
            &truth,
            &ground_echo_range_m,
        )))
    };
    let scored: Vec<Option<Scored>> = paths.par_iter().map(one).collect::<Result<_>>()?;
    let sums = Sums::of(scored.iter().flatten(), |_| true);
    Ok(match args.format {
        Format::Json => format!("{}\n", sums.json("guard")),
        Format::Text => format!("{}{}\n", sweeps::HEADING, sweeps::row("guard", &sums)),
    })
}

/// Returns the score of every scan of a recording, each against its own ground truth; empty without
/// ground truth.
fn score_one(path: &std::path::Path, options: &replay::Options) -> Result<Vec<SceneScore>> {
    let recording = Recording::read(path)?;
    if recording.truth(0).is_none() {
        return Ok(Vec::new());
    }
    let misleading = recording
        .meta
        .disturbance
        .as_ref()
        .is_some_and(|d| d.misleading);
    let answers = replay::answers(&recording, options, |_| ())?;
    let scores = answers.iter().enumerate().filter_map(|(k, answer)| {
        let truth = recording.truth(k)?;
        Some(SceneScore {
            misleading,
            ..score::scene(answer, truth)
        })
    });
    Ok(scores.collect())
}

/// Returns the scores of the scenes as text: one table, or one JSON object, for each seed, and the medians over the
/// seeds.
fn text(args: &Args, runs: &[Vec<SceneScore>]) -> String {
    let scored: Vec<Vec<SetScore>> = runs.iter().map(|run| score::by_set(run)).collect();
    let estimator = args.settings.estimator_name();
    let mut out = String::new();
    for (n, (sets, scenes)) in (0..).zip(scored.iter().zip(runs)) {
        let seed = args.settings.seed().wrapping_add(n);
        if args.format == Format::Json {
            let run = json!({
                "estimator": estimator,
                "seed": seed,
                "sets": sets.iter().map(SetScore::json).collect::<Vec<_>>(),
                "not_exact_or_wrong": score::confusions_json(scenes),
            });
            let _ = writeln!(out, "{run}");
            continue;
        }
        let _ = writeln!(
            out,
            "estimator {estimator}, seed {seed}\n\n{}",
            score::table(sets)
        );
        let confusions = score::confusions(scenes);
        if args.seeds == 1 && !confusions.is_empty() {
            let _ = write!(out, "not exact, or wrong:\n{confusions}");
        }
    }
    if args.format == Format::Text && args.seeds > 1 {
        let _ = write!(
            out,
            "median over {} seeds\n\n{}",
            args.seeds,
            score::median_table(&scored)
        );
    }
    out
}
