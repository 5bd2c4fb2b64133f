//! `accuracy`: measures the estimators on random scenes of the project's own simulator.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use serde_json::{Value, json};
use stairscan::config::{Config, EstimatorKind};

use super::compare;
use super::{Format, emit, may_list};
use crate::accuracy::reliability;
use crate::harness::{self, Drawn};
use crate::instrument::Instrument;
use host_sim::output::Overwrite;
use host_sim::random::Kind;
use host_sim::replay::{self, Options};
use host_sim::score::{self, SceneScore, SetScore, Share};
use host_sim::seeds::Draw;

/// Maximum error of a reported step height that is harmless for a wheelchair, metres.
const HARMLESS_M: f64 = 0.015;

/// Arguments of `accuracy`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Draw of the scenes
    #[arg(long, value_enum, default_value_t)]
    draw: Draw,
    /// Number of scenes of each kind, in place of the draw's own numbers
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    scenes: Option<u64>,
    /// Only scenes of this kind; may be given several times
    #[arg(long = "kind", value_name = "KIND")]
    kinds: Vec<Kind>,
    /// Also list the scenes that are not exact or wrong; refused with `--draw reporting`, whose scenes must not be inspected
    #[arg(long)]
    list: bool,
    /// Write one line of JSON for each scene to this file, for `compare`; refused with `--draw reporting`
    #[arg(long, value_name = "FILE")]
    each: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    instrument: Instrument,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

impl Args {
    fn selection(&self) -> Selection {
        Selection {
            draw: self.draw,
            scenes: self.scenes,
            kinds: self.kinds.clone(),
        }
    }
}

/// The answers of one estimator to all scenes of one kind.
#[derive(Clone, Debug)]
pub struct Row {
    /// Kind of the scenes.
    pub kind: Kind,
    /// The estimator.
    pub estimator: EstimatorKind,
    /// Scores of the estimator's answers, one for each scene, in the order of their seeds.
    pub scenes: Vec<SceneScore>,
}

/// The random scenes on which estimators are measured.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Draw (range of seeds) from which the scenes' seeds are.
    pub draw: Draw,
    /// Number of scenes of each kind; the draw's own if `None`.
    pub scenes: Option<u64>,
    /// Kinds of scenes; all if empty.
    pub kinds: Vec<Kind>,
}

impl Selection {
    /// Returns the selection of all kinds of a draw, with its own numbers of scenes.
    pub fn of(draw: Draw) -> Self {
        Self {
            draw,
            ..Self::default()
        }
    }

    /// Returns the number of scenes of a kind; 0 if it is not selected.
    fn count(&self, kind: Kind) -> u64 {
        match self.kinds.is_empty() || self.kinds.contains(&kind) {
            true => self.scenes.unwrap_or(self.draw.scenes(kind)),
            false => 0,
        }
    }

    /// Returns the kinds with at least one scene.
    fn kinds(&self) -> impl Iterator<Item = Kind> + Clone {
        Kind::ALL.into_iter().filter(|&kind| self.count(kind) > 0)
    }

    /// Returns the options of `accuracy` that make this selection, except the draw, each after a space.
    fn options(&self) -> String {
        let scenes = self
            .scenes
            .map_or(String::new(), |n| format!(" --scenes {n}"));
        let kinds = self.kinds.iter().map(|kind| format!(" --kind {kind}"));
        kinds.fold(scenes, |all, kind| all + &kind)
    }
}

/// Simulates the selected scenes with the radar module `instrument` and scans them with every estimator. Returns a row
/// for each estimator and kind of scene, estimator by estimator.
///
/// # Errors
/// Names a scene that cannot be scanned.
pub fn measure(selection: &Selection, instrument: &Instrument) -> Result<Vec<Row>> {
    let jobs = harness::scenes(selection.draw, |kind| selection.count(kind));
    let scored = harness::each(&jobs, |drawn| one(drawn, instrument))?;
    let row = |kind: Kind, column: usize| Row {
        kind,
        estimator: EstimatorKind::ALL[column],
        scenes: jobs
            .iter()
            .zip(&scored)
            .filter(|(job, _)| job.kind == kind)
            .map(|(_, scores)| scores[column].clone())
            .collect(),
    };
    let columns = 0..EstimatorKind::ALL.len();
    Ok(columns
        .flat_map(|c| selection.kinds().map(move |kind| (kind, c)))
        .map(|(kind, c)| row(kind, c))
        .collect())
}

