//! `convergence`: measures how fast the particles reach the high-intensity cells, for the paper's
//! three initial distributions, and compares with its numbers of rounds (sections III-A and III-C).

use std::fmt::Write as _;
use std::process::ExitCode;

use anyhow::{Context as _, Result};
use rayon::prelude::*;
use serde_json::json;
use stairscan::config::{Config, EstimatorKind, Spread};
use stairscan::estimator::Estimator;
use stairscan::observer::{CloudStage, Event, Observer};
use stairscan::paper::Paper;
use stairscan::paper::bright::{IntensityMap, MapLevels};
use stairscan::signal::grid::PolarMap;

use super::{Format, emit, progress};
use crate::replay;
use crate::scene::Scene;

/// Arguments of `convergence`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Seed of the first scan's particles
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// Number of scans of each staircase, with the seeds 0, 1, … for surfaces, noise and particles
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    scans: u32,
    /// Number of rounds of resampling
    #[arg(long, default_value_t = 15, value_parser = clap::value_parser!(u8).range(1..=50))]
    rounds: u8,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// The compared initial distributions of the particles, with their names in tables and in JSON.
const SPREADS: [(Spread, &str, &str); 3] = [
    (Spread::Uniform, "uniform", "uniform"),
    (Spread::GmmRaw, "gmm", "GMM"),
    (Spread::GmmCfar, "gmm-cfar", "GMM, CFAR map"),
];

/// Convergence criterion: the particles have converged once their share in high-intensity cells is this fraction of the
/// share after the last round.
const CONVERGED: f64 = 0.9;

const SCENES: [(&str, &str); 3] = [
    ("Stair A", include_str!("../../../scenes/stair_a.toml")),
    ("Stair B", include_str!("../../../scenes/stair_b.toml")),
    ("Stair C", include_str!("../../../scenes/stair_c.toml")),
];

/// Observer that counts the particles in high-intensity cells of the CFAR map. For all initial distributions, as in the
/// paper, these cells are the targets of convergence.
struct Count<'a> {
    bright: IntensityMap<'a>,
    /// Share of particles in high-intensity cells after 0, 1, … rounds.
    shares: Vec<f64>,
}

impl Observer for Count<'_> {
    fn event(&mut self, event: Event<'_>) {
        if let Event::Particles {
            stage: CloudStage::Drawn | CloudStage::Resampled,
            particles,
            ..
        } = event
        {
            let there = particles
                .iter()
                .filter(|p| self.bright.is_high_intensity(p));
            let share = there.count() as f64 / particles.len().max(1) as f64;
            self.shares.push(share);
        }
    }
}

/// Returns the shares of particles in high-intensity cells of `map` after 0, 1, … `rounds` rounds of resampling, from
/// the initial distribution `spread`.
fn shares(map: &PolarMap, config: &Config, spread: Spread, rounds: u8) -> Vec<f64> {
    let mut config = *config;
    config.particles.spread = spread;
    config.particles.rounds = rounds;
    let mut levels = MapLevels::new();
    let mut paper = Box::new(Paper::new());
    paper.begin(map);
    for row in (0..map.rows()).filter(|&row| map.present(row)) {
        levels.add_row(map, row);
        paper.row(map, row);
    }
    let mut count = Count {
        bright: IntensityMap::new(map, &levels, Spread::GmmCfar),
        shares: Vec::new(),
    };
    paper.finish(map, &config, 1, &mut count);
    count.shares
}

/// Returns, for scan `k` of a scene, the shares of particles in high-intensity cells after 0, 1, … rounds, for each of
/// the [`SPREADS`].
fn scan(name: &str, scene: &Scene, k: u32, args: &Args) -> Result<[Vec<f64>; 3]> {
    let recording = scene.simulate(name, k.into());
    let config = Config {
        seed: args.seed.wrapping_add(k),
        estimator: EstimatorKind::Paper,
        ..Config::default()
    };
    let options = replay::Options {
        config,
        ..replay::Options::default()
    };
    let mut result = [const { Vec::new() }; 3];
    replay::answers(&recording, &options, |scanned| {
        let map = scanned.pipeline.map();
        result = SPREADS.map(|(spread, ..)| shares(map, &config, spread, args.rounds));
    })?;
    Ok(result)
}

