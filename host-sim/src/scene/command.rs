//! `simulate`: scene file in, recordings out.
//!
//! In place of a file, `random:KIND` stands for the random scenes of [`super::random`]: every seed draws
//! its own scene as well as its own surfaces and noise.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, ensure};
use clap::Args;
use indicatif::ParallelProgressIterator;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::Scene;
use super::random::{Kind, Spread, Variety, random_with};
use super::sequence::{Approach, pushed};
use crate::commands::progress;
use crate::recording::Recording;

/// Scans a scene file with the simulated radar and writes the recording.
#[derive(Args, Debug)]
pub struct SimulateArgs {
    /// Scene file (TOML; scenes/ holds commented examples), or random:KIND, the kinds being those of
    /// scenes/README.md.
    scene: PathBuf,
    /// Recording to write, with or without its suffix. With --count: a directory (made if need be)
    /// for SCENE_000, SCENE_001, …, or a name in which {} stands for the number.
    #[arg(short, long)]
    output: PathBuf,
    /// Seed of surfaces, jitter and noise: the same seed gives the same bytes on every host. With
    /// random:KIND those up to 999999 are there to look at; the seeds from 3000000 on are for the
    /// published tables alone.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Number of recordings, with the seeds SEED, SEED + 1, …
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    count: Option<u32>,
    /// This many scans in one recording, of a chair that comes nearer and stands during each. Random
    /// scenes stand as far away as drawn at the last of them, scene files at the first.
    #[arg(long, value_parser = clap::value_parser!(u32).range(2..=64))]
    approach: Option<u32>,
    /// Way between two scans of an approach, metres, up to 40 % less or more.
    #[arg(long, requires = "approach", default_value_t = 0.1)]
    step: f64,
    /// How widely a random scene's instrument is drawn (mount, beam, bandwidth, pitch); without it as its
    /// kind has it.
    #[arg(long, value_enum)]
    instrument: Option<Spread>,
    /// How widely what a recording does not state is drawn (surfaces, antenna pattern, sweep errors,
    /// polarisation, yaw); without it as its kind has it.
    #[arg(long, value_enum)]
    effects: Option<Spread>,
}

/// Where scenes come from.
enum Source {
    /// One scene for all seeds.
    File(Box<Scene>),
    /// Another one for every seed.
    Random(Kind, Variety),
}

impl Source {
    fn new(args: &SimulateArgs) -> Result<Self> {
        let name = &args.scene;
        let Some(kind) = name.to_str().and_then(|text| text.strip_prefix("random:")) else {
            ensure!(
                args.instrument.is_none() && args.effects.is_none(),
                "--instrument, --effects: expected random:KIND as scene, not {}: a scene file says it \
                 itself",
                name.display()
            );
            return Ok(Self::File(Box::new(Scene::read(name)?)));
        };
        let kind: Kind = kind.parse().map_err(|e| anyhow!("random: {e}"))?;
        let own = kind.variety();
        let variety = Variety {
            instrument: args.instrument.unwrap_or(own.instrument),
            effects: args.effects.unwrap_or(own.effects),
        };
        Ok(Self::Random(kind, variety))
    }

    /// Scans with `seed` and writes the recording.
    fn write(&self, path: &Path, seed: u64, approach: Option<(usize, f64)>) -> Result<()> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let approach = approach.map(|(scans, step)| Approach::new(seed, scans, step));
        let recording = match (self, approach) {
            (Self::File(scene), None) => scene.simulate(&name, seed),
            (Self::File(scene), Some(a)) => scene.simulate_approach(&name, seed, &a)?,
            (Self::Random(kind, variety), None) => random_scan(*kind, *variety, seed)?,
            (Self::Random(kind, variety), Some(a)) => random_approach(*kind, *variety, seed, &a)?,
        };
        recording.write(path)
    }
}

/// Scan of the random scene `seed` of a kind, under the name `KIND_SEED`.
pub fn random_scan(kind: Kind, variety: Variety, seed: u64) -> Result<Recording> {
    let scene = Scene::new(random_with(kind, variety, seed))?;
    Ok(scene.simulate(&format!("{kind}_{seed:03}"), seed))
}

/// An approach to the random scene `seed` of a kind, which is as far away as drawn at its last stop.
pub fn random_approach(
    kind: Kind,
    variety: Variety,
    seed: u64,
    approach: &Approach,
) -> Result<Recording> {
    let spec = pushed(random_with(kind, variety, seed), approach.length_m());
    Scene::new(spec)?.simulate_approach(&format!("{kind}_{seed:03}"), seed, approach)
}

/// Runs the command.
pub fn simulate(args: &SimulateArgs) -> Result<()> {
    let source = Source::new(args)?;
    ensure!(
        (0.0..=1.0).contains(&args.step),
        "--step: {}: expected 0 to 1 metre",
        args.step
    );
    let approach = args.approach.map(|scans| (scans as usize, args.step));
    let Some(count) = args.count else {
        return source.write(&args.output, args.seed, approach);
    };
    let name = pattern(&args.scene, &args.output)?;
    (0..count)
        .into_par_iter()
        .progress_with(progress(count.into()))
        .map(|k| {
            let path = name.replacen("{}", &format!("{k:03}"), 1);
            source.write(Path::new(&path), args.seed.wrapping_add(k.into()), approach)
        })
        .collect()
}

/// The path of the recordings, with `{}` for the number.
fn pattern(scene: &Path, output: &Path) -> Result<String> {
    let name = output
        .to_str()
        .context("--output: expected a name in UTF-8")?;
    if name.contains("{}") {
        return Ok(name.into());
    }
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    let stem = stem.strip_prefix("random:").unwrap_or(&stem);
    ensure!(
        !output.is_file(),
        "{name}: a file: expected a directory, or a name with {{}} for the number"
    );
    fs::create_dir_all(output).with_context(|| name.to_string())?;
    let path = output.join(format!("{stem}_{{}}"));
    Ok(path.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_many_recordings() {
        let scene = Path::new("scenes/stair_a.toml");
        let given = pattern(scene, Path::new("/nowhere/run{}")).unwrap();
        assert_eq!(given, "/nowhere/run{}");
        let dir = std::env::temp_dir().join(format!("stairscan-pattern-{}", std::process::id()));
        let made = pattern(scene, &dir).unwrap();
        assert!(made.ends_with("stair_a_{}") && dir.is_dir());
        fs::remove_dir(&dir).unwrap();
        assert!(pattern(scene, Path::new("Cargo.toml")).is_err());
    }
}