/// Scans and scores one scene with every estimator. Returns the scores in the order of [`EstimatorKind::ALL`].
fn one(drawn: &Drawn, instrument: &Instrument) -> Result<Vec<SceneScore>> {
    let recording = drawn.scan_by(instrument)?;
    let truth = recording.meta.truth.clone().unwrap_or_default();
    let score = |&estimator: &EstimatorKind| {
        let config = Config {
            estimator,
            seed: 1,
            ..Config::default()
        };
        let options = Options {
            config,
            ..Options::default()
        };
        Ok(score::scene(&replay::answer(&recording, &options)?, &truth))
    };
    EstimatorKind::ALL.iter().map(score).collect()
}

/// Returns the head of the report: the measured scenes, the command and the rules of counting.
pub fn heading(selection: &Selection, instrument: &Instrument) -> String {
    let draw = selection.draw;
    let numbers = selection.options() + &instrument.options();
    format!(
        "# Accuracy, {draw} scenes\n\nMade by `cargo study accuracy --draw {draw}{numbers}`: random \
         scenes of the project's own simulator, each kind with the seeds from {} on. \"none\" holds \
         scenes in which the instrument is blind, where a `fault` is right. An answer is wrong when \
         something up to its horizon is missing, false or off by more than its expanded uncertainty \
         U = max(3 cm, 3σ), at most 8 cm; without a horizon it is valid at any distance. Covered \
         are true steps within the horizon or reported. In brackets: 95 % intervals, of shares by \
         Wilson's score, of quantiles between ranks; those of steps are a little too narrow, since \
         the steps of one scene are not independent.\n",
        draw.seeds().start,
    )
}

/// Scores of one estimator, by kind of scene and for all scenes.
struct Sums {
    estimator: EstimatorKind,
    /// Scores by kind of scene, each with the share of reported step heights whose error is harmless (up to 1.5 cm) or
    /// within 2σ.
    kinds: Vec<(Kind, SetScore, Share)>,
    /// Scores of the scenes of all kinds together.
    all: SetScore,
}

/// Returns the scores of every estimator, by kind and for all scenes.
fn sums(rows: &[Row]) -> impl Iterator<Item = Sums> {
    EstimatorKind::ALL.iter().map(|&estimator| {
        let rows = || rows.iter().filter(|row| row.estimator == estimator);
        let sum = |row: &Row| {
            let set = SetScore::new(&row.kind.to_string(), row.scenes.iter());
            (row.kind, set, harmless(&row.scenes))
        };
        Sums {
            estimator,
            kinds: rows().map(sum).collect(),
            all: SetScore::new("all", rows().flat_map(|row| &row.scenes)),
        }
    })
}

/// Returns the report: its head, and the tables of each estimator.
pub fn report(selection: &Selection, instrument: &Instrument, rows: &[Row]) -> String {
    let mut out = heading(selection, instrument);
    for Sums {
        estimator,
        kinds,
        all,
    } in sums(rows)
    {
        let name = estimator.as_str();
        let _ = write!(out, "\n## Estimator `{name}`\n\n");
        // The published tables are those of the default estimator.
        if estimator != EstimatorKind::default() && selection.draw == Draw::Reporting {
            out.push_str(&reliability::total(&all));
            continue;
        }
        let _ = write!(
            out,
            "{}\n### Reliability\n\n{}\n### Steps\n\n{}",
            answers(&kinds),
            reliability::tables(&kinds, &all),
            steps(&kinds)
        );
    }
    out
}

/// Returns the scores of every estimator as one JSON object.
pub fn report_json(draw: Draw, rows: &[Row]) -> Value {
    let estimator = |sums: Sums| {
        let kind = |(_, set, harmless): &(Kind, SetScore, Share)| {
            let mut kind = set.json();
            kind["height_harmless_or_within_2_sigma"] = harmless.json();
            kind
        };
        json!({
            "estimator": sums.estimator.as_str(),
            "kinds": sums.kinds.iter().map(kind).collect::<Vec<_>>(),
            "all": sums.all.json(),
        })
    };
    json!({
        "draw": draw.as_str(),
        "first_seed": draw.seeds().start,
        "estimators": sums(rows).map(estimator).collect::<Vec<_>>(),
    })
}

