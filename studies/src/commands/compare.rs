//! `compare`: compares two estimators on the same scenes, from the files of `accuracy --each`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};
use stairscan::verdict::Status;

use super::emit;
use host_sim::score::{Change, SceneScore};

/// Arguments of `compare`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// File of `accuracy --each` by the first estimator
    before: PathBuf,
    /// File of `accuracy --each` by the second one
    after: PathBuf,
}

/// One scene's scored answer, a line in the files of `accuracy --each`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Line {
    scene: String,
    kind: String,
    status: String,
    exact: bool,
    wrong: bool,
}

impl Line {
    fn ok(&self) -> bool {
        self.status == Status::Ok.as_str()
    }
}

/// Returns the text of a file of `accuracy --each`: one line of JSON for each scene.
///
/// # Errors
/// None with the fields of a score.
pub fn lines<'a>(scenes: impl Iterator<Item = &'a SceneScore>) -> Result<String> {
    let mut text = String::new();
    for s in scenes {
        let line = Line {
            scene: s.recording.clone(),
            kind: s.set.clone(),
            status: s.status.as_str().to_owned(),
            exact: s.exact,
            wrong: s.wrong,
        };
        let _ = writeln!(text, "{}", serde_json::to_string(&line)?);
    }
    Ok(text)
}

fn read(path: &Path) -> Result<Vec<Line>> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let lines = text.lines().enumerate().map(|(k, line)| {
        serde_json::from_str(line).with_context(|| format!("{}:{}", path.display(), k + 1))
    });
    lines.collect()
}

/// Compares the answers in two files and prints the table by kind of scene.
pub fn run(args: &Args) -> Result<ExitCode> {
    let (before, after) = (read(&args.before)?, read(&args.after)?);
    let same = before.iter().zip(&after).all(|(a, b)| a.scene == b.scene);
    ensure!(
        same && before.len() == after.len(),
        "{}: expected the scenes of {}, in the same order",
        args.after.display(),
        args.before.display()
    );
    let pairs: Vec<(&Line, &Line)> = before.iter().zip(&after).collect();
    let mut kinds: Vec<&str> = Vec::new();
    for line in &before {
        if !kinds.contains(&line.kind.as_str()) {
            kinds.push(&line.kind);
        }
    }
    let mut out = String::from(
        "| scenes | | exact | p | `ok` and right | p | `ok` and wrong, of `ok` | `ok` of what is not wrong |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    for kind in kinds {
        let of: Vec<_> = pairs
            .iter()
            .filter(|(a, _)| a.kind == kind)
            .copied()
            .collect();
        row(&mut out, kind, &of);
    }
    row(&mut out, "all", &pairs);
    emit(&out);
    Ok(ExitCode::SUCCESS)
}

fn row(out: &mut String, name: &str, pairs: &[(&Line, &Line)]) {
    let change = |has: &dyn Fn(&Line) -> bool| {
        let change = Change::of(pairs.iter().map(|(a, b)| (has(a), has(b))));
        let count = |k: usize| pairs.iter().filter(|(a, b)| has([*a, *b][k])).count();
        format!(
            "{} → {} (+{} -{}) | {:.3}",
            count(0),
            count(1),
            change.gained,
            change.lost,
            change.p()
        )
    };
    let share = |k: usize| {
        let of = pairs.iter().map(|(a, b)| [*a, *b][k]);
        let right = of
            .clone()
            .filter(|l| !l.wrong && l.status != Status::Fault.as_str());
        let (right, ok) = (right.clone().count(), right.filter(|l| l.ok()).count());
        let wrong = of.clone().filter(|l| l.ok() && l.wrong).count();
        let all = of.filter(|l| l.ok()).count();
        (
            format!("{wrong} of {all}"),
            100.0 * ok as f64 / right.max(1) as f64,
        )
    };
    let (before, after) = (share(0), share(1));
    let _ = writeln!(
        out,
        "| {name} | {} | {} | {} | {} → {} | {:.1} → {:.1} % |",
        pairs.len(),
        change(&|l| l.exact),
        change(&|l| l.ok() && !l.wrong),
        before.0,
        after.0,
        before.1,
        after.1
    );
}
