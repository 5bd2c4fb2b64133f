//! `faults`: applies every fault of the instrument to recordings that are answered correctly without it.

mod fate;
mod guarded;
mod signs;

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, ensure};
use indicatif::ParallelProgressIterator;
use rayon::prelude::*;
use serde_json::json;
use stairscan::config::to_fixed;
use stairscan::verdict::Status;

use super::{Format, Settings, emit, progress};
use crate::faults::{ALL, Fault};
use crate::harness::{self, Drawn};
use fate::{Clean, Fate, Run, SEEDS};
use host_sim::answer::Answer;
use host_sim::recording::{self, Recording};
use host_sim::replay::{self, Options};
use host_sim::score;
use host_sim::seeds::Draw;

/// Arguments of `faults`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Recordings with ground truth in this directory in place of simulated scenes
    #[arg(long)]
    on: Option<PathBuf>,
    /// Draw of the scenes
    #[arg(long, value_enum, default_value_t)]
    draw: Draw,
    /// Number of scenes of each kind with answers that a fault can change
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    scenes: u64,
    /// The mirror echo of each recording is calibrated, from the recording without a fault
    #[arg(long)]
    calibrated: bool,
    /// Only these kinds of faults
    #[arg(long)]
    kind: Vec<String>,
    /// One line for each strength
    #[arg(long)]
    strengths: bool,
    /// Print the values of the health checks in scenes without a fault, and how often a check fails; no fault is
    /// applied
    #[arg(long)]
    signs: bool,
    /// On guard sweeps: those of the kinds of `guard`, or with --on the recordings of them; counted from the third
    /// sweep on; without the faults that remove or shift rows
    #[arg(long, conflicts_with_all = ["calibrated", "signs"])]
    guard: bool,
    /// Fail if more than this percentage of all runs is `ok` and wrong
    #[arg(long, default_value_t = 100.0)]
    most: f64,
    /// List every run that is `ok` and wrong
    #[arg(long)]
    list: bool,
    #[command(flatten)]
    settings: Settings,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Numbers of runs by outcome, in the order of [`Fate`]. A run is one fault of one strength on one recording or guard
/// sweep.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    counts: [u32; 5],
    /// Number of runs in which the answer's reasons name the fault, `fault` answers included.
    named: u32,
}

impl Tally {
    fn add(&mut self, run: &Run) {
        self.counts[run.fate as usize] += 1;
        self.named += u32::from(run.named);
    }

    fn sum<'a>(tallies: impl Iterator<Item = &'a Tally>) -> Self {
        tallies.fold(Self::default(), |mut sum, t| {
            sum.counts
                .iter_mut()
                .zip(t.counts)
                .for_each(|(a, b)| *a += b);
            sum.named += t.named;
            sum
        })
    }

    /// Returns the share of runs that are `ok` and wrong, percent.
    fn wrong_percent(&self) -> f64 {
        100.0 * f64::from(self.counts[Fate::Wrong as usize]) / f64::from(self.runs().max(1))
    }

    fn runs(&self) -> u32 {
        self.counts.iter().sum()
    }
}

