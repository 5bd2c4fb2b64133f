//! `simulate`: simulates full scans ([`crate::simulation`]), or with `--guard` guard sweeps of a driving
//! chair.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context as _, Result, anyhow, ensure};
use clap::{ArgMatches, Command, Error, FromArgMatches, ValueEnum};

use super::{busy, emit};
use crate::counted::counted;
use crate::output::Overwrite;
use crate::recording::{self, Recording, meta_path};
use crate::scene::Scene;
use crate::scene::spec::SceneSpec;
use crate::simulation::{SimulateArgs, simulate};
use crate::sweeps::scenes::{self, Kind};

/// Default speed of the chair for simulated guard sweeps, m/s.
const SPEED: f64 = 0.2;

/// Arguments of `simulate`: those of full scans, or of guard sweeps.
#[derive(Debug)]
pub enum Args {
    /// Arguments for full scans.
    Scans(SimulateArgs),
    /// Arguments for guard sweeps.
    Guard(Guard),
}

/// The options of guard sweeps alone.
#[derive(clap::Args, Clone, Copy, Debug)]
struct Options {
    /// Simulate guard sweeps of a chair that drives at this speed (m/s; 0.2 if not given) in place of a full scan. With
    /// random:KIND, the kinds are those of `guard`, which draw their own speed.
    #[arg(long, value_name = "SPEED", num_args = 0..=1, require_equals = true,
          conflicts_with_all = ["approach", "count", "instrument", "effects", "chirps_per_row"])]
    guard: Option<Option<f64>>,
    /// Number of guard sweeps; without it 14.
    #[arg(long, requires = "guard", value_parser = clap::value_parser!(u32).range(1..=64))]
    sweeps: Option<u32>,
}

/// Arguments for guard sweeps.
#[derive(Debug)]
pub struct Guard {
    scene: PathBuf,
    output: PathBuf,
    seed: u64,
    speed: Option<f64>,
    sweeps: Option<u32>,
    overwrite: Overwrite,
}

impl clap::Args for Args {
    fn augment_args(command: Command) -> Command {
        Options::augment_args(SimulateArgs::augment_args(command))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Options::augment_args_for_update(SimulateArgs::augment_args_for_update(command))
    }
}

impl FromArgMatches for Args {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let Options { guard, sweeps } = Options::from_arg_matches(matches)?;
        let Some(speed) = guard else {
            return SimulateArgs::from_arg_matches(matches).map(Self::Scans);
        };
        // Both paths are required arguments, and the seed has a default.
        let path = |name| {
            matches
                .get_one::<PathBuf>(name)
                .cloned()
                .unwrap_or_default()
        };
        Ok(Self::Guard(Guard {
            scene: path("scene"),
            output: path("output"),
            seed: matches.get_one("seed").copied().unwrap_or_default(),
            speed,
            sweeps,
            overwrite: Overwrite::from_arg_matches(matches)?,
        }))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Guard {
    /// Simulates the guard sweeps. The recording of a scene file is named `name`; that of a random scene has its own
    /// name.
    fn recording(&self, name: &str) -> Result<Recording> {
        if let Some(kind) = self
            .scene
            .to_str()
            .and_then(|text| text.strip_prefix("random:"))
        {
            ensure!(
                self.speed.is_none() && self.sweeps.is_none(),
                "--guard=SPEED, --sweeps: expected a scene file, not random:{kind}, which draws its own"
            );
            let kind = Kind::from_str(kind, false).map_err(|_| {
                let names = Kind::ALL.map(Kind::name).join(", ");
                anyhow!("random: {kind}: of guard sweeps expected one of {names}")
            })?;
            return scenes::recording(kind, self.seed);
        }
        let speed = self.speed.unwrap_or(SPEED);
        ensure!(
            (0.0..=2.0).contains(&speed),
            "--guard: {speed}: expected 0 to 2 metres a second"
        );
        let sweeps = self.sweeps.map_or(scenes::SWEEPS, |n| n as usize);
        let drive = scenes::drive(self.seed, sweeps, speed);
        scenes::sweeps_of(spec(&self.scene)?, name, self.seed, &drive)
    }

    fn run(&self) -> Result<ExitCode> {
        let outputs = self.overwrite.reading([&self.scene]);
        outputs.ready_recording(&self.output)?;
        let bar = busy("the simulated radar sweeps");
        let name = self
            .output
            .file_name()
            .unwrap_or_default()
            .to_string_lossy();
        let recording = self.recording(&name)?;
        outputs.write_recording(&self.output, &recording)?;
        bar.finish_and_clear();
        emit(&format!(
            "{}: {}, with the first hazard of each\n\
             next: cargo sim replay {} for the free distances\n",
            meta_path(&self.output).display(),
            counted(recording.scans(), "guard sweep"),
            self.output.display()
        ));
        Ok(ExitCode::SUCCESS)
    }
}

/// Reads a scene from the file at `path`, and checks that it can be built.
fn spec(path: &Path) -> Result<SceneSpec> {
    // Building it reports errors with their place.
    Scene::read(path)?;
    let text = recording::text(path)?;
    toml::from_str(&text).with_context(|| format!("{}", path.display()))
}

/// Simulates full scans or guard sweeps, and writes the recordings.
pub fn run(args: &Args) -> Result<ExitCode> {
    match args {
        Args::Scans(scans) => simulate(scans).map(|()| ExitCode::SUCCESS),
        Args::Guard(guard) => guard.run(),
    }
}
