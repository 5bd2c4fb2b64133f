//! `params`: prints every tuned number of the default estimator, and the effect of changing it by a
//! fifth.

use std::fmt::Write as _;
use std::process::ExitCode;

use anyhow::Result;
use stairscan::params::{Origin, Params};
use stairscan::verdict::Status;

use super::emit;
use crate::harness::{self, Drawn};
use host_sim::score::SceneScore;
use host_sim::seeds::Draw;

/// Default number of scenes of each kind on which the effect of changing a number is measured.
const SCENES: u64 = 4;
/// Factors by which each tuned number is multiplied in turn: a fifth less and a fifth more.
const FACTORS: [f32; 2] = [0.8, 1.2];

/// Arguments of `params`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Also change each number by a fifth up and down, and count the changed answers on tuning seeds
    #[arg(long)]
    sensitivity: bool,
    /// Number of scenes of each kind
    #[arg(long, default_value_t = SCENES)]
    scenes: u64,
}

/// Numbers of scans that are exact, `ok`, and `ok` and wrong, with one set of parameters.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    exact: i64,
    ok: i64,
    wrong: i64,
}

impl Tally {
    fn new(scores: &[SceneScore]) -> Self {
        let count =
            |has: &dyn Fn(&SceneScore) -> bool| scores.iter().filter(|s| has(s)).count() as i64;
        Self {
            exact: count(&|s| s.exact),
            ok: count(&|s| s.status == Status::Ok),
            wrong: count(&SceneScore::ok_and_wrong),
        }
    }
}

/// Prints the table of tuned numbers, with the effects of changing them if requested.
pub fn run(args: &Args) -> Result<ExitCode> {
    let scans = match args.sensitivity {
        true => harness::each(&harness::scenes(Draw::Tuning, |_| args.scenes), Drawn::scan)?,
        false => Vec::new(),
    };
    let base = Tally::new(&harness::answers(&scans, &Params::DEFAULT)?);
    let mut moved = Vec::new();
    for entry in Params::TABLE.iter().filter(|_| args.sensitivity) {
        let tally = |factor| -> Result<Tally> {
            let mut params = Params::DEFAULT;
            (entry.set)(&mut params, factor * (entry.get)(&Params::DEFAULT));
            // Leaked, since estimators need `'static` parameters.
            let params = Box::leak(Box::new(params));
            Ok(Tally::new(&harness::answers(&scans, params)?))
        };
        let [less, plus] = FACTORS;
        moved.push([tally(less)?, tally(plus)?]);
    }
    let (effect, rule) = match args.sensitivity {
        true => (" a fifth less; more |", "---|"),
        false => ("", ""),
    };
    let mut out = heading(args, scans.len(), base);
    let _ = write!(
        out,
        "\n| number | value | meaning | origin |{effect}\n|---|---|---|---|{rule}\n"
    );
    let mut group = "";
    for (k, entry) in Params::TABLE.iter().enumerate() {
        if entry.group != group {
            group = entry.group;
            let empty = "|".repeat(if args.sensitivity { 5 } else { 4 });
            let _ = writeln!(out, "| **{group}** {empty}");
        }
        let origin = match (entry.origin, entry.why) {
            (Origin::Hand, why) => why.to_owned(),
            (origin, "") => origin.as_str().to_owned(),
            (origin, why) => format!("{}: {why}", origin.as_str()),
        };
        let value = format!("{} {}", (entry.get)(&Params::DEFAULT), entry.unit);
        let _ = write!(
            out,
            "| `{}` | {} | {} | {origin} |",
            entry.name,
            value.trim(),
            entry.meaning.trim(),
        );
        let mut effects = Vec::new();
        for now in moved.get(k).into_iter().flatten() {
            let change = |now: i64, base: i64| match now - base {
                0 => "0".to_owned(),
                n => format!("{n:+}"),
            };
            let changes = [
                change(now.exact, base.exact),
                change(now.ok, base.ok),
                change(now.wrong, base.wrong),
            ];
            effects.push(match changes.iter().all(|change| change == "0") {
                true => "–".to_owned(),
                false => changes.join(", "),
            });
        }
        if args.sensitivity {
            let none = effects.iter().all(|effect| effect == "–");
            let cell = if none {
                "–".to_owned()
            } else {
                effects.join("; ")
            };
            let _ = write!(out, " {cell} |");
        }
        out.push('\n');
    }
    emit(&out);
    Ok(ExitCode::SUCCESS)
}

fn heading(args: &Args, scans: usize, base: Tally) -> String {
    let mut out = String::from(
        "# Parameters of the default estimator\n\nEvery tuned number but the verdict's weights, \
         which `cargo study fit` writes to `src/params/fitted.rs`. One without *derived* or *custom* is \
         set by hand.\n",
    );
    if args.sensitivity {
        let _ = write!(
            out,
            "\nMade by `cargo study params --sensitivity --scenes {}`: {scans} scans of tuning seeds, \
             {} of each kind, through the whole scanner. The last column: by how many scans a \
             fifth less, then a fifth more changes the exact ones (now {}), the `ok` ones (now {}), and \
             the `ok` and wrong ones (now {}); a dash: by none.\n",
            args.scenes, args.scenes, base.exact, base.ok, base.wrong
        );
    }
    out
}