/// Returns the table of scores of whole scenes by kind: shares of exact, missed, `ok` and wrong answers.
fn answers(sets: &[(Kind, SetScore, Share)]) -> String {
    let mut out = String::from(
        "| scenes | exact | false stairs | false steps | missed steps | of 15 dB and more | `ok` \
         | `ok` of what is not wrong | `ok` and wrong, of `ok` | covered | `fault` |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for (kind, set, _) in sets {
        let [.., fault] = set.status;
        let _ = writeln!(
            out,
            "| {kind} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {fault} |",
            set.exact.full(),
            set.false_stairs.full(),
            set.false_steps,
            set.missed.full(),
            set.strong_missed.full(),
            set.ok.full(),
            set.ok_among_correct.full(),
            set.ok_and_wrong.full(),
            set.covered.full(),
        );
    }
    out
}

/// Returns the table of errors of reported steps that match true steps, by kind of scene. Kinds without one have no row.
fn steps(sets: &[(Kind, SetScore, Share)]) -> String {
    let mut out = String::from(
        "| scenes | distance error: median | 95 % | height error: median | 95 % \
         | distance within 2σ | beyond 3σ | height within 2σ | beyond 3σ | height within 1.5 cm or 2σ |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for (kind, set, harmless) in sets {
        if set.distance[0].is_none() && set.height[0].is_none() {
            continue;
        }
        let _ = write!(out, "| {kind}");
        for spread in [set.distance[0], set.height[0]] {
            let _ = match spread {
                Some(s) => write!(
                    out,
                    " | {} | {}",
                    centimetres(s.median, s.median_interval),
                    centimetres(s.p95, s.p95_interval)
                ),
                None => write!(out, " | – | –"),
            };
        }
        for [within, beyond] in [set.distance_sigmas, set.height_sigmas] {
            let _ = write!(out, " | {} | {}", within.percent(), beyond.percent());
        }
        let _ = writeln!(out, " | {} |", harmless.percent());
    }
    out
}

/// Formats a length in metres with its interval as `0.43 cm (0.39–0.48)`.
fn centimetres(value: f64, (low, high): (f64, f64)) -> String {
    format!(
        "{:.2} cm ({:.2}–{:.2})",
        100.0 * value,
        100.0 * low,
        100.0 * high
    )
}

/// Returns the share of reported step heights whose error is harmless (up to 1.5 cm) or within 2σ.
fn harmless(scenes: &[SceneScore]) -> Share {
    Share::count(scenes.iter().flat_map(|s| &s.matches), |m| {
        m.height_error.abs() <= HARMLESS_M || m.height_z.abs() <= 2.0
    })
}

/// Measures the estimators and prints their scores.
pub fn run(args: &Args) -> Result<ExitCode> {
    let list = args.list || args.each.is_some();
    may_list("--list, --each", list, "scenes", args.draw)?;
    let outputs = args.overwrite.reading::<&PathBuf>([]);
    args.each.iter().try_for_each(|file| outputs.check(file))?;
    let selection = args.selection();
    let rows = measure(&selection, &args.instrument)?;
    if let Some(path) = &args.each {
        let default = rows
            .iter()
            .filter(|row| row.estimator == EstimatorKind::default());
        let lines = compare::lines(default.flat_map(|row| &row.scenes))?;
        outputs.write(path, lines.as_bytes())?;
    }
    let out = match args.format {
        Format::Text => text(args, &selection, &rows),
        Format::Json => {
            let mut out = report_json(args.draw, &rows);
            if args.list {
                let listed = rows.iter().map(|row| {
                    json!({
                        "estimator": row.estimator.as_str(),
                        "kind": row.kind.to_string(),
                        "scenes": score::confusions_json(&row.scenes),
                    })
                });
                out["not_exact_or_wrong"] = listed.collect();
            }
            format!("{out}\n")
        }
    };
    emit(&out);
    Ok(ExitCode::SUCCESS)
}

/// Returns the report and, if requested, the list of scenes that are not exact or are wrong.
fn text(args: &Args, selection: &Selection, rows: &[Row]) -> String {
    let mut out = report(selection, &args.instrument, rows);
    for row in rows.iter().filter(|_| args.list) {
        let _ = write!(
            out,
            "\n{}, {}, not exact, or wrong:\n{}",
            row.estimator.as_str(),
            row.kind,
            score::confusions(&row.scenes)
        );
    }
    out
}