/// Applies the faults to recordings, scores the answers, and prints the table.
pub fn run(args: &Args) -> Result<ExitCode> {
    let faults = chosen(&args.kind)?;
    let options = args.settings.options(args.settings.config()?);
    if args.signs {
        emit(&signs::table(&single(args)?, &options)?);
        return Ok(ExitCode::SUCCESS);
    }
    let clean = match args.guard {
        true => guarded::clean(args.on.as_deref(), (args.draw, args.scenes), &options)?,
        false => clean(args, &options)?,
    };
    let options = |recording: usize| {
        let mut own = options;
        if args.calibrated {
            own.config.mount.mirror_echo = clean.mirror_echoes[recording];
        }
        own
    };
    ensure!(
        !clean.recordings.is_empty(),
        "none of {} recordings is ok and right without a fault: no answer to test",
        clean.all
    );
    let jobs: Vec<(usize, usize, usize)> = (0..faults.len())
        .flat_map(|f| (0..faults[f].strengths.len()).map(move |s| (f, s)))
        .flat_map(|(f, s)| (0..clean.recordings.len()).map(move |r| (f, s, r)))
        .collect();
    let bar = progress(jobs.len() as u64);
    let runs: Result<Vec<Vec<Run>>> = jobs
        .par_iter()
        .progress_with(bar.clone())
        .map(|&(f, s, r)| {
            let (fault, recording) = (faults[f], &clean.recordings[r]);
            let strength = fault.strengths[s];
            if args.guard {
                return guarded::one((fault, strength), recording, r, &options(r));
            }
            let run = one(fault, strength, recording, SEEDS + r as u64, &options(r));
            run.map(|run| vec![run])
        })
        .collect();
    bar.finish_and_clear();
    let runs = runs?;
    let mut tallies: Vec<Vec<Tally>> = faults
        .iter()
        .map(|f| vec![Tally::default(); f.strengths.len()])
        .collect();
    for (&(f, s, _), runs) in jobs.iter().zip(&runs) {
        runs.iter().for_each(|run| tallies[f][s].add(run));
    }
    let mut out = match args.format {
        Format::Json => lines(&faults, &tallies, &clean),
        Format::Text => table(&faults, &tallies, &clean, args.strengths),
    };
    if args.list && args.format == Format::Text {
        for run in runs.iter().flatten().filter(|run| run.fate == Fate::Wrong) {
            let _ = writeln!(out, "{}", run.words);
        }
    }
    emit(&out);
    let share = Tally::sum(tallies.iter().flatten()).wrong_percent();
    if share > args.most {
        host_sim::note!(
            "error: {share:.2} % of all runs are ok and wrong, at most {} allowed",
            args.most
        );
    }
    Ok(ExitCode::from(u8::from(share > args.most)))
}

/// Returns the faults of these names; all if there are none.
fn chosen(names: &[String]) -> Result<Vec<&'static Fault>> {
    let all = || ALL.iter().map(|f| f.name).collect::<Vec<_>>().join(", ");
    let found = |name: &String| {
        Fault::named(name).with_context(|| format!("--kind: \"{name}\": expected one of {}", all()))
    };
    match names {
        [] => Ok(ALL.iter().collect()),
        names => names.iter().map(found).collect(),
    }
}

/// Returns recordings of single scans with ground truth. Sequences are left out: their faults are those of single
/// scans.
fn single(args: &Args) -> Result<Vec<Recording>> {
    let read = |path: &PathBuf| Recording::read(path);
    let whole: Vec<Recording> = match &args.on {
        Some(dir) => recording::list(dir)?
            .par_iter()
            .map(read)
            .collect::<Result<_>>()?,
        None => {
            let mut scenes = harness::scenes(args.draw, |_| args.scenes);
            // The random numbers of a fault depend on the recording's index. Sorted by seed, the first scenes are
            // unchanged if there are more of each kind.
            scenes.sort_by_key(|drawn| drawn.seed);
            harness::each(&scenes, Drawn::scan)?
        }
    };
    let single = |r: &Recording| r.scans() == 1 && r.truth(0).is_some();
    Ok(whole.into_iter().filter(single).collect())
}

/// Returns the recordings that are `ok` and correct without a fault, to which faults are then applied.
fn clean(args: &Args, options: &Options) -> Result<Clean> {
    let single = single(args)?;
    let judged: Result<Vec<(bool, bool, i32)>> = single
        .par_iter()
        .map(|recording| {
            let mut echo = 0;
            let first = Options {
                scans: Some(1),
                ..*options
            };
            let answers = replay::answers(recording, &first, |scanned| {
                let seen_m = scanned.pipeline.health().mirror_echo_m(scanned.config);
                echo = to_fixed(seen_m.into(), 1e-5).unwrap_or(0).max(0);
            })?;
            let Some(answer) = answers.first() else {
                return Ok((false, false, 0));
            };
            let ok = answer.scan.status == Status::Ok;
            Ok((ok, ok && !wrong(answer, recording), echo))
        })
        .collect();
    let judged = judged?;
    let all = single.len();
    let ok = judged.iter().filter(|j| j.0).count();
    let right = single.into_iter().zip(judged).filter(|(_, j)| j.1);
    let (recordings, mirror_echoes) = right.map(|(recording, j)| (recording, j.2)).unzip();
    Ok(Clean {
        recordings,
        mirror_echoes,
        ok,
        all,
    })
}

