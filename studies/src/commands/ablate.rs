//! `ablate`: measures the contribution of each rule of the estimator by turning it off, one at a time, through
//! the whole scanner.

use std::fmt::Write as _;
use std::process::ExitCode;

use anyhow::{Result, bail};
use stairscan::params::{self, Params};
use stairscan::verdict::INSTRUMENT_REASONS;

use super::bench::Cost;
use super::emit;
use crate::faults::ALL;
use crate::harness::{self, Drawn};
use host_sim::emulate::image::workspace;
use host_sim::recording::Recording;
use host_sim::score::{Change, Comparison, SceneScore};
use host_sim::seeds::Draw;

/// Default number of scenes of each kind on which rules are measured: about two thousand scenes in all.
const SCENES: u64 = 106;
/// Default number of scenes of each kind to which faults of the instrument are applied.
const FAULTY: u64 = 2;
/// Significance level: an effect with a larger p-value counts as none.
const SIGNIFICANT: f64 = 0.05;

/// Arguments of `ablate`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Rules to turn off; without any, all
    #[arg(value_name = "RULE")]
    rules: Vec<String>,
    /// Draw of the scenes
    #[arg(long, value_enum, default_value_t = Draw::Validation)]
    draw: Draw,
    /// Number of scenes of each kind
    #[arg(long, default_value_t = SCENES)]
    scenes: u64,
    /// Number of scenes of each kind to which every fault of the instrument is applied; rules that detect faults are
    /// also measured on these
    #[arg(long, default_value_t = FAULTY)]
    faulty: u64,
    /// Turn all of the named rules off at once
    #[arg(long, requires = "rules")]
    together: bool,
    /// Also count in the emulator the instructions that each rule takes in the first scene of each kind
    #[arg(long)]
    cost: bool,
}

/// Rules that are turned off together, with the parameters with which the estimator runs without them.
struct Ablation {
    group: &'static str,
    names: Vec<&'static str>,
    meaning: &'static str,
    params: &'static Params,
}

impl Ablation {
    /// Returns the ablation that turns off all rules of `listed`, each of which is given by group, name and meaning.
    fn new(listed: &[(&'static str, &'static str, &'static str)]) -> Self {
        let mut params = Params::DEFAULT;
        let names: Vec<&'static str> = listed.iter().map(|(_, name, _)| *name).collect();
        for rule in params::rules().filter(|rule| names.contains(&rule.name)) {
            rule.turn_off(&mut params);
        }
        for check in INSTRUMENT_REASONS
            .iter()
            .filter(|check| names.contains(&check.as_str()))
        {
            params.rules.muted.add(*check);
        }
        let (group, meaning) = match listed {
            [(group, _, meaning)] => (*group, meaning.trim()),
            _ => ("together", "All of them at once."),
        };
        Self {
            group,
            names,
            meaning,
            // Leaked, since estimators need `'static` parameters.
            params: Box::leak(Box::new(params)),
        }
    }

    /// Whether the rules detect faults of the instrument; they are then also measured on scans with faults.
    fn detects_faults(&self) -> bool {
        matches!(self.group, "mount" | "health" | "together")
    }
}

/// Returns group, name and meaning of every rule between echoes and status, and of every check of the
/// instrument, by group. The meanings of the checks are in docs/reasons.md.
fn listed() -> Vec<(&'static str, &'static str, &'static str)> {
    let rules = params::rules().map(|rule| (rule.group, rule.name, rule.meaning));
    let checks = INSTRUMENT_REASONS
        .iter()
        .map(|check| ("health", check.as_str(), ""));
    let mut listed: Vec<_> = rules.chain(checks).collect();
    let mut groups: Vec<&str> = Vec::new();
    for (group, ..) in &listed {
        if !groups.contains(group) {
            groups.push(group);
        }
    }
    listed.sort_by_key(|(group, ..)| groups.iter().position(|g| g == group));
    listed
}

/// Returns the ablations to measure: one for each named rule (all rules if none is named), or a single one that turns
/// all of them off.
fn chosen(args: &Args) -> Result<Vec<Ablation>> {
    let mut listed = listed();
    let names: Vec<&str> = listed.iter().map(|(_, name, _)| *name).collect();
    if let Some(unknown) = args
        .rules
        .iter()
        .find(|name| !names.contains(&name.as_str()))
    {
        bail!("\"{unknown}\": expected one of {}", names.join(", "));
    }
    listed.retain(|(_, name, _)| args.rules.is_empty() || args.rules.iter().any(|n| n == name));
    Ok(match args.together {
        true => vec![Ablation::new(&listed)],
        false => listed.chunks(1).map(Ablation::new).collect(),
    })
}

/// Recordings of the scenes: some without, others with a fault of the instrument.
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
        let faulty = harness::each(&jobs, |(fault, strength, clean, seed)| {
            fault.on(clean, *strength, *seed)
        })?;
        Ok(Self { clean, faulty })
    }
}

