//! `simulate`: scene file in, recordings out.
//!
//! In place of a file, `random:KIND` selects the random scenes of [`crate::random`]: every seed
//! draws its own scene as well as its own surfaces and noise.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, ensure};
use clap::Args;
use indicatif::ParallelProgressIterator;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use crate::cache;
use crate::console::{busy, emit, progress};
use crate::counted::counted;
use crate::output::{Outputs, Overwrite, no_stdout};
use crate::random::{Kind, Spread, Variety, random_with};
use crate::recording::{DATA_SUFFIX, MAX_CHIRPS, Recording, meta_path};
use crate::scene::Scene;
use crate::scene::driving::Drive;
use crate::scene::sequence::{Approach, pushed};
use crate::scene::spec::SceneSpec;

/// Scans a scene file with the simulated radar and writes the recording.
#[derive(Args, Debug)]
pub struct SimulateArgs {
    /// Scene file (TOML; commented examples in scenes/), or random:KIND with the kinds of scenes/README.md.
    scene: PathBuf,
    /// Recording to write, with or without its suffix. With --count: a directory (created if missing) for SCENE_000,
    /// SCENE_001, …, or a name with {} in place of the number.
    #[arg(short, long)]
    output: PathBuf,
    /// Seed of surfaces, jitter and noise: the same seed gives the same bytes on every host. With random:KIND, seeds up
    /// to 999999 are free for use; seeds from 3000000 on are reserved for the published tables.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Number of recordings, with the seeds SEED, SEED + 1, …
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    count: Option<u32>,
    /// Number of scans in one recording of an approach, in which the chair stands during each scan. Random scenes are
    /// as far away as drawn at the last scan, scene files at the first.
    #[arg(long, value_parser = clap::value_parser!(u32).range(2..=64))]
    approach: Option<u32>,
    /// Travel between two scans of an approach, metres, varied by up to 40 %.
    #[arg(long, requires = "approach", default_value_t = 0.1)]
    step: f64,
    /// Speed of the chair during an approach, which then does not stand during a scan, m/s.
    #[arg(long, requires = "approach", conflicts_with = "step")]
    speed: Option<f64>,
    /// Duration of a scan at that speed, seconds; without it 1.3 or 5.7, drawn by the seed.
    #[arg(long, requires = "speed")]
    scan_time: Option<f64>,
    /// Number of chirps per row, whose mean each row is: independent noise, brought to one phase and added as a module
    /// does; without it that of the scene file, or 1.
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=i64::from(MAX_CHIRPS)), conflicts_with = "speed")]
    chirps_per_row: Option<u8>,
    /// Spread of a random scene's instrument (mount, beam, bandwidth, pitch); without it that of the scene's kind.
    #[arg(long, value_enum)]
    instrument: Option<Spread>,
    /// Spread of what a recording does not state (surfaces, antenna pattern, sweep errors, polarisation, yaw); without
    /// it that of the scene's kind.
    #[arg(long, value_enum)]
    effects: Option<Spread>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Motion of the chair in a recording: none, or the number of scans and the distance between two stops, metres, or the
/// number of scans, the speed, m/s, and optionally the time of a scan, seconds.
#[derive(Clone, Copy)]
enum Way {
    Stands,
    Stops(usize, f64),
    Drives(usize, f64, Option<f64>),
}

/// Returns a drive of `scans` scans at `speed` metres per second, with `rows` rows per scan. `scan_s` is the time of a
/// scan, seconds; without it the seed draws it.
fn drive(seed: u64, (scans, speed, scan_s): (usize, f64, Option<f64>), rows: usize) -> Drive {
    let drive = Drive::new(seed, scans, speed);
    match scan_s {
        Some(seconds) => drive.with_rows(seconds / rows as f64),
        None => drive,
    }
}

/// Source of the simulated scenes.
enum Source {
    /// One scene for all seeds.
    File(Box<Scene>),
    /// A different scene for every seed, with this number of chirps per row.
    Random(Kind, Variety, u8),
}

