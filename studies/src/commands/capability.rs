//! `capability`: the data sheet of the detectable hazards, with probabilities and response times.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, anyhow};
use stairscan::scanner::Settings;
use stairscan::signal::radar::wire::Wire;

use super::{Format, emit, timing};
use crate::capability::document::{self, Part};
use crate::capability::measure;
use crate::capability::plan::{self, Cell};
use crate::capability::results::{Heading, Measured, Times, json};
use crate::capability::sheet;
use crate::capability::tally::Tally;
use crate::harness;
use host_sim::budgets::POST;
use host_sim::output::Overwrite;
use host_sim::seeds::Draw;

/// Default number of scenes of most cells of the measurement.
pub const SCENES: u64 = 30;
/// Default number of scenes of each rise and drop: a bound of 99 % at 95 % confidence needs 299 without a miss.
pub const OF_A_SIZE: u64 = 300;
/// Number of scenes of each rise and drop on the second draw, as a multiple of most cells'.
const SECOND_TIMES: u64 = 10;
/// The second draw, by which the confidence bounds of the first are tested.
const SECOND: Draw = Draw::Validation;
/// Rate of the radar link for which the response times are calculated, baud.
const BAUD: u32 = 3_000_000;
/// Acceleration of the mirror for the guard's eight sweeps a second, microsteps/s².
const ACCELERATION: u32 = 4_000_000;
/// Clock frequency of the core, Hz.
const CORE_HZ: f64 = 168e6;
/// Directory of the document's drawings.
const DRAWINGS: &str = "capability";

/// Arguments of `capability`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Draw of the scenes
    #[arg(long, value_enum, default_value_t = Draw::Tuning)]
    draw: Draw,
    /// Number of scenes of most cells; level ground takes four times as many, drives a quarter
    #[arg(long, default_value_t = SCENES, value_parser = clap::value_parser!(u64).range(1..=plan::MAX_SCENES))]
    scenes: u64,
    /// Number of scenes of each size of a rise or drop at 1 m behind a clean window
    #[arg(long, value_name = "SCENES", default_value_t = OF_A_SIZE, value_parser = clap::value_parser!(u64).range(1..=plan::MAX_OF_A_SIZE))]
    sizes: u64,
    /// Check the bounds against a second draw of validation seeds, with this number of scenes of most cells and ten
    /// times as many of each size
    #[arg(long, value_name = "SCENES", value_parser = clap::value_parser!(u64).range(1..=plan::MAX_SCENES))]
    second: Option<u64>,
    /// Only this test body (rise, drop, post, closed-stairs, open-stairs, stairs-down, level); may be given several times
    #[arg(long = "body", value_name = "BODY", value_parser = plan::KINDS)]
    bodies: Vec<String>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Also write the sheet as a page for any browser
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Also write the drawings of the sheet, as SVG, into this directory
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

impl Args {
    /// Returns the cells of the selected bodies, with `scenes` scenes in most, and `of_a_size` for each rise and drop.
    fn cells(&self, scenes: u64, of_a_size: u64) -> Vec<Cell> {
        let wanted = |cell: &Cell| {
            let kind = cell.body.kind();
            cell.scenes > 0 && (self.bodies.is_empty() || self.bodies.iter().any(|b| b == kind))
        };
        let all = plan::cells(scenes as usize, of_a_size as usize);
        all.into_iter().filter(wanted).collect()
    }

    /// Returns the command that reproduces the sheet.
    fn command(&self) -> String {
        let mut words = format!("cargo study capability --draw {}", self.draw);
        if self.scenes != SCENES {
            words += &format!(" --scenes {}", self.scenes);
        }
        if self.sizes != OF_A_SIZE {
            words += &format!(" --sizes {}", self.sizes);
        }
        if let Some(second) = self.second {
            words += &format!(" --second {second}");
        }
        let bodies = self.bodies.iter().map(|body| format!(" --body {body}"));
        words + &bodies.collect::<String>()
    }
}

