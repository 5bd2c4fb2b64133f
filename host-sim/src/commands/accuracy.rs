//! `accuracy`: the estimators on random scenes of the project's own simulator.

use std::fmt::Write as _;
use std::process::ExitCode;

use anyhow::Result;
use indicatif::ParallelProgressIterator;
use rayon::prelude::*;
use stairscan::config::{Config, EstimatorKind};
use stairscan::stairs::Status;

use super::emit;
use super::score::progress;
use crate::replay::{self, Options};
use crate::scene::Scene;
use crate::scene::random::{Kind, random};
use crate::score::{self, SceneScore, SetScore};

/// Scenes of each kind, with the seeds 0, 1, …
const SCENES: [(Kind, u64); 4] = [
    (Kind::Ascending, 200),
    (Kind::None, 40),
    (Kind::Descending, 40),
    (Kind::Irregular, 40),
];
/// A height error that a wheelchair can take, metres.
const HARMLESS_M: f64 = 0.015;
/// A height error that must never come with the status `ok`, metres.
const DANGEROUS_M: f64 = 0.030;

/// Arguments of `accuracy`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Also list the scenes that are not exact
    #[arg(long)]
    list: bool,
}

/// The answers of one estimator to all scenes of one kind.
#[derive(Clone, Debug)]
pub struct Row {
    /// What the scenes show.
    pub kind: Kind,
    /// From map to steps.
    pub estimator: EstimatorKind,
    /// The scenes' scores, in the order of their seeds.
    pub scenes: Vec<SceneScore>,
}

/// Simulates and scans every scene with every estimator.
pub fn measure() -> Result<Vec<Row>> {
    let jobs: Vec<(Kind, u64)> = SCENES
        .iter()
        .flat_map(|&(kind, count)| (0..count).map(move |seed| (kind, seed)))
        .collect();
    let bar = progress(jobs.len() as u64);
    let scored: Result<Vec<Vec<SceneScore>>> = jobs
        .par_iter()
        .progress_with(bar.clone())
        .map(|&(kind, seed)| one(kind, seed))
        .collect();
    bar.finish_and_clear();
    let scored = scored?;
    let row = |kind: Kind, column: usize| Row {
        kind,
        estimator: EstimatorKind::ALL[column],
        scenes: jobs
            .iter()
            .zip(&scored)
            .filter(|(job, _)| job.0 == kind)
            .map(|(_, scores)| scores[column].clone())
            .collect(),
    };
    let columns = 0..EstimatorKind::ALL.len();
    Ok(columns
        .flat_map(|c| SCENES.iter().map(move |s| (s.0, c)))
        .map(|(k, c)| row(k, c))
        .collect())
}

/// One scene with every estimator.
fn one(kind: Kind, seed: u64) -> Result<Vec<SceneScore>> {
    let recording = Scene::new(random(kind, seed))?.simulate(&format!("{kind}_{seed:03}"), seed);
    let truth = recording.meta.truth.clone().unwrap_or_default();
    let score = |&estimator: &EstimatorKind| {
        let config = Config {
            estimator,
            seed: 1,
            ..Config::default()
        };
        let answer = replay::answer(
            &recording,
            &Options {
                config,
                ..Options::default()
            },
        )?;
        Ok(score::scene(&answer, &truth))
    };
    EstimatorKind::ALL.iter().map(score).collect()
}

/// The README's table, errors in centimetres.
pub fn table(rows: &[Row]) -> String {
    let mut out = String::from(
        "| estimator | scenes | exact | missed steps (of 15 dB and more) | false steps | false stairs \
         | distance median, 95 % | height median, 95 % | within 2σ: distance, height \
         | height within 1.5 cm or 2σ | `ok` with height off by > 3 cm | `ok` / `degraded` / `fault` |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let set = SetScore::new("", row.scenes.iter());
        let spread = |s: Option<score::Spread>| {
            s.map_or("–".into(), |s| {
                format!("{:.2}, {:.2} cm", 100.0 * s.median, 100.0 * s.p95)
            })
        };
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        let within = match [set.distance_sigmas, set.height_sigmas].map(|s| s[0].value()) {
            [Some(d), Some(h)] => format!("{}, {}", percent(d), percent(h)),
            _ => "–".into(),
        };
        let (harmless, dangerous) = heights(&row.scenes);
        let [ok, degraded, fault] = set.status;
        let _ = writeln!(
            out,
            "| `{}` | {} {} | {} | {}/{} ({}/{}) | {} | {} | {} | {} | {within} | {} | {dangerous} \
             | {ok} / {degraded} / {fault} |",
            row.estimator.as_str(),
            set.scenes,
            row.kind,
            set.exact.hits,
            set.missed.hits,
            set.missed.of,
            set.strong_missed.hits,
            set.strong_missed.of,
            set.invented,
            set.false_stairs.hits,
            spread(set.distance[0]),
            spread(set.height[0]),
            harmless.map_or("–".into(), percent),
        );
    }
    out
}

/// Share of reported heights that are harmless or say themselves how wrong they are, and the
/// number of dangerous ones among those that were reported as `ok`.
fn heights(scenes: &[SceneScore]) -> (Option<f64>, usize) {
    let matches = || {
        scenes
            .iter()
            .flat_map(|s| s.matches.iter().map(move |m| (s.status, m)))
    };
    let all = matches().count();
    let harmless = matches()
        .filter(|(_, m)| m.height_error.abs() <= HARMLESS_M || m.height_z.abs() <= 2.0)
        .count();
    let dangerous = matches()
        .filter(|(status, m)| *status == Status::Ok && m.height_error.abs() > DANGEROUS_M)
        .count();
    ((all > 0).then(|| harmless as f64 / all as f64), dangerous)
}

/// Prints the table.
pub fn run(args: &Args) -> Result<ExitCode> {
    let rows = measure()?;
    let mut out = table(&rows);
    for row in rows.iter().filter(|_| args.list) {
        let _ = write!(
            out,
            "\n{}, {}, not exact:\n{}",
            row.estimator.as_str(),
            row.kind,
            score::confusions(&row.scenes)
        );
    }
    emit(&out);
    Ok(ExitCode::SUCCESS)
}
