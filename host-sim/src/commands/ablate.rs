//! `ablate`: what each rule of the estimator is worth: off, one at a time, through the whole scanner.

use std::fmt::Write as _;
use std::process::ExitCode;

use anyhow::{Result, bail};
use stairscan::params::{self, DOUBTS, Params};

use super::emit;
use super::harness::{self, Drawn};
use crate::emulate::image::workspace;
use crate::faults::ALL;
use crate::recording::Recording;
use crate::replay::{self, Options};
use crate::score::{self, Change, Comparison, SceneScore};
use crate::seeds::Draw;

/// Scenes of each kind: some two thousand in all.
const SCENES: u64 = 106;
/// Scenes of each kind that faults of the instrument are put into.
const FAULTY: u64 = 2;
/// Effects that chance makes so often count as none.
const SIGNIFICANT: f64 = 0.05;

/// Arguments of `ablate`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Rules to turn off; all without any
    #[arg(value_name = "RULE")]
    rules: Vec<String>,
    /// Which scenes
    #[arg(long, value_enum, default_value_t = Draw::Validation)]
    draw: Draw,
    /// Scenes of each kind
    #[arg(long, default_value_t = SCENES)]
    scenes: u64,
    /// Scenes of each kind that every fault of the instrument is put into; those rules that tell of faults
    /// are measured on them, too
    #[arg(long, default_value_t = FAULTY)]
    faulty: u64,
    /// Turn all of the named rules off at once
    #[arg(long, requires = "rules")]
    together: bool,
}

/// Something to turn off.
struct Ablation {
    group: &'static str,
    name: String,
    meaning: String,
    params: &'static Params,
    /// Whether it tells of faults of the instrument.
    faults: bool,
}

impl Ablation {
    fn new(group: &'static str, name: &str, meaning: &str, off: &dyn Fn(&mut Params)) -> Self {
        let mut params = Params::DEFAULT;
        off(&mut params);
        Self {
            group,
            name: name.to_owned(),
            meaning: meaning.trim().to_owned(),
            // For as long as the program runs: estimators keep them.
            params: Box::leak(Box::new(params)),
            faults: matches!(group, "mount" | "health"),
        }
    }
}

/// Every rule between echoes and status, and every doubt about the instrument.
fn all() -> Vec<Ablation> {
    let rules = params::rules()
        .map(|rule| Ablation::new(rule.group, rule.name, rule.meaning, &|p| rule.turn_off(p)));
    let doubts = DOUBTS.iter().map(|&doubt| {
        let off = move |p: &mut Params| p.rules.muted.add(doubt);
        Ablation::new("health", doubt.as_str(), doubt.meaning(), &off)
    });
    rules.chain(doubts).collect()
}

/// The rules to measure.
fn chosen(args: &Args) -> Result<Vec<Ablation>> {
    let all = all();
    if args.rules.is_empty() {
        return Ok(all);
    }
    if let Some(unknown) = args
        .rules
        .iter()
        .find(|name| all.iter().all(|a| a.name != **name))
    {
        let names: Vec<&str> = all.iter().map(|a| a.name.as_str()).collect();
        bail!("\"{unknown}\": expected one of {}", names.join(", "));
    }
    let named = all.into_iter().filter(|a| args.rules.contains(&a.name));
    if !args.together {
        return Ok(named.collect());
    }
    let off = |p: &mut Params| {
        for rule in params::rules().filter(|rule| args.rules.iter().any(|name| name == rule.name)) {
            rule.turn_off(p);
        }
        for doubt in DOUBTS
            .iter()
            .filter(|d| args.rules.iter().any(|name| name == d.as_str()))
        {
            p.rules.muted.add(*doubt);
        }
    };
    Ok(vec![Ablation::new(
        "mount",
        "together",
        &args.rules.join(", "),
        &off,
    )])
}

/// What is scanned: scenes as they are, and scenes with a fault of the instrument.
struct Scans {
    clean: Vec<Recording>,
    faulty: Vec<Recording>,
}

impl Scans {
    fn new(args: &Args) -> Result<Self> {
        let clean = harness::each(&harness::scenes(args.draw, |_| args.scenes), Drawn::scan)?;
        let few = harness::each(&harness::scenes(args.draw, |_| args.faulty), Drawn::scan)?;
        let mut jobs = Vec::new();
        for fault in ALL {
            for (&strength, recording) in fault.strengths.iter().cycle().zip(&few) {
                jobs.push((fault, strength, recording, jobs.len() as u64));
            }
        }
        let spoilt = harness::each(&jobs, |(fault, strength, clean, seed)| {
            fault.on(clean, *strength, *seed)
        })?;
        Ok(Self {
            clean,
            faulty: spoilt,
        })
    }
}

