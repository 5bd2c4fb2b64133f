//! `calibrate`: estimates the mounting from a scan of the ground and a wall at a measured distance.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, ensure};
use serde_json::json;
use stairscan::estimate::Estimate;
use stairscan::health::Expected;
use stairscan::mount::Mounting;
use stairscan::mount::command::{Refusal, calibrate};
use stairscan::params::Params;
use stairscan::scanner;
use stairscan::scanner::command::framed;
use stairscan::scanner::settings::MotorConfig;
use stairscan::verdict::Reason;

use super::{Format, Settings, emit};
use crate::recording::Recording;
use crate::replay::{self, Options, Scanned};

/// Arguments of `calibrate`.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "The scene must contain only a flat floor and one wall. To simulate such a scan: \
        `cargo sim simulate scenes/wall.toml -o wall`."
)]
pub struct Args {
    /// Recording of one scan, with or without suffix
    recording: PathBuf,
    /// Horizontal distance from the mirror's centre to the wall, metres
    #[arg(long)]
    wall: f32,
    /// Current value of the scanner's setting `home-angle`, 0.001°
    #[arg(long, allow_negative_numbers = true, default_value_t = MotorConfig::default().home_angle)]
    home_angle: i32,
    #[command(flatten)]
    settings: Settings,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Estimates the mounting from a recording, and prints it with the commands that set it.
pub fn run(args: &Args) -> Result<ExitCode> {
    let recording = Recording::read(&args.recording)?;
    let options = args.settings.options(args.settings.config()?);
    let mounting = mounting(&recording, args.wall, &options)?;
    let settings = commands(&mounting, args.home_angle)?;
    emit(&match args.format {
        Format::Json => json(&recording.name, &mounting, &settings),
        Format::Text => text(&recording.name, &mounting, &settings),
    });
    Ok(ExitCode::SUCCESS)
}

/// Estimates the mounting of the scanner that made `recording`.
///
/// # Errors
/// The instrument has a fault, or the scene does not meet the requirements; the message names the cause.
pub fn mounting(recording: &Recording, wall_m: f32, options: &Options) -> Result<Mounting> {
    let name = &recording.name;
    ensure!(
        recording.scans() == 1,
        "{name}: {} scans: expected one, of a chair that stands",
        recording.scans()
    );
    let mut found = None;
    let first = Options {
        scans: Some(1),
        ..*options
    };
    replay::answers(recording, &first, |scanned| {
        found = Some(of(scanned, wall_m))
    })?;
    found
        .context("the scanner gave no answer")
        .and_then(|found| found)
        .with_context(|| name.clone())
}

fn of(scanned: &Scanned<'_>, wall_m: f32) -> Result<Mounting> {
    let (config, map) = (scanned.config, scanned.pipeline.map());
    let expected = Expected {
        moving: false,
        uncalibrated: true,
    };
    let health = scanned.pipeline.health();
    let doubts = health.failed_checks(config, map, expected);
    let doubts: Vec<&str> = (doubts.iter())
        .chain(health.fault(config.mount.mirror_offset > 0))
        .map(Reason::as_str)
        .collect();
    ensure!(
        doubts.is_empty(),
        "the instrument failed health checks: {}",
        doubts.join(", ")
    );
    let echoes = &scanned.pipeline.found().echoes;
    let mirror = health.mirror_seen(config);
    let refused = |refusal: Refusal| anyhow::anyhow!("{refusal}");
    calibrate(echoes, config, mirror, wall_m, &Params::DEFAULT).map_err(refused)
}

/// Returns the `set` commands, with CRC, that give a scanner the estimated mounting. `home_angle` is its present
/// setting, 0.001°.
fn commands(mounting: &Mounting, home_angle: i32) -> Result<Vec<String>> {
    let mut settings = scanner::Settings::default();
    settings.motor.home_angle = home_angle;
    settings.calibrate(mounting);
    settings.validate()?;
    let line = |key: &&str| {
        let value = settings.get(key)?;
        Some(framed(&["set", key, value.as_str()]).trim_end().to_owned())
    };
    let keys = scanner::Settings::CALIBRATED;
    Ok(keys.iter().filter_map(line).collect())
}

/// Returns value and standard error of an estimate, each multiplied by `unit` to convert it to the printed unit.
fn pair(estimate: Estimate, unit: f32) -> (f32, f32) {
    (unit * estimate.value, unit * estimate.sigma())
}

fn text(name: &str, m: &Mounting, commands: &[String]) -> String {
    let line = |what: &str, (value, sigma): (f32, f32), decimals: usize, unit: &str| {
        format!("  {what:<14}{value:9.decimals$} ± {sigma:.decimals$} {unit}\n")
    };
    let mut out = format!(
        "{name}: floor ({} echoes) and wall, standard errors\n",
        m.floor_echoes
    );
    let degree = 1f32.to_degrees();
    out += &line("mount height", pair(m.height_m, 1e3), 1, "mm");
    out += &line("angle offset", pair(m.offset_rad, degree), 3, "degrees");
    out += &line("range scale", pair(m.scale, 1.0), 4, "");
    out += &line("mirror echo", pair(m.mirror_echo_m, 1e3), 2, "mm");
    out += &format!(
        "  {:<14}{:9.1} dB below full scale\n",
        "its level", -m.mirror_level_db
    );
    out += "\ncommands\n";
    commands
        .iter()
        .for_each(|command| out += &format!("  {command}\n"));
    out
}

fn json(name: &str, m: &Mounting, commands: &[String]) -> String {
    let entry = |estimate: Estimate| {
        let (value, sigma) = pair(estimate, 1.0);
        json!({"value": value, "sigma": sigma})
    };
    let object = json!({
        "recording": name,
        "mount_height_m": entry(m.height_m),
        "angle_offset_rad": entry(m.offset_rad),
        "range_scale": entry(m.scale),
        "mirror_echo_m": entry(m.mirror_echo_m),
        "mirror_level_db": m.mirror_level_db,
        "floor_echoes": m.floor_echoes,
        "commands": commands,
    });
    format!("{object}\n")
}