fn wrong(answer: &Answer, recording: &Recording) -> bool {
    recording
        .truth(0)
        .is_some_and(|truth| score::scene(answer, truth).wrong)
}

/// Applies one fault to one recording and scores the answer.
fn one(
    fault: &Fault,
    strength: f64,
    recording: &Recording,
    seed: u64,
    options: &Options,
) -> Result<Run> {
    let faulty = fault.on(recording, strength, seed)?;
    let answer = replay::answer(&faulty, options)
        .with_context(|| format!("{} {strength} on {}", fault.name, recording.name))?;
    let reasons = answer.scan.reasons;
    let named = fault.reasons.iter().any(|&reason| reasons.has(reason));
    let fate = match answer.scan.status {
        Status::Fault => Fate::Fault,
        Status::Degraded if named => Fate::Named,
        Status::Degraded => Fate::Unnamed,
        Status::Ok if wrong(&answer, &faulty) => Fate::Wrong,
        Status::Ok => Fate::Right,
    };
    let words = format!(
        "{} {strength} {} on {}",
        fault.name, fault.unit, recording.name
    );
    Ok(Run { fate, named, words })
}

/// Returns the table of outcomes (numbers of runs) for each fault, and for each strength of it if `strengths`.
fn table(faults: &[&Fault], tallies: &[Vec<Tally>], clean: &Clean, strengths: bool) -> String {
    let mut out = format!(
        "{} recordings, {} ok without a fault, {} of them right: faults are applied to these.\n\n| \
         fault | strength | runs | fault | degraded, named | degraded | ok and right | ok and wrong \
         | named |\n|---|---|---|---|---|---|---|---|---|\n",
        clean.all,
        clean.ok,
        clean.recordings.len()
    );
    let mut line = |name: &str, strength: &str, tally: &Tally| {
        let counts = tally.counts.map(|n| n.to_string()).join(" | ");
        let named = 100.0 * f64::from(tally.named) / f64::from(tally.runs().max(1));
        let runs = tally.runs();
        let _ = writeln!(
            out,
            "| {name} | {strength} | {runs} | {counts} | {named:.0} % |"
        );
    };
    for (fault, tallies) in faults.iter().zip(tallies) {
        if strengths {
            for (strength, tally) in fault.strengths.iter().zip(tallies) {
                line(fault.name, &format!("{strength} {}", fault.unit), tally);
            }
            continue;
        }
        let span = match fault.strengths {
            [only] => format!("{only} {}", fault.unit),
            [first, .., last] => format!("{first} to {last} {}", fault.unit),
            [] => String::new(),
        };
        line(fault.name, &span, &Tally::sum(tallies.iter()));
    }
    let total = Tally::sum(tallies.iter().flatten());
    line("all", "", &total);
    let share = total.wrong_percent();
    let _ = writeln!(out, "\nok and wrong: {share:.2} % of all runs.");
    out
}

/// Returns one line of JSON for every fault and strength.
fn lines(faults: &[&Fault], tallies: &[Vec<Tally>], clean: &Clean) -> String {
    let mut out = String::new();
    for (fault, tallies) in faults.iter().zip(tallies) {
        for (strength, tally) in fault.strengths.iter().zip(tallies) {
            let [faults, named, unnamed, right, wrong] = tally.counts;
            let line = json!({
                "fault": fault.name, "strength": strength, "unit": fault.unit,
                "runs": tally.runs(), "faults": faults, "degraded_named": named,
                "degraded_unnamed": unnamed, "ok_and_right": right, "ok_and_wrong": wrong,
                "named": tally.named, "recordings": clean.all, "ok_without": clean.ok,
            });
            let _ = writeln!(out, "{line}");
        }
    }
    out
}
