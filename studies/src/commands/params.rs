//! `params`: prints every tuned number of the default estimator, and the effect of changing it by a
//! fifth.

use std::fmt::Write as _;
use std::process::ExitCode;

use anyhow::Result;
use stairscan::params::Params;
use stairscan::verdict::Status;

use super::emit;
use super::harness::{self, Drawn};
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
    let mut out = heading(args, scans.len(), base);
    let mut group = "";
    for (k, entry) in Params::TABLE.iter().enumerate() {
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
        for now in moved.get(k).into_iter().flatten() {
            let change = |now: i64, base: i64| match now - base {
                0 => "0".to_owned(),
                n => format!("{n:+}"),
            };
            let _ = write!(
                out,
                " {}, {}, {} |",
                change(now.exact, base.exact),
                change(now.ok, base.ok),
                change(now.wrong, base.wrong)
            );
        }
        out.push('\n');
    }
    emit(&out);
    Ok(ExitCode::SUCCESS)
}

fn heading(args: &Args, scans: usize, base: Tally) -> String {
    let mut out = String::from(
        "# Parameters of the default estimator\n\nEvery tuned number but the verdict's weights, \
         which `cargo study fit` writes to `src/params/fitted.rs`.\n",
    );
    if args.sensitivity {
        let _ = write!(
            out,
            "\nMade by `cargo study params --sensitivity --scenes {}`: {scans} scans of tuning seeds, \
             {} of each kind, through the whole scanner. The last two columns are the effects of a \
             fifth less and a fifth more of a number on the exact scans (now {}), those that are \
             `ok` (now {}) and those that are `ok` and wrong (now {}).\n",
            args.scenes, args.scenes, base.exact, base.ok, base.wrong
        );
    }
    out
}
