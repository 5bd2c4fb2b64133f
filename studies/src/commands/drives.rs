//! `drives`: drives simulated chairs through random scenes by the guard's free distance.

use std::fmt::Write as _;
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Result, ensure};
use serde_json::json;
use stairscan::config::Config;

use super::{Format, emit, may_list, with_list};
use crate::drives::controller::FRONT_M;
use crate::drives::course::Course;
use crate::drives::log::DriveLog;
use crate::drives::outcome::{NEAR_M, Outcome};
use crate::drives::scanner::{self, DriveOptions};
use crate::drives::table::{self, Tally};
use crate::harness;
use host_sim::emulate::session::Waits;
use host_sim::emulate::{guarding, image};
use host_sim::seeds::Draw;
use host_sim::sweeps::scenes::Kind;

/// Arguments of `drives`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Draw of the scenes
    #[arg(long, value_enum, default_value_t = Draw::Tuning)]
    draw: Draw,
    /// Number of scenes of each kind, in place of the draw's own numbers
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=10_000))]
    scenes: Option<u64>,
    /// Number of drives through each scene
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=1_000))]
    drives: u64,
    /// Only scenes of this kind; may be given several times
    #[arg(long = "kind", value_name = "KIND")]
    kinds: Vec<Kind>,
    /// Also list the drives over a hazard, and those that stopped without one; not those of the reporting draw, which
    /// must not be inspected
    #[arg(long)]
    list: bool,
    /// Instead, drive once through each of the first N scenes and replay each drive with the image in the emulator: its
    /// sentences must equal the host's to the byte
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000))]
    emulate: Option<u64>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Returns the number of scenes of each kind: a thousand in all for the reporting draw, for the others as many as two
/// cores compute in five minutes.
const fn scenes(draw: Draw) -> u64 {
    match draw {
        Draw::Reporting => 100,
        _ => 4,
    }
}

impl Args {
    /// Returns kind and seed of every selected scene, kind by kind.
    fn jobs(&self) -> Vec<(Kind, u64)> {
        let wanted = |kind: &Kind| self.kinds.is_empty() || self.kinds.contains(kind);
        let count = self.scenes.unwrap_or(scenes(self.draw)) as usize;
        let of = |kind: Kind| {
            let seeds = kind.seeds(self.draw).take(count);
            seeds.map(move |seed| (kind, seed)).collect::<Vec<_>>()
        };
        Kind::ALL.into_iter().filter(wanted).flat_map(of).collect()
    }

    /// Returns the command that reproduces the tables.
    fn command(&self) -> String {
        let scenes = self.scenes.map(|n| format!(" --scenes {n}"));
        let drives = (self.drives != 10).then(|| format!(" --drives {}", self.drives));
        let kinds = self
            .kinds
            .iter()
            .map(|kind| format!(" --kind {}", kind.name()));
        let all: String = scenes.into_iter().chain(drives).chain(kinds).collect();
        format!("cargo study drives --draw {}{all}", self.draw)
    }
}

/// Drives `drives` times through one random scene, and returns the log of each drive.
fn through(kind: Kind, seed: u64, drives: u64) -> Result<Vec<DriveLog>> {
    let course = Course::new(kind, seed)?;
    let ways = course.ways();
    let drive = |number| scanner::drive(&course, &ways, number, DriveOptions::default());
    (0..drives).map(|number| Ok(drive(number)?.log)).collect()
}

/// Drives once through each of the first `drives` scenes, cycling through the kinds, and replays each drive with the
/// firmware image in the emulator. A sentence that differs from the host's is an error.
fn emulate(jobs: &[(Kind, u64)], drives: u64) -> Result<ExitCode> {
    let elf = image::build(&[])?;
    let kinds = jobs.chunk_by(|a, b| a.0 == b.0).collect::<Vec<_>>();
    let longest = kinds.iter().map(|kind| kind.len()).max().unwrap_or(0);
    let in_turn = (0..longest).flat_map(|k| kinds.iter().filter_map(move |kind| kind.get(k)));
    let mut differ = 0;
    let mut out = String::from("| drive | sweeps | the image's sentences |\n|---|---|---|\n");
    for (kind, seed) in in_turn.take(drives as usize) {
        let course = Course::new(*kind, *seed)?;
        let options = DriveOptions {
            by_trigger: true,
            is_kept: true,
        };
        let driven = scanner::drive(&course, &course.ways(), 0, options)?;
        let sweeps = driven.sentences.len();
        let with = (Waits::default(), &[][..]);
        let config = Config::default();
        let found = guarding::sentences(&elf, &driven.recording, &config, sweeps, with)?;
        let alike = found
            .iter()
            .zip(&driven.sentences)
            .filter(|(a, b)| a == b)
            .count();
        differ += sweeps - alike;
        let _ = writeln!(out, "| {} | {sweeps} | {alike} the same |", driven.log.name);
    }
    emit(&out);
    ensure!(
        differ == 0,
        "{differ} sentences of the image differ from the host's"
    );
    Ok(ExitCode::SUCCESS)
}