impl Source {
    fn new(args: &SimulateArgs) -> Result<Self> {
        let name = &args.scene;
        let Some(kind) = name.to_str().and_then(|text| text.strip_prefix("random:")) else {
            ensure!(
                args.instrument.is_none() && args.effects.is_none(),
                "--instrument, --effects: expected random:KIND as scene, not {}: a scene file \
                 contains it",
                name.display()
            );
            let scene = Scene::read(name)?;
            let scene = match args.chirps_per_row {
                Some(chirps) => scene.with_chirps(chirps)?,
                None => scene,
            };
            return Ok(Self::File(Box::new(scene)));
        };
        let kind: Kind = kind.parse().map_err(|e| anyhow!("random: {e}"))?;
        let own = kind.variety();
        let variety = Variety {
            instrument: args.instrument.unwrap_or(own.instrument),
            effects: args.effects.unwrap_or(own.effects),
        };
        Ok(Self::Random(
            kind,
            variety,
            args.chirps_per_row.unwrap_or(1),
        ))
    }

    /// Simulates with `seed` and writes the recording. Returns the numbers of chirps and scans.
    fn write(&self, outputs: &Outputs, path: &Path, seed: u64, way: Way) -> Result<(usize, usize)> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let recording = match (self, way) {
            (Self::File(scene), Way::Stands) => scene.simulate(&name, seed),
            (Self::File(scene), Way::Stops(scans, step)) => {
                scene.simulate_approach(&name, seed, &Approach::new(seed, scans, step))?
            }
            (Self::File(scene), Way::Drives(scans, speed, scan_s)) => {
                let drive = drive(seed, (scans, speed, scan_s), scene.rows());
                scene.simulate_drive(&name, seed, &drive)?
            }
            (Self::Random(kind, variety, chirps), Way::Stands) => {
                let spec = dwelling(random_with(*kind, *variety, seed), *chirps);
                scan_of(spec, &random_name(*kind, seed), seed)?
            }
            (Self::Random(kind, variety, chirps), Way::Stops(scans, step)) => {
                let spec = dwelling(random_with(*kind, *variety, seed), *chirps);
                let approach = Approach::new(seed, scans, step);
                approach_to(spec, &random_name(*kind, seed), seed, &approach)?
            }
            (Self::Random(kind, variety, _), Way::Drives(scans, speed, scan_s)) => {
                random_drive(*kind, *variety, seed, (scans, speed, scan_s))?
            }
        };
        outputs.write_recording(path, &recording)?;
        Ok((recording.chirps(), recording.scans()))
    }
}

/// Returns the scan of the random scene `seed` of a kind, named `KIND_SEED`.
pub fn random_scan(kind: Kind, variety: Variety, seed: u64) -> Result<Recording> {
    let spec = random_with(kind, variety, seed);
    scan_of(spec, &random_name(kind, seed), seed)
}

/// Returns the name of the recording of a random scene.
fn random_name(kind: Kind, seed: u64) -> String {
    format!("{kind}_{seed:03}")
}

/// Returns the scene with `chirps` chirps per row.
fn dwelling(mut spec: SceneSpec, chirps: u8) -> SceneSpec {
    spec.radar.chirps_per_row = chirps;
    spec
}

/// Returns the scan of a scene, from the cache if it is there.
pub fn scan_of(spec: SceneSpec, name: &str, seed: u64) -> Result<Recording> {
    let key = format!("scan {seed} of {spec:?}");
    cache::recording(name, &key, || Ok(Scene::new(spec)?.simulate(name, seed)))
}

/// Returns an approach to the random scene `seed` of a kind, which is as far away as drawn at the
/// last stop.
pub fn random_approach(
    kind: Kind,
    variety: Variety,
    seed: u64,
    approach: &Approach,
) -> Result<Recording> {
    let spec = random_with(kind, variety, seed);
    approach_to(spec, &random_name(kind, seed), seed, approach)
}

/// Returns an approach to a scene, which is as far away as `spec` states at the last stop; from the cache if it is
/// there.
fn approach_to(spec: SceneSpec, name: &str, seed: u64, approach: &Approach) -> Result<Recording> {
    let spec = pushed(spec, approach.length_m());
    let key = format!("approach {seed} {approach:?} of {spec:?}");
    cache::recording(name, &key, || {
        Scene::new(spec)?.simulate_approach(name, seed, approach)
    })
}

/// Returns a drive towards the random scene `seed` of a kind, which is as far away as drawn at the
/// end. `way` holds the number of scans, the speed in metres per second and, optionally, the time
/// of a scan in seconds.
pub fn random_drive(
    kind: Kind,
    variety: Variety,
    seed: u64,
    way: (usize, f64, Option<f64>),
) -> Result<Recording> {
    let drawn = random_with(kind, variety, seed);
    let name = random_name(kind, seed);
    let key = format!("drive {seed} {way:?} to {drawn:?}");
    cache::recording(&name, &key, || {
        let rows = Scene::new(drawn.clone())?.rows();
        let drive = drive(seed, way, rows);
        let scene = Scene::new(pushed(drawn, drive.length_m(rows)))?;
        scene.simulate_drive(&name, seed, &drive)
    })
}

