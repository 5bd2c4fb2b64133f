//! `emulate REC…`: scans recordings with the firmware image, in an emulator.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use anyhow::{Context, Result, anyhow, ensure};

use super::replay::{show, show_guarded};
use super::{Format, Settings, busy, live, progress_after_start};
use crate::answer::Answer;
use crate::emulate::module::InjectedFault;
use crate::emulate::session::Waits;
use crate::emulate::tools::Tool;
use crate::emulate::{Fault, Session, guarding, image};
use crate::guarded::Guarded;
use crate::live::keep::Keep;
use crate::live::model::State;
use crate::live::port::Source;
use crate::live::pty::Pty;
use crate::live::session::Session as Watched;
use crate::live::trouble::REPORT_BAUD;
use crate::playback::Playback;
use crate::recording::Recording;
use crate::replay;
use crate::setup::{self, Kind};

/// Arguments of `emulate`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Recordings, with or without suffix; each begins with scan 1 after its own boot
    #[arg(required = true)]
    recordings: Vec<PathBuf>,
    /// The image; without it the workspace's image is built
    #[arg(long)]
    elf: Option<PathBuf>,
    #[command(flatten)]
    settings: Settings,
    /// Number of consecutive scans in alternating direction; without it those of the recording
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=100))]
    scans: Option<u32>,
    /// Treat every scan of a recording as if it were the first, after its own boot
    #[arg(long)]
    single: bool,
    /// Fault of the radar module in the first scan: KIND[@ROW[-LAST]][xTIMES] with KIND one of lost, corrupt, repeat,
    /// late, error, silent, config
    #[arg(long = "fault")]
    faults: Vec<Fault>,
    /// Show the image in the terminal through a pseudo-terminal, as `live` shows a scanner at a port: one recording,
    /// repeated
    #[arg(long, conflicts_with_all = ["scans", "single", "format"])]
    live: bool,
    /// With --live: write every sentence with its time to a new file in this directory
    #[arg(long, value_name = "DIR", requires = "live")]
    record: Option<PathBuf>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Scans every recording with the image. A bad recording or a fault sets the exit status to 1; the others are still
/// scanned.
pub fn run(args: &Args) -> Result<ExitCode> {
    ensure!(
        !args.live || args.recordings.len() == 1,
        "--live: expected one recording, found {}",
        args.recordings.len()
    );
    // A build takes minutes: all that can be refused is refused before.
    let read: Vec<Result<Recording>> = args.recordings.iter().map(|p| read(p, args)).collect();
    let (mut code, mut recordings) = (ExitCode::SUCCESS, Vec::new());
    for recording in read {
        match recording {
            Ok(recording) => recordings.push(recording),
            Err(error) => {
                show(Err(error), None, args.format);
                code = ExitCode::FAILURE;
            }
        }
    }
    args.record.iter().try_for_each(|dir| Keep::check(dir))?;
    if recordings.is_empty() {
        return Ok(code);
    }
    let elf = image(args)?;
    if args.live {
        return watch(&elf, &recordings[0], args);
    }
    for recording in &recordings {
        let mut good = true;
        if let Err(error) = scan(&elf, recording, args, &mut good) {
            good = show(Err(error), None, args.format);
        }
        if !good {
            code = ExitCode::FAILURE;
        }
    }
    Ok(code)
}

/// Returns the image that the arguments name, or else that of the workspace, which is built; both only if there is an
/// emulator for it.
fn image(args: &Args) -> Result<PathBuf> {
    if let Some(elf) = &args.elf {
        image::check(elf)?;
    }
    Tool::Emulator.need()?;
    args.elf.clone().map_or_else(|| image::build(&[]), Ok)
}

/// Reads a recording, and checks that it can be played to the image as the arguments say.
fn read(path: &Path, args: &Args) -> Result<Recording> {
    let recording = Recording::read(path)?;
    let config = args.settings.config()?;
    let playback = Playback::new(&recording, &config)?;
    options(args)?.scans_of(&recording)?;
    let name = &recording.name;
    if setup::kind(&recording)? == Kind::Guard && !args.live {
        ensure!(
            !args.single,
            "{name}: --single: expected full scans, found guard sweeps"
        );
        let settings = playback.guarding().settings();
        let fits = settings.guard.check(&settings.config);
        fits.map_err(|error| anyhow!("{name}: guard: {error}"))?;
    }
    Ok(recording)
}

/// Returns the options of a replay that has the same scans.
fn options(args: &Args) -> Result<replay::Options> {
    Ok(replay::Options {
        scans: args.scans,
        single: args.single,
        ..args.settings.options(args.settings.config()?)
    })
}

/// Scans a recording with the image and prints its answers. A fault sets `good` to false.
fn scan(elf: &Path, recording: &Recording, args: &Args, good: &mut bool) -> Result<()> {
    if setup::kind(recording)? == Kind::Guard {
        *good &= show_guarded(&guarded(elf, recording, args)?, args.format);
        return Ok(());
    }
    emulate(elf, recording, args, |a| {
        let truth = recording.truth(a.scan_of_recording());
        *good &= show(Ok(a), truth, args.format);
    })
}