/// Returns the rows of the table of outcomes: name and counts for each kind of scene, then for all drives.
fn rows(jobs: &[(Kind, u64)], logs: &[Vec<DriveLog>]) -> Vec<(&'static str, Tally)> {
    let of = |kind: Kind| {
        let own = jobs.iter().zip(logs).filter(move |((k, _), _)| *k == kind);
        own.flat_map(|(_, logs)| logs)
    };
    let kinds = Kind::ALL
        .into_iter()
        .filter(|kind| of(*kind).next().is_some());
    let mut rows: Vec<_> = kinds
        .map(|kind| (kind.name(), Tally::of(of(kind))))
        .collect();
    rows.push(("all", Tally::of(logs.iter().flatten())));
    rows
}

/// Returns the heading, and the tables of outcomes, causes and halts.
fn text(args: &Args, rows: &[(&str, Tally)], logs: &[DriveLog]) -> String {
    let mut out = format!(
        "# Drives, {} scenes\n\nMade by `{}`: chairs whose joystick asks for 0.2 to 0.8 m/s drive \
         by the free distance of the newest guard sentence. The chair's foremost point lies \
         {FRONT_M:.2} m before the mirror; gaps count from there. A chair has stopped when it does \
         not move for 1.5 s with the joystick forward.\n\n",
        args.draw,
        args.command()
    );
    out += table::HEADING;
    out.extend(rows.iter().map(|(name, tally)| table::row(name, tally)));
    out + "\n" + &table::causes_text(logs) + "\n" + &table::halts_text(logs)
}

/// Formats one drive in one line: outcome, hazard, distance travelled and last answer.
fn line(log: &DriveLog) -> String {
    let last = log.sweeps.last();
    let cm = |m: Option<f64>| m.map_or("-".into(), |m| format!("{:.0}", 100.0 * m));
    format!(
        "{}: {:?}, hazard {} cm {}, travel {:.0} cm in {:.1} s, last free {} cm, ground echo up to {} cm",
        log.name,
        Outcome::of(log),
        cm(log.hazard.map(|hazard| hazard.at_m)),
        log.hazard.map_or("none", |hazard| hazard.kind.as_str()),
        100.0 * log.travel_m,
        log.time_s,
        cm(last.and_then(|sweep| sweep.answer.free_m)),
        cm(last.map(|sweep| sweep.ground_echo_range_m)),
    )
}

/// Returns one line for each drive over a hazard, and for each that stopped without one or unnecessarily early.
fn listed(logs: &[DriveLog]) -> Vec<String> {
    let flawed = logs.iter().filter(|log| match Outcome::of(log) {
        Outcome::DroveOver { .. } | Outcome::StoppedWithoutHazard => true,
        Outcome::StoppedEarly {
            gap_m,
            has_ground_echo,
        } => has_ground_echo && gap_m > NEAR_M,
        _ => false,
    });
    flawed.map(line).collect()
}

/// Drives through all scenes, and prints the tables of outcomes.
pub fn run(args: &Args) -> Result<ExitCode> {
    may_list("--list", args.list, "drives", args.draw)?;
    let jobs = args.jobs();
    if let Some(drives) = args.emulate {
        return emulate(&jobs, drives);
    }
    let begun = Instant::now();
    let logs = harness::each(&jobs, |(kind, seed)| through(*kind, *seed, args.drives))?;
    let rows = rows(&jobs, &logs);
    let logs = logs.concat();
    host_sim::note!(
        "{} drives in {:.0} s",
        logs.len(),
        begun.elapsed().as_secs_f64()
    );
    let list = if args.list { listed(&logs) } else { Vec::new() };
    emit(&match args.format {
        Format::Text => with_list(text(args, &rows, &logs), "To inspect", &list),
        Format::Json => {
            let kinds: Vec<_> = rows.iter().map(|(name, tally)| tally.json(name)).collect();
            let causes = table::causes(&logs).into_iter();
            let causes: Vec<_> = causes
                .map(|((cause, has_ground_echo), n)| json!({"cause": cause.as_str(), "shows": has_ground_echo, "drives": n}))
                .collect();
            format!(
                "{}\n",
                json!({
                    "draw": args.draw.as_str(), "rows": kinds, "causes": causes,
                    "halts": table::halts(&logs), "list": list,
                })
            )
        }
    });
    Ok(ExitCode::SUCCESS)
}
