//! `table1`: scans the paper's stairs A, B and C and compares with the figures of its table I.

use std::fmt::Write as _;
use std::process::ExitCode;

use anyhow::{Context as _, Result};
use rayon::prelude::*;
use serde_json::json;
use stairscan::config::Config;

use super::{Format, Settings, emit, progress};
use crate::instrument::Instrument;
use host_sim::answer::{Answer, metres};
use host_sim::recording::{TrueStep, Truth};
use host_sim::replay;
use host_sim::scene::Scene;
use host_sim::scene::spec::SceneSpec;
use host_sim::score;

/// Arguments of `table1`.
#[derive(clap::Args, Debug)]
pub struct Args {
    #[command(flatten)]
    settings: Settings,
    /// Number of scans of each staircase, with the seeds 0, 1, … for surfaces, noise and particles
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    scans: u32,
    #[command(flatten)]
    instrument: Instrument,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Number of steps of each of the paper's staircases.
const STEPS: usize = 3;

/// Maximum horizontal distance between a reported step and the true one for a match, metres (as in `score`).
const NEAR_M: f64 = 0.10;

/// A staircase of the paper: its scene, and its row of the paper's table I, which gives the errors of each step's depth
/// and height, centimetres.
struct Stair {
    name: &'static str,
    scene: &'static str,
    depth_cm: [f64; STEPS],
    height_cm: [f64; STEPS],
}

const STAIRS: [Stair; 3] = [
    Stair {
        name: "Stair A",
        scene: include_str!("../../../scenes/stair_a.toml"),
        depth_cm: [0.2, 0.4, 0.3],
        height_cm: [0.5, 0.7, 1.0],
    },
    Stair {
        name: "Stair B",
        scene: include_str!("../../../scenes/stair_b.toml"),
        depth_cm: [0.1, 0.3, 0.5],
        height_cm: [0.3, 1.0, 1.2],
    },
    Stair {
        name: "Stair C",
        scene: include_str!("../../../scenes/stair_c.toml"),
        depth_cm: [0.2, 0.1, 0.4],
        height_cm: [0.6, 0.6, 1.5],
    },
];

/// Results of one staircase: number of exact scans, and for each step the number of scans in which it was found and the
/// sums of its absolute errors of depth (distance from the mirror) and height, metres.
#[derive(Default)]
struct Row {
    exact: u32,
    found: [u32; STEPS],
    depth_sum: [f64; STEPS],
    height_sum: [f64; STEPS],
}

impl Row {
    fn add(&mut self, answer: &Answer, truth: &Truth) {
        self.exact += u32::from(score::scene(answer, truth).exact);
        if answer.is_fault() {
            return;
        }
        for (k, step) in truth.steps.iter().take(STEPS).enumerate() {
            if let Some((depth, height)) = errors(answer, step) {
                self.found[k] += 1;
                self.depth_sum[k] += depth;
                self.height_sum[k] += height;
            }
        }
    }

