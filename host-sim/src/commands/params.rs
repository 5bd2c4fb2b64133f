//! `params`: every tuned number of the default estimator, and what a fifth more or less of it does.

use std::fmt::Write as _;
use std::process::ExitCode;

use anyhow::Result;
use indicatif::ParallelProgressIterator;
use rayon::prelude::*;
use stairscan::answer::Outcome;
use stairscan::config::Config;
use stairscan::estimator::Estimator;
use stairscan::flight::{Likelihood, Params};
use stairscan::grid::PolarMap;
use stairscan::params::Entry;
use stairscan::report::sentence::write_scan;

use super::{emit, progress};
use crate::answer::Answer;
use crate::recording::Truth;
use crate::replay::{self, Options};
use crate::scene::command::random_scan;
use crate::scene::random::Kind;
use crate::score::{self, SceneScore};
use crate::seeds::Draw;

/// Scenes of each kind that a number's effect is measured on.
const SCENES: u64 = 4;
/// How far each number is moved: a fifth.
const FACTORS: [f32; 2] = [0.8, 1.2];

/// Arguments of `params`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Also move each number by a fifth either way, and count on tuning seeds what that does
    #[arg(long)]
    sensitivity: bool,
    /// So many scenes of each kind
    #[arg(long, default_value_t = SCENES)]
    scenes: u64,
}

/// A scan that is to be worked off again and again.
struct Case {
    map: PolarMap,
    config: Config,
    truth: Truth,
}

/// What a set of numbers makes of all scans.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    exact: i64,
    /// Matched steps that are off by more than 3 cm.
    off: i64,
}

/// Prints the table.
pub fn run(args: &Args) -> Result<ExitCode> {
    let cases = if args.sensitivity {
        cases(args.scenes)?
    } else {
        Vec::new()
    };
    let base = tally(&cases, &Params::DEFAULT);
    let bar = progress(Params::TABLE.len() as u64);
    let moved: Vec<[Tally; 2]> = Params::TABLE
        .par_iter()
        .progress_with(bar.clone())
        .map(|entry| FACTORS.map(|factor| with(&cases, entry, factor)))
        .collect();
    bar.finish_and_clear();
    let mut out = heading(args, cases.len(), base);
    let mut group = "";
    for (entry, moved) in Params::TABLE.iter().zip(&moved) {
        if entry.group != group {
            group = entry.group;
            let effect = if args.sensitivity {
                " less a fifth | plus a fifth |"
            } else {
                ""
            };
            let rule = if args.sensitivity { "---|---|" } else { "" };
            let _ = write!(
                out,
                "\n## {group}\n\n| number | value | unit | meaning | origin |{effect}\n|---|---|---|---|---|{rule}\n"
            );
        }
        let why = match entry.why {
            "" => String::new(),
            why => format!(": {why}"),
        };
        let _ = write!(
            out,
            "| `{}` | {} | {} | {} | {}{why} |",
            entry.name,
            (entry.get)(&Params::DEFAULT),
            entry.unit,
            entry.meaning.trim(),
            entry.origin.as_str(),
        );
        if args.sensitivity {
            for now in moved {
                let change = |now: i64, base: i64| match now - base {
                    0 => "0".to_owned(),
                    n => format!("{n:+}"),
                };
                let _ = write!(
                    out,
                    " {}, {} |",
                    change(now.exact, base.exact),
                    change(now.off, base.off)
                );
            }
        }
        out.push('\n');
    }
    emit(&out);
    Ok(ExitCode::SUCCESS)
}

fn heading(args: &Args, scans: usize, base: Tally) -> String {
    let mut out = String::from(
        "# Parameters of the default estimator\n\nEvery tuned number but the verdict's weights, \
         which `cargo sim fit` writes to `src/params/fitted.rs`.\n",
    );
    if args.sensitivity {
        let _ = write!(
            out,
            "\nMade by `cargo sim params --sensitivity --scenes {}`: {scans} scans of tuning seeds, {} \
             of each kind. The last two columns say by how much a fifth less and a fifth more of a \
             number change the exact scans (now {}) and the steps off by more than 3 cm (now {}).\n",
            args.scenes, args.scenes, base.exact, base.off
        );
    }
    out
}

/// The scans of all kinds.
fn cases(scenes: u64) -> Result<Vec<Case>> {
    let jobs: Vec<(Kind, u64)> = Kind::ALL
        .iter()
        .flat_map(|&kind| {
            Draw::Tuning
                .seeds()
                .take(scenes as usize)
                .map(move |s| (kind, s))
        })
        .collect();
    let bar = progress(jobs.len() as u64);
    let cases: Result<Vec<Option<Case>>> = jobs
        .par_iter()
        .progress_with(bar.clone())
        .map(|&(kind, seed)| case(kind, seed))
        .collect();
    bar.finish_and_clear();
    Ok(cases?.into_iter().flatten().collect())
}

/// One scan; none if the scanner would not work it off.
fn case(kind: Kind, seed: u64) -> Result<Option<Case>> {
    let recording = random_scan(kind, kind.variety(), seed)?;
    let mut case = None;
    replay::answers(&recording, &Options::default(), |scanned| {
        case = (!scanned.answer.is_fault()).then(|| Case {
            map: scanned.pipeline.map().clone(),
            config: *scanned.config,
            truth: recording.meta.truth.clone().unwrap_or_default(),
        });
    })?;
    Ok(case)
}

/// All scans with one number moved.
fn with(cases: &[Case], entry: &Entry<Params>, factor: f32) -> Tally {
    let mut params = Params::DEFAULT;
    let moved = factor * (entry.get)(&params);
    (entry.set)(&mut params, moved);
    tally(cases, &params)
}

/// All scans with these numbers.
fn tally(cases: &[Case], params: &Params) -> Tally {
    // The estimator keeps its numbers for as long as it likes, and there are a few hundred sets.
    let params: &'static Params = Box::leak(Box::new(params.clone()));
    let mut estimator = Box::new(Likelihood::with(params));
    let mut tally = Tally::default();
    for case in cases {
        estimator.begin(&case.map);
        for k in 0..case.map.rows() {
            estimator.row(&case.map, k);
        }
        let mut outcome = estimator.finish(&case.map, &case.config, 1, &mut ());
        outcome.link();
        let Some(score) = score_of(&outcome, &case.truth) else {
            continue;
        };
        tally.exact += i64::from(score.exact);
        let off =
            |m: &&score::Match| m.height_error.abs().max(m.distance_error.abs()) > score::LIMIT_M;
        tally.off += score.matches.iter().filter(off).count() as i64;
    }
    tally
}

fn score_of(outcome: &Outcome, truth: &Truth) -> Option<SceneScore> {
    let mut sentences = Vec::new();
    write_scan((1, 0), 0, outcome, |line| {
        sentences.push(line.trim_end().to_owned())
    });
    let answer = Answer::parse("", sentences).ok()?;
    Some(score::scene(&answer, truth))
}