/// Runs the command.
pub fn simulate(args: &SimulateArgs) -> Result<()> {
    let source = Source::new(args)?;
    let outputs = args.overwrite.reading([&args.scene]);
    ensure!(
        (0.0..=1.0).contains(&args.step),
        "--step: {}: expected 0 to 1 metre",
        args.step
    );
    ensure!(
        args.speed.is_none_or(|v| (0.0..=2.0).contains(&v)),
        "--speed: {}: expected 0 to 2 metres a second",
        args.speed.unwrap_or_default()
    );
    ensure!(
        args.scan_time.is_none_or(|s| (0.1..=60.0).contains(&s)),
        "--scan-time: {}: expected 0.1 to 60 seconds",
        args.scan_time.unwrap_or_default()
    );
    let approach = match (args.approach, args.speed) {
        (None, _) => Way::Stands,
        (Some(scans), None) => Way::Stops(scans as usize, args.step),
        (Some(scans), Some(speed)) => Way::Drives(scans as usize, speed, args.scan_time),
    };
    let Some(count) = args.count else {
        outputs.ready_recording(&args.output)?;
        let bar = busy("the simulated radar scans");
        let (chirps, scans) = source.write(&outputs, &args.output, args.seed, approach)?;
        bar.finish_and_clear();
        emit(&summary(&args.output, chirps, scans));
        return Ok(());
    };
    let name = pattern(&args.scene, &args.output)?;
    (0..count).try_for_each(|k| outputs.check_recording(Path::new(&numbered(&name, k))))?;
    let bar = progress(count.into());
    let written = (0..count)
        .into_par_iter()
        .progress_with(bar.clone())
        .map(|k| {
            let path = numbered(&name, k);
            let seed = args.seed.wrapping_add(k.into());
            source
                .write(&outputs, Path::new(&path), seed, approach)
                .map(|_| ())
        });
    written.collect::<Result<()>>()?;
    bar.finish_and_clear();
    emit(&summary_of_many(&name, count));
    Ok(())
}

/// Returns the message after one simulated recording: what was written, and the commands to use next.
fn summary(output: &Path, chirps: usize, scans: usize) -> String {
    let (meta, name) = (meta_path(output), output.display());
    format!(
        "{}: {}, {}, with ground truth; samples beside it in \
         .{DATA_SUFFIX}\nnext: cargo sim replay {name} for the answer, cargo sim report {name} for \
         an HTML report\n",
        meta.display(),
        counted(chirps, "chirp"),
        counted(scans, "scan")
    )
}

/// Returns the message after `count` simulated recordings: what was written, and the commands to use next.
fn summary_of_many(pattern: &str, count: u32) -> String {
    let dir = Path::new(pattern)
        .parent()
        .filter(|dir| !dir.as_os_str().is_empty());
    let dir = dir.unwrap_or(Path::new(".")).display();
    let (first, last) = (0, count.saturating_sub(1));
    let name = |k| numbered(pattern, k);
    format!(
        "{}, {} to {}, with ground truth\nnext: cargo sim score {dir} to evaluate \
         the answers, cargo sim report {dir} for an HTML report of all\n",
        counted(count, "recording"),
        name(first),
        name(last)
    )
}

/// Returns the path of recording `k`: `pattern` with `{}` replaced by three digits.
fn numbered(pattern: &str, k: u32) -> String {
    pattern.replacen("{}", &format!("{k:03}"), 1)
}

/// Returns the path of the recordings, with `{}` for the number, and creates the directory `output` unless `output` has
/// `{}`.
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
    no_stdout(output)?;
    fs::create_dir_all(output).with_context(|| name.to_string())?;
    let path = output.join(format!("{stem}_{{}}"));
    Ok(path.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_says_what_it_wrote_and_what_to_do_next() {
        let text = summary(Path::new("my_stairs"), 281, 1);
        assert!(
            text.starts_with("my_stairs.sigmf-meta: 281 chirps, 1 scan,"),
            "{text}"
        );
        assert!(text.contains("cargo sim replay my_stairs "), "{text}");
        let text = summary_of_many("many/stair_a_{}", 3);
        assert!(
            text.contains("many/stair_a_000 to many/stair_a_002"),
            "{text}"
        );
        assert!(text.contains("cargo sim score many "), "{text}");
    }

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