    /// Returns the mean absolute error of step `k` over the scans in which it was found, cm; `None` if there are none.
    /// `sums` are the steps' error sums of depth or of height, metres.
    fn mean_cm(&self, sums: &[f64; STEPS], k: usize) -> Option<f64> {
        (self.found[k] > 0).then(|| 100.0 * sums[k] / f64::from(self.found[k]))
    }
}

/// Returns the absolute errors of depth and height, metres, of the reported step nearest to a true one; `None` if there
/// is none within 10 cm.
fn errors(answer: &Answer, truth: &TrueStep) -> Option<(f64, f64)> {
    let off = answer.steps.iter().map(|s| {
        let depth = (metres(s.distance) - truth.distance_m).abs();
        (depth, (metres(s.height) - truth.height_m).abs())
    });
    off.filter(|(depth, _)| *depth <= NEAR_M)
        .min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Scans every staircase and prints the table.
pub fn run(args: &Args) -> Result<ExitCode> {
    let base = args.settings.config()?;
    let bar = progress(u64::from(args.scans) * STAIRS.len() as u64);
    let mut rows = Vec::new();
    for stair in &STAIRS {
        let mut spec: SceneSpec = toml::from_str(stair.scene).context(stair.name)?;
        args.instrument.apply(&mut spec);
        let scene = Scene::new(spec).context(stair.name)?;
        let answers: Vec<Result<(Answer, Truth)>> = (0..args.scans)
            .into_par_iter()
            .map(|k| {
                let recording = scene.simulate(stair.name, k.into());
                let config = Config {
                    seed: base.seed.wrapping_add(k),
                    ..base
                };
                let answer = replay::answer(&recording, &args.settings.options(config))?;
                bar.inc(1);
                Ok((answer, recording.meta.truth.unwrap_or_default()))
            })
            .collect();
        let mut row = Row::default();
        for answer in answers {
            let (answer, truth) = answer?;
            row.add(&answer, &truth);
        }
        rows.push(row);
    }
    bar.finish_and_clear();
    match args.format {
        Format::Text => emit(&text(args, &rows)),
        Format::Json => emit(&lines(args, &rows)),
    }
    Ok(ExitCode::SUCCESS)
}

/// Returns the table of errors, beside the paper's, as text.
fn text(args: &Args, rows: &[Row]) -> String {
    let mut out = format!(
        "Mean absolute errors over {} scans each, estimator {}{}; in brackets the paper's table I.\n\n\
         {:<8}|{:^36}|{:^36}| exact\n{:<8}|",
        args.scans,
        args.settings.estimator_name(),
        match args.instrument.options() {
            options if options.is_empty() => options,
            options => format!(", with{options}"),
        },
        "",
        "depth [cm]",
        "height [cm]",
        ""
    );
    for _ in 0..2 {
        for k in 1..=STEPS {
            let _ = write!(out, "{:^12}", format!("step {k}"));
        }
        out.push('|');
    }
    out.push('\n');
    for (stair, row) in STAIRS.iter().zip(rows) {
        let _ = write!(out, "{:<8}|", stair.name);
        for (sums, book) in [
            (&row.depth_sum, &stair.depth_cm),
            (&row.height_sum, &stair.height_cm),
        ] {
            for (k, paper) in book.iter().enumerate() {
                let mean = row.mean_cm(sums, k);
                let mean = mean.map_or("-".into(), |m| format!("{m:.2}"));
                let _ = write!(out, "{:>6} {:<5}", mean, format!("({paper})"));
            }
            out.push('|');
        }
        let _ = writeln!(out, " {}/{}", row.exact, args.scans);
    }
    let all: u32 = rows.iter().map(|r| r.exact).sum();
    let of = args.scans * rows.len() as u32;
    let share = 100.0 * f64::from(all) / f64::from(of);
    let _ = writeln!(
        out,
        "\nAll three steps and nothing else: {all}/{of} ({share:.0} %); the paper gives no rate."
    );
    let missing: Vec<String> = (STAIRS.iter().zip(rows))
        .flat_map(|(stair, row)| {
            row.found.iter().enumerate().map(move |(k, n)| {
                (*n < args.scans).then(|| format!("{} step {}: {n}", stair.name, k + 1))
            })
        })
        .flatten()
        .collect();
    if !missing.is_empty() {
        let _ = writeln!(
            out,
            "Errors are those of the steps found; found in fewer than all scans: {}.",
            missing.join(", ")
        );
    }
    out
}

/// Returns one JSON object, in a line, for each staircase.
fn lines(args: &Args, rows: &[Row]) -> String {
    let objects = STAIRS.iter().zip(rows).map(|(stair, row)| {
        let means = |sums| [0, 1, 2].map(|k| row.mean_cm(sums, k));
        let object = json!({
            "stair": stair.name,
            "estimator": args.settings.estimator_name(),
            "scans": args.scans,
            "exact": row.exact,
            "found": row.found,
            "depth_error_cm": means(&row.depth_sum),
            "height_error_cm": means(&row.height_sum),
            "paper_depth_error_cm": stair.depth_cm,
            "paper_height_error_cm": stair.height_cm,
        });
        format!("{object}\n")
    });
    objects.collect()
}
