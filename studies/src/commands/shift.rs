//! `shift`: answers to scenes that are drawn alike with one property moved, paired with those as drawn.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Result, ensure};
use host_sim::recording::Recording;
use host_sim::replay::Options;
use host_sim::score::SceneScore;
use host_sim::seeds::Draw;

use super::{emit, may_list, recordings, with_list};
use crate::harness::{self, Drawn, scored};
use crate::shift::{HEADING, NOISE, PROPERTIES, Shift, falls, lost, row};

/// Arguments of `shift`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Draw of the scenes
    #[arg(long, value_enum, default_value_t)]
    draw: Draw,
    /// Number of scenes of each kind
    #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    scenes: u64,
    /// Only this property; may be given several times
    #[arg(long, value_name = "PROPERTY")]
    only: Vec<String>,
    /// Also list the scenes that are no longer exact or `ok`; refused with `--draw reporting`, whose scenes must not be
    /// inspected
    #[arg(long)]
    list: bool,
    /// Also score recordings of single scans with ground truth, with or without suffix, or a directory of them; may be
    /// given several times
    #[arg(long, value_name = "REC")]
    on: Vec<PathBuf>,
}

/// Prints the table; fails if exact answers or `ok` fall as noise does.
pub fn run(args: &Args) -> Result<ExitCode> {
    for name in &args.only {
        let names: Vec<_> = PROPERTIES.iter().map(|p| p.name).collect();
        ensure!(
            names.contains(&name.as_str()),
            "--only: \"{name}\": expected one of {}",
            names.join(", ")
        );
    }
    may_list("--list", args.list, "scenes", args.draw)?;
    let scenes = harness::scenes(args.draw, |_| args.scenes);
    let options = Options::default();
    let drawn = harness::each(&scenes, |scene: &Drawn| scored(&scene.scan()?, &options))?;
    let mut out = String::from(HEADING);
    row(&mut out, ["as drawn", ""], &drawn, None);
    let mut list = Vec::new();
    let mut levels = vec![(0.0, drawn.clone())];
    for shift in Shift::all(&args.only) {
        let moved = harness::each(&scenes, |scene: &Drawn| {
            scored(&shift.scan(scene)?, &options)
        })?;
        let value = format!("{} {}", shift.value, shift.property.unit);
        row(
            &mut out,
            [shift.property.name, &value],
            &moved,
            Some(&drawn),
        );
        if args.list {
            list.extend(
                lost(&drawn, &moved).map(|line| format!("{} {value}: {line}", shift.property.name)),
            );
        }
        if shift.property.name == NOISE {
            levels.push((shift.value, moved));
        }
    }
    for path in &args.on {
        let scores = others(path)?;
        row(&mut out, ["recordings", &file_name(path)], &scores, None);
    }
    emit(&with_list(out, "No longer exact or `ok`", &list));
    levels.sort_by(|a, b| b.0.total_cmp(&a.0));
    let falls = falls(&levels);
    for line in &falls {
        host_sim::note!("error: {line}");
    }
    Ok(ExitCode::from(u8::from(!falls.is_empty())))
}

fn file_name(path: &std::path::Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// Scores the recordings of single scans with ground truth.
fn others(path: &PathBuf) -> Result<Vec<SceneScore>> {
    let all = recordings(std::slice::from_ref(path))?;
    let read = harness::each(&all, |path| Recording::read(path))?;
    let single = |r: &&Recording| r.scans() == 1 && r.meta.truth.is_some();
    let single: Vec<_> = read.iter().filter(single).collect();
    ensure!(
        !single.is_empty(),
        "{}: expected recordings of single scans with ground truth",
        path.display()
    );
    harness::each(&single, |recording| scored(recording, &Options::default()))
}