/// The answers to all scans with these numbers, scored.
///
/// # Errors
/// Names a scan that cannot be worked off.
pub fn answers(scans: &[Recording], params: &'static Params) -> Result<Vec<SceneScore>> {
    params::replace(params);
    let scored = harness::each(scans, |recording| {
        let truth = recording.meta.truth.clone().unwrap_or_default();
        Ok(score::scene(
            &replay::answer(recording, &Options::default())?,
            &truth,
        ))
    });
    params::replace(&Params::DEFAULT);
    scored
}

/// Lines of the firmware's sources that mention what turns a rule off.
fn lines(off: &Params) -> Result<usize> {
    let mut words: Vec<String> = Params::TABLE
        .iter()
        .filter(|entry| (entry.get)(off) != (entry.get)(&Params::DEFAULT))
        .map(|entry| format!("p.{}", entry.name))
        .collect();
    for rule in params::rules() {
        let mut alone = Params::DEFAULT;
        rule.turn_off(&mut alone);
        if alone.rules != Params::DEFAULT.rules && alone.rules == off.rules {
            words.push(format!("rules.{}", rule.name));
        }
    }
    let mut count = 0;
    let mut folders = vec![workspace().join("src")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs")
                && !path.ends_with("params/rules.rs")
            {
                let text = std::fs::read_to_string(&path)?;
                count += text
                    .lines()
                    .filter(|line| words.iter().any(|w| mentions(line, w)))
                    .count();
            }
        }
    }
    Ok(count)
}

/// Whether a line holds a word that does not go on.
fn mentions(line: &str, word: &str) -> bool {
    let mut found = line.match_indices(word);
    found.any(|(at, _)| {
        let behind = line[at + word.len()..].chars().next();
        !behind.is_some_and(|c| c.is_alphanumeric() || c == '_')
    })
}

/// `+3 -5`, and in bold where chance would not make it.
fn told(change: Change) -> String {
    let p = change.p();
    let bold = if p < SIGNIFICANT { "**" } else { "" };
    format!("{bold}+{} -{}{bold} ({p:.2})", change.gained, change.lost)
}

/// Measures, and prints the table.
pub fn run(args: &Args) -> Result<ExitCode> {
    let ablations = chosen(args)?;
    let scans = Scans::new(args)?;
    let base = answers(&scans.clean, &Params::DEFAULT)?;
    let base_faulty = answers(&scans.faulty, &Params::DEFAULT)?;
    let mut out = heading(args, &base, &base_faulty);
    let mut group = "";
    for ablation in &ablations {
        if ablation.group != group {
            group = ablation.group;
            let _ = write!(
                out,
                "\n## {group}\n\n| rule off | what it does | exact | `ok` and right | `ok` and wrong | distance, height 95 % | with faults: `ok` and wrong | lines |\n|---|---|---|---|---|---|---|---|\n"
            );
        }
        let after = answers(&scans.clean, ablation.params)?;
        let c = Comparison::new(&base, &after);
        let [distance, height] = [0, 1].map(|k| 100.0 * (c.errors_m[1][k] - c.errors_m[0][k]));
        let faulty = match ablation.faults {
            true => {
                let after = answers(&scans.faulty, ablation.params)?;
                told(Comparison::new(&base_faulty, &after).ok_wrong)
            }
            false => String::new(),
        };
        let _ = writeln!(
            out,
            "| `{}` | {} | {} | {} | {} | {distance:+.2}, {height:+.2} cm | {faulty} | {} |",
            ablation.name,
            ablation.meaning,
            told(c.exact),
            told(c.ok_right),
            told(c.ok_wrong),
            lines(ablation.params)?
        );
        eprintln!(
            "{}: exact {} ok {} wrong {}",
            ablation.name,
            told(c.exact),
            told(c.ok_right),
            told(c.ok_wrong)
        );
    }
    emit(&out);
    Ok(ExitCode::SUCCESS)
}

/// What was measured, and on what.
fn heading(args: &Args, base: &[SceneScore], faulty: &[SceneScore]) -> String {
    let exact = base.iter().filter(|s| s.exact).count();
    let ok = base
        .iter()
        .filter(|s| s.status == stairscan::answer::Status::Ok)
        .count();
    let wrong = |scores: &[SceneScore]| scores.iter().filter(|s| s.ok_and_wrong()).count();
    format!(
        "# What each rule is worth\n\nMade by `cargo sim ablate --draw {} --scenes {} --faulty {}`: each rule off by itself, \
         the whole scanner on {} scenes ({} of each kind), {exact} exact, {ok} `ok`, {} of them wrong, and on {} scans \
         with a fault of the instrument, {} of them `ok` and wrong. Cells: scenes gained and lost by turning the rule \
         off, and in brackets McNemar's p of that; bold below {SIGNIFICANT}. Hazards are not counted anew. Lines are \
         those of `src/` that mention what turns the rule off.\n",
        args.draw,
        args.scenes,
        args.faulty,
        base.len(),
        args.scenes,
        wrong(base),
        faulty.len(),
        wrong(faulty),
    )
}