/// Mean share of particles in high-intensity cells over all scans, after 0, 1, … rounds from one initial distribution.
struct Curve {
    shares: Vec<f64>,
}

impl Curve {
    fn mean(scans: &[[Vec<f64>; 3]], spread: usize, rounds: u8) -> Self {
        let share = |round: usize| {
            let seen = scans.iter().filter_map(|s| s[spread].get(round));
            seen.sum::<f64>() / scans.len().max(1) as f64
        };
        Self {
            shares: (0..=usize::from(rounds)).map(share).collect(),
        }
    }

    /// Returns the number of resampling rounds after which the particles have converged.
    fn converged(&self) -> usize {
        let last = self.shares.last().copied().unwrap_or(0.0);
        let there = self.shares.iter().position(|s| *s >= CONVERGED * last);
        there.unwrap_or(0)
    }
}

/// Scans the staircases and prints the table.
pub fn run(args: &Args) -> Result<ExitCode> {
    let scenes: Result<Vec<(&str, Scene)>> = (SCENES.iter())
        .map(|&(name, text)| Ok((name, Scene::parse(text).context(name)?)))
        .collect();
    let scenes = scenes?;
    let jobs: Vec<(&str, &Scene, u32)> = (scenes.iter())
        .flat_map(|(name, scene)| (0..args.scans).map(move |k| (*name, scene, k)))
        .collect();
    let bar = progress(jobs.len() as u64);
    let scans: Result<Vec<[Vec<f64>; 3]>> = jobs
        .par_iter()
        .map(|&(name, scene, k)| {
            let scan = scan(name, scene, k, args);
            bar.inc(1);
            scan
        })
        .collect();
    bar.finish_and_clear();
    let scans = scans?;
    let curves: Vec<Curve> = (0..SPREADS.len())
        .map(|k| Curve::mean(&scans, k, args.rounds))
        .collect();
    match args.format {
        Format::Text => emit(&text(args, &curves)),
        Format::Json => emit(&lines(args, &curves)),
    }
    Ok(ExitCode::SUCCESS)
}

/// Returns the table of shares by round and initial distribution as text.
fn text(args: &Args, curves: &[Curve]) -> String {
    let mut out = format!(
        "Share of particles in high-intensity cells, mean over {} scans each of stairs A, B and C.\n\n\
         {:>5}",
        args.scans, "round"
    );
    for (.., title) in SPREADS {
        let _ = write!(out, "{title:>16}");
    }
    out.push('\n');
    for round in 0..=usize::from(args.rounds) {
        let _ = write!(out, "{round:>5}");
        for (curve, (spread, ..)) in curves.iter().zip(SPREADS) {
            let share = 100.0 * curve.shares[round];
            let mark = match round == usize::from(spread.rounds()) {
                true => '*',
                false => ' ',
            };
            let _ = write!(out, "{share:>13.1} %{mark}");
        }
        out.push('\n');
    }
    let _ = writeln!(
        out,
        "\n* the paper's number of rounds. {:.0} % of the last round's share is reached after:",
        100.0 * CONVERGED
    );
    for (curve, (spread, _, title)) in curves.iter().zip(SPREADS) {
        let _ = writeln!(
            out,
            "  {title:<14} {:>2} rounds (the paper: {})",
            curve.converged(),
            spread.rounds()
        );
    }
    out
}

/// Returns one JSON object, in a line, for each initial distribution.
fn lines(args: &Args, curves: &[Curve]) -> String {
    let objects = curves
        .iter()
        .zip(SPREADS)
        .map(|(curve, (spread, name, _))| {
            let object = json!({
                "spread": name,
                "scans": args.scans,
                "shares": curve.shares,
                "converged_after": curve.converged(),
                "paper_rounds": spread.rounds(),
            });
            format!("{object}\n")
        });
    objects.collect()
}