/// Scans a recording with the image, and calls `answered` with the answer to each scan.
fn emulate(
    elf: &Path,
    recording: &Recording,
    args: &Args,
    mut answered: impl FnMut(Answer),
) -> Result<()> {
    let scans = options(args)?.scans_of(recording)?;
    let several = recording.scans() > 1;
    let mut parse = |k: usize, sentences| -> Result<()> {
        let part = several.then_some(k as u32 + 1);
        let answer = Answer::parse(&recording.name, sentences)?;
        answered(Answer { part, ..answer });
        Ok(())
    };
    if args.single && several {
        for k in 0..scans {
            let alone = recording.scan(k);
            boot(elf, &alone, 1, args, |_, sentences| parse(k, sentences))?;
        }
        return Ok(());
    }
    boot(elf, recording, scans, args, parse)
}

/// Boots the image once, and returns its answers to all sweeps of a guard recording.
fn guarded(elf: &Path, recording: &Recording, args: &Args) -> Result<Vec<Guarded>> {
    let name = &recording.name;
    let sweeps = options(args)?.scans_of(recording)?;
    let config = args.settings.config()?;
    let with = (waits(args), args.faults.as_slice());
    let sentences = guarding::sentences(elf, recording, &config, sweeps, with)?;
    let words = Guarded::parse(0, sentences)?.into_iter();
    let named = |word| Guarded {
        recording: name.clone(),
        ..word
    };
    Ok(words.map(named).collect())
}

/// Boots the image once, configures it while the module withholds its handshake, then scans. `answered` is called with
/// index and sentences of each scan.
fn boot(
    elf: &Path,
    recording: &Recording,
    scans: usize,
    args: &Args,
    mut answered: impl FnMut(usize, Vec<String>) -> Result<()>,
) -> Result<()> {
    let name = &recording.name;
    // The emulator's time is not the recording's.
    let playback = Playback::new(recording, &args.settings.config()?)?.by_trigger();
    let booting = busy(&format!("the emulator boots the image for {name}"));
    let mut session = Session::boot(elf, &playback).with_context(|| name.clone())?;
    session
        .configure(&playback.settings(), waits(args))
        .with_context(|| name.clone())?;
    session.module.set_faults(&args.faults);
    let rows = recording.chirps_per_scan() * scans;
    booting.finish_and_clear();
    let bar = progress_after_start(rows as u64);
    let bar = bar.with_prefix(format!(
        "self-test, homing, then rows of {name} in the emulator:"
    ));
    session.module.watch(bar.clone());
    session.skip_lines();
    session.connect()?;
    let mut scan = 0;
    let done = session.scans(scans, |session, sentences| {
        if scan == 0 {
            session.module.set_faults(&[]);
        }
        scan += 1;
        bar.suspend(|| answered(scan - 1, sentences))
    });
    bar.finish_and_clear();
    done.with_context(|| name.clone())
}

/// Returns the timeouts for the radar module that the image is configured with; they depend on the injected faults.
fn waits(args: &Args) -> Waits {
    let mut waits = Waits::default();
    if !args.faults.is_empty() {
        // Missing answers are waited for: a shorter timeout, still enough for a busy host.
        (waits.chirp, waits.configure) = (10_000_000, 5_000_000);
    }
    if args.faults.iter().any(|f| f.kind == InjectedFault::Silent) {
        waits.connect = 20_000_000;
    }
    waits
}

/// Shows the image on the screen of `live` while it scans a recording repeatedly, until the user ends it.
fn watch(elf: &Path, recording: &Recording, args: &Args) -> Result<ExitCode> {
    let playback = Playback::new(recording, &args.settings.config()?)?.by_trigger();
    let pty = Pty::new()?;
    let port = pty.path.clone();
    let about = format!("the image on {}", recording.name);
    let state = State::new(&port, 0).about(about).emulated();
    let keep = live::begin(args.record.as_deref(), &state.port)?;
    let (started, ended) = (Instant::now(), AtomicBool::new(false));
    std::thread::scope(|scope| {
        let emulator = scope.spawn(|| {
            let mut session = Session::boot(elf, &playback)?;
            session.watch(pty);
            session.configure(&playback.settings(), waits(args))?;
            session.module.set_faults(&args.faults);
            session.connect()?;
            session.follow(recording.scans(), &ended)
        });
        let source = Source::port(started, &port, REPORT_BAUD);
        let look = &mut |_: &Answer| ();
        let shown = live::show(started, &source, &mut Watched { state, keep, look });
        ended.store(true, Ordering::Relaxed);
        let emulated = emulator.join();
        shown.and(emulated.unwrap_or_else(|_| Err(anyhow!("the emulator's thread panicked"))))
    })
    .with_context(|| recording.name.clone())?;
    Ok(ExitCode::SUCCESS)
}