/// Returns the head of the sheet of a draw as Markdown, with the numbers of scenes of most cells and of each rise and
/// drop. A test compares the document with it.
///
/// # Errors
/// Those of the timing model.
pub fn heading(draw: Draw, [scenes, sizes]: [u64; 2], second: Option<u64>) -> Result<String> {
    let args = Args {
        draw,
        scenes,
        sizes,
        second,
        bodies: Vec::new(),
        format: Format::Text,
        output: None,
        plots: None,
        overwrite: Overwrite::default(),
    };
    let parts = sheet::head(&head(&args)?);
    Ok(document::markdown(&parts, DRAWINGS))
}

fn head(args: &Args) -> Result<Heading> {
    Ok(Heading {
        command: args.command(),
        draw: args.draw,
        times: times()?,
    })
}

/// Returns the durations of a scan and of a guard sweep according to `cargo sim timing`.
fn times() -> Result<Times> {
    let wire = Wire {
        baud: BAUD,
        ahead: true,
        pin: false,
    };
    let settings = Settings::default();
    let modes = timing::modes(&settings, &[wire])?;
    let scan = modes.iter().find(|time| time.mode == "continuous");
    let mut fast = settings;
    fast.motor.acceleration = ACCELERATION;
    let sweeps = timing::guard::sweeps(&fast, &[wire])?;
    let sweep = sweeps.iter().find(|time| time.module == "pstr");
    let (scan, sweep) = scan
        .zip(sweep)
        .context("no duration of a continuous sweep")?;
    Ok(Times {
        scan_s: 1e-6 * scan.total() as f64 + POST as f64 / CORE_HZ,
        sweep_s: 1e-6 * sweep.total() as f64,
    })
}

/// Simulates and classifies all scenes of the cells on a draw. Returns one tally for each cell, in their order.
fn measured(cells: &[Cell], draw: Draw) -> Result<Vec<Tally>> {
    let of = |(k, cell): (usize, &Cell)| {
        let seeds = cell.seeds(draw).enumerate();
        seeds
            .map(move |(turn, seed)| (k, turn, seed))
            .collect::<Vec<_>>()
    };
    let jobs: Vec<(usize, usize, u64)> = cells.iter().enumerate().flat_map(of).collect();
    let seen = harness::each(&jobs, |&(k, turn, seed)| {
        measure::measure(&cells[k], turn, seed)
    })?;
    let mut rest = seen.as_slice();
    let tallies = cells.iter().map(|cell| {
        let (own, others) = rest.split_at_checked(cell.scenes)?;
        rest = others;
        Some(Tally::of(own))
    });
    let tallies: Option<Vec<Tally>> = tallies.collect();
    tallies.ok_or_else(|| anyhow!("fewer outcomes than scenes"))
}

/// Measures the detection probability at each distance, yaw and speed, prints the capability sheet, and writes its
/// HTML page and plots where asked for.
pub fn run(args: &Args) -> Result<ExitCode> {
    let outputs = args.overwrite.reading::<&str>([]);
    args.output
        .iter()
        .try_for_each(|path| outputs.check(path))?;
    let cells = args.cells(args.scenes, args.sizes);
    let tallies = measured(&cells, args.draw)?;
    let second = match args.second {
        None => None,
        Some(scenes) => {
            let cells = args.cells(scenes, (SECOND_TIMES * scenes).min(args.sizes));
            let tallies = measured(&cells, SECOND)?;
            Some(cells.into_iter().zip(tallies).collect())
        }
    };
    let measured = Measured {
        head: head(args)?,
        cells: cells.into_iter().zip(tallies).collect(),
        second,
    };
    let parts = sheet::parts(&measured);
    if let Some(path) = &args.output {
        let page = document::page("Capability of stairscan", &parts);
        outputs.write(path, page.as_bytes())?;
    }
    if let Some(directory) = &args.plots {
        for part in &parts {
            if let Part::Figure { file, svg, .. } = part {
                outputs.write_picture(&directory.join(file), svg.as_bytes())?;
            }
        }
    }
    emit(&match args.format {
        Format::Text => document::markdown(&parts, DRAWINGS),
        Format::Json => format!("{}\n", json(&measured)),
    });
    Ok(ExitCode::SUCCESS)
}
