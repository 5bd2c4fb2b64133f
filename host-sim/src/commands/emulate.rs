//! `emulate REC…`: recorded scans through the very image, in an emulator.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};
use stairscan::config::Config;
use stairscan::scan::Settings as ScannerSettings;

use super::replay::show;
use super::{Format, Settings};
use crate::answer::Answer;
use crate::emulate::module::Misdeed;
use crate::emulate::session::Waits;
use crate::emulate::{Fault, Session, image};
use crate::playback::Playback;
use crate::recording::Recording;

/// Arguments of `emulate`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Recordings, with or without suffix; each is scan 1 after a boot of its own
    #[arg(required = true)]
    recordings: Vec<PathBuf>,
    /// The image; without it the workspace's is built
    #[arg(long)]
    elf: Option<PathBuf>,
    #[command(flatten)]
    settings: Settings,
    /// Scans one after the other, each the other way round
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    scans: u32,
    /// What the radar module does wrong in the first scan: KIND[@ROW[-LAST]][xTIMES] with KIND one
    /// of lost, corrupt, repeat, late, error, silent, config
    #[arg(long = "fault")]
    faults: Vec<Fault>,
    /// How to print
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Scans every recording; a bad one or a fault makes the exit status 1 and the rest goes on.
pub fn run(args: &Args) -> Result<ExitCode> {
    let elf = match &args.elf {
        Some(elf) => elf.clone(),
        None => image::build(&[])?,
    };
    let config = args.settings.config()?;
    let mut code = ExitCode::SUCCESS;
    for path in &args.recordings {
        let mut good = true;
        let result = Recording::read(path).and_then(|recording| {
            emulate(&elf, &recording, &config, args, |answer| {
                good &= show(Ok(answer), args.format);
            })
        });
        if let Err(error) = result {
            good = show(Err(error), args.format);
        }
        if !good {
            code = ExitCode::FAILURE;
        }
    }
    Ok(code)
}

/// One boot: configured while the module keeps its handshake back, then scanning.
fn emulate(
    elf: &Path,
    recording: &Recording,
    config: &Config,
    args: &Args,
    mut answered: impl FnMut(Answer),
) -> Result<()> {
    let name = &recording.name;
    let playback = Playback::new(recording, config)?;
    let settings = ScannerSettings {
        config: *playback.config(),
        ..ScannerSettings::default()
    };
    let mut waits = Waits::default();
    if !args.faults.is_empty() {
        // What never comes is waited for: not longer than a busy host needs.
        (waits.chirp, waits.configure) = (10_000_000, 5_000_000);
    }
    if args.faults.iter().any(|f| f.misdeed == Misdeed::Silent) {
        waits.connect = 20_000_000;
    }
    let mut session = Session::boot(elf, &playback).with_context(|| name.clone())?;
    session
        .configure(&settings, waits)
        .with_context(|| name.clone())?;
    session.module.set_faults(&args.faults);
    session.skip_lines();
    session.connect()?;
    for scan in 0..args.scans {
        let sentences = session.scan().with_context(|| name.clone())?;
        answered(Answer::parse(name, sentences)?);
        if scan == 0 {
            session.module.set_faults(&[]);
        }
    }
    Ok(())
}