/// Counts the lines of the firmware's sources that read a switch or number by which the rules are turned off.
fn lines(ablation: &Ablation) -> Result<usize> {
    let number = |get: fn(&Params) -> f32| get(ablation.params) != get(&Params::DEFAULT);
    let numbers = Params::TABLE.iter().filter(|entry| number(entry.get));
    let numbers = numbers.map(|entry| format!(".{}", entry.name));
    let switches = ablation.names.iter().map(|name| format!("rules.{name}"));
    let words: Vec<String> = numbers.chain(switches).collect();
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

/// Whether a line contains `word` as a whole word.
fn mentions(line: &str, word: &str) -> bool {
    let mut found = line.match_indices(word);
    found.any(|(at, _)| {
        let behind = line[at + word.len()..].chars().next();
        !behind.is_some_and(|c| c.is_alphanumeric() || c == '_')
    })
}

/// Formats the effect of turning off rules as `+3 -5 (0.45)`: numbers of scenes gained and lost, and the p-value; the
/// numbers are in bold if the effect is significant. A dash if no scene changes.
fn change_text(change: Change) -> String {
    if change.gained == 0 && change.lost == 0 {
        return "–".to_owned();
    }
    let p = change.p();
    let bold = if p < SIGNIFICANT { "**" } else { "" };
    format!("{bold}+{} -{}{bold} ({p:.2})", change.gained, change.lost)
}

/// Joins two formatted numbers; a dash if both are zero.
fn pair(one: &str, other: &str) -> String {
    let zero = |text: &str| text.chars().all(|c| "+-0.".contains(c));
    match zero(one) && zero(other) {
        true => "–".to_owned(),
        false => format!("{one}, {other}"),
    }
}

/// Counts, in the emulator, the instructions that rules take in the first scan of each kind.
struct Costs {
    cost: Cost,
    /// Number of instructions from the last row to the end of the report with all rules on, for each scan.
    base: Vec<u64>,
}

impl Costs {
    /// Takes the first scan of each kind in `clean`, and counts its instructions with all rules on.
    fn new(args: &Args, clean: &[Recording]) -> Result<Self> {
        let first = clean.iter().step_by(args.scenes.max(1) as usize);
        let cost = Cost::new(&first.cloned().collect::<Vec<_>>())?;
        let base = cost.post(&Params::DEFAULT)?;
        Ok(Self { cost, base })
    }

    /// Returns the number of instructions that a scan takes less without the rules of `ablation`, in thousands, as
    /// text: mean and maximum over the scans.
    fn saved(&self, ablation: &Ablation) -> Result<String> {
        let off = self.cost.post(ablation.params)?;
        let saved = self.base.iter().zip(&off);
        let saved: Vec<f64> = saved
            .map(|(&on, &off)| (on as f64 - off as f64) / 1e3)
            .collect();
        let mean = saved.iter().sum::<f64>() / saved.len().max(1) as f64;
        let most = saved.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Ok(pair(&format!("{mean:.1}"), &format!("{most:.1}")))
    }
}

/// Measures the effect of turning off each chosen rule, and prints the table.
pub fn run(args: &Args) -> Result<ExitCode> {
    let ablations = chosen(args)?;
    let scans = Scans::new(args)?;
    // First, because it fails without the emulator.
    let costs = args
        .cost
        .then(|| Costs::new(args, &scans.clean))
        .transpose()?;
    let base = harness::answers(&scans.clean, &Params::DEFAULT)?;
    let base_faulty = harness::answers(&scans.faulty, &Params::DEFAULT)?;
    let mut out = heading(args, &base, &base_faulty);
    if let Some(costs) = &costs {
        let mean = costs.base.iter().sum::<u64>() / costs.base.len().max(1) as u64;
        let _ = writeln!(
            out,
            "\nInstructions: thousands a scan saved by turning the rule off, from the last row to the end of the \
             report, in the first scene of each kind: mean of {}, and maximum. With every rule on they are {} on average.",
            costs.base.len(),
            mean / 1000
        );
    }
    out.push_str(
        "\n| rule off | what it does | exact | `ok` and right | `ok` and wrong | distance, height 95 %, cm \
         | with faults: `ok` and wrong | instructions | lines |\n|---|---|---|---|---|---|---|---|---|\n",
    );
    let mut group = "";
    for ablation in &ablations {
        if ablation.group != group {
            group = ablation.group;
            let _ = writeln!(out, "| **{group}** {}", "|".repeat(9));
        }
        let after = harness::answers(&scans.clean, ablation.params)?;
        let c = Comparison::new(&base, &after);
        let [distance, height] = [0, 1].map(|k| 100.0 * (c.errors_m[1][k] - c.errors_m[0][k]));
        let faulty = match ablation.detects_faults() {
            true => {
                let after = harness::answers(&scans.faulty, ablation.params)?;
                change_text(Comparison::new(&base_faulty, &after).ok_wrong)
            }
            false => String::new(),
        };
        let cost = costs.as_ref().map(|costs| costs.saved(ablation));
        let cost = cost.transpose()?.unwrap_or_default();
        let errors = pair(&format!("{distance:+.2}"), &format!("{height:+.2}"));
        let name = ablation.names.join("`, `");
        let _ = writeln!(
            out,
            "| `{name}` | {} | {} | {} | {} | {errors} | {faulty} | {cost} | {} |",
            ablation.meaning,
            change_text(c.exact),
            change_text(c.ok_right),
            change_text(c.ok_wrong),
            lines(ablation)?
        );
        host_sim::note!(
            "{name}: exact {} ok {} wrong {}",
            change_text(c.exact),
            change_text(c.ok_right),
            change_text(c.ok_wrong)
        );
    }
    emit(&out);
    Ok(ExitCode::SUCCESS)
}

/// Returns the text above the table: the number of scenes, and the meaning of the cells.
fn heading(args: &Args, base: &[SceneScore], faulty: &[SceneScore]) -> String {
    let exact = base.iter().filter(|s| s.exact).count();
    let ok = base
        .iter()
        .filter(|s| s.status == stairscan::verdict::Status::Ok)
        .count();
    let wrong = |scores: &[SceneScore]| scores.iter().filter(|s| s.ok_and_wrong()).count();
    format!(
        "# Effect of each rule\n\nMade by `cargo study ablate --draw {} --scenes {} --faulty {}{}`: \
         each rule off by itself, the whole scanner on {} scenes ({} of each kind), {exact} exact, \
         {ok} `ok`, {} of them wrong, and on {} scans with a fault of the instrument, {} of them \
         `ok` and wrong. Cells: scenes gained and lost by turning the rule off, and in brackets \
         McNemar's p; bold below {SIGNIFICANT}; a dash where nothing changes. Hazards are not fitted \
         again. Lines of `src/` contain the rule's switch or number. Checks of *health* are in \
         [reasons.md](../reasons.md).\n",
        args.draw,
        args.scenes,
        args.faulty,
        if args.cost { " --cost" } else { "" },
        base.len(),
        args.scenes,
        wrong(base),
        faulty.len(),
        wrong(faulty),
    )
}
