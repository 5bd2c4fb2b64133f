//! `guard`: measures the free distance on guard sweeps of random scenes.

use std::process::ExitCode;

use anyhow::{Context, Result};
use serde_json::json;

use super::{Format, emit, may_list, with_list};
use crate::harness;
use host_sim::replay::{self, Options};
use host_sim::score::Share;
use host_sim::seeds::Draw;
use host_sim::sweeps::scenes::{self, Kind};
use host_sim::sweeps::score::{self, GuardAnswer, Scored, Sums, Sweep};
use host_sim::sweeps::{ground, truth};

/// Arguments of `guard`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Draw of the scenes
    #[arg(long, value_enum, default_value_t = Draw::Tuning)]
    draw: Draw,
    /// Number of recordings of each kind, in place of the draw's own numbers
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=10_000))]
    recordings: Option<u64>,
    /// Only scenes of this kind; may be given several times
    #[arg(long = "kind", value_name = "KIND")]
    kinds: Vec<Kind>,
    /// Also list the sweeps that are `ok` and wrong, and false rises and drops; not those of the reporting draw, which
    /// must not be inspected
    #[arg(long)]
    list: bool,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

impl Args {
    /// Returns the number of recordings of a kind; 0 if it is not selected.
    fn count(&self, kind: Kind) -> u64 {
        match self.kinds.is_empty() || self.kinds.contains(&kind) {
            true => self.recordings.unwrap_or(kind.recordings(self.draw)),
            false => 0,
        }
    }

    /// Returns kind and seed of every selected recording, kind by kind.
    fn jobs(&self) -> Vec<(Kind, u64)> {
        let of = |kind: Kind| {
            let seeds = kind.seeds(self.draw).take(self.count(kind) as usize);
            seeds.map(move |seed| (kind, seed)).collect::<Vec<_>>()
        };
        Kind::ALL.into_iter().flat_map(of).collect()
    }

    /// Returns the command that reproduces the table.
    fn command(&self) -> String {
        let count = self.recordings.map(|n| format!(" --recordings {n}"));
        let kinds = self
            .kinds
            .iter()
            .map(|kind| format!(" --kind {}", kind.name()));
        let all: String = count.into_iter().chain(kinds).collect();
        format!("cargo study guard --draw {}{all}", self.draw)
    }
}

/// Simulates one recording, sweeps it with the scanner's own loop and scores the answers.
fn one(kind: Kind, seed: u64) -> Result<Scored> {
    let recording = scenes::recording(kind, seed)?;
    let truth = truth::read(&recording)?.context("a simulated recording has its truth")?;
    let words = replay::guarded(&recording, &Options::default())?;
    let words: Vec<GuardAnswer> = words.iter().map(GuardAnswer::of).collect();
    let ground_echo_range_m = ground::of(&recording)?;
    Ok(score::recording(
        &recording.name,
        &words,
        &truth,
        &ground_echo_range_m,
    ))
}

/// A row of the table: its name, and the sums over its guard sweeps.
type Group<'a> = (&'a str, Sums);

/// Returns the rows of the table of scores: each kind of scene, then all sweeps, those with a hazard within 1.5 m, and
/// those without a hazard.
fn groups(jobs: &[(Kind, u64)], scored: &[Scored]) -> Vec<Group<'static>> {
    let of = |kind: Kind| {
        let own = jobs
            .iter()
            .zip(scored)
            .filter(move |((k, _), _)| *k == kind);
        own.map(|(_, scored)| scored)
    };
    let kinds = Kind::ALL
        .into_iter()
        .filter(|kind| of(*kind).next().is_some());
    let mut rows: Vec<Group<'_>> = kinds
        .map(|kind| (kind.name(), Sums::of(of(kind), |_| true)))
        .collect();
    let near = |sweep: &Sweep| sweep.hazard.is_some_and(|h| h.at_m <= score::NEAR_M);
    rows.push(("all", Sums::of(scored.iter(), |_| true)));
    rows.push(("all, hazard within 1.5 m", Sums::of(scored.iter(), near)));
    let free = Sums {
        // The shares of named hazards are counted by recording, not by sweep.
        named: Share::default(),
        named_with_echo: Share::default(),
        ..Sums::of(scored.iter(), |sweep| sweep.hazard.is_none())
    };
    rows.push(("all, without a hazard", free));
    rows
}

/// Returns heading and table of the scores.
fn text(args: &Args, rows: &[Group<'_>]) -> String {
    let mut out = format!(
        "# Guard, {} sweeps\n\nMade by `{}`: {} sweeps of 31 rows in each recording, ten a second, \
         alternately forward and backward, of random scenes; the chair drives at 0.1 to 0.6 m/s, \
         stands in 15 %, and has a pitch error of up to 0.4° that is not in the recording. Sweeps \
         are counted from the third on. Wrong is a free distance that ends more than 5 cm beyond \
         the first hazard (from the second sweep on with a person who steps in); useful one that is \
         `ok`, not wrong and at least the hazard's, or 1.2 m, less 25 cm. With ground echo: the \
         ground's echo, averaged over a beam's rows, 10 cm of range and three sweeps, exceeds the \
         noise by 3 dB up to the hazard. Objects more than 8 cm beside the plane of the beam, or \
         above the mirror, are no hazards.\n\n",
        args.draw,
        args.command(),
        scenes::SWEEPS
    );
    out += score::HEADING;
    out.extend(rows.iter().map(|(name, sums)| score::row(name, sums)));
    out
}

/// Returns one text for each sweep whose free distance ends beyond a hazard, or that reports a false rise or drop.
fn listed(scored: &[Scored]) -> Vec<String> {
    let sweeps = scored.iter().flat_map(|one| &one.sweeps);
    let flawed = sweeps.filter(|sweep| sweep.free_beyond_hazard() || sweep.false_detection());
    flawed.map(Sweep::text).collect()
}

/// Simulates the recordings, scores the answers to their guard sweeps, and prints the table.
pub fn run(args: &Args) -> Result<ExitCode> {
    may_list("--list", args.list, "sweeps", args.draw)?;
    let jobs = args.jobs();
    let scored = harness::each(&jobs, |(kind, seed)| one(*kind, *seed))?;
    let rows = groups(&jobs, &scored);
    let list = if args.list {
        listed(&scored)
    } else {
        Vec::new()
    };
    emit(&match args.format {
        Format::Text => with_list(text(args, &rows), "Wrong or false", &list),
        Format::Json => {
            let kinds: Vec<_> = rows.iter().map(|(name, sums)| sums.json(name)).collect();
            format!(
                "{}\n",
                json!({"draw": args.draw.as_str(), "rows": kinds, "list": list})
            )
        }
    });
    Ok(ExitCode::SUCCESS)
}
