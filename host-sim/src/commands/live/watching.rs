//! Observes a scanner, on a screen or without: arguments, source and session of `live`.

use std::io::{IsTerminal as _, stdout};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use anyhow::{Result, ensure};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use crate::answer::Answer;
use crate::commands::{Settings, emit, logs};
use crate::live::keep::Keep;
use crate::live::model::State;
use crate::live::port::Source;
use crate::live::session::Session;
use crate::live::trouble::REPORT_BAUD;
use crate::live::{device, plain, terminal};
use crate::playback::Playback;
use crate::recording::Recording;
use crate::serve::address;

/// Arguments of `live`.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Commands are entered in the last lines of the screen: status, scan, guard on, get KEY ...; `?` lists all. `set`,
`save`, `calibrate` and `update` are accepted only as a sentence with a CRC: the sentence is shown, and the next Enter sends it.
DTR and RTS are never changed, so that nothing is reset."
)]
pub struct Args {
    /// The report port, such as /dev/ttyUSB0; without it the ports of this machine are listed
    #[arg(group = "source")]
    pub port: Option<String>,
    /// Run a scanner on this machine that scans this recording, and show it
    #[arg(long, value_name = "REC", group = "source")]
    pub demo: Option<PathBuf>,
    /// Play this log of sentences at its true speed; or a recording to Foxglove or ROS 2, repeatedly, with echoes, map and
    /// (Foxglove) chirps
    #[arg(
        long,
        value_name = "LOG|REC",
        group = "source",
        conflicts_with = "record"
    )]
    pub play: Option<PathBuf>,
    /// Serve the answers to Foxglove, at port 8765 of this machine or at this address; needs no terminal
    #[arg(long, value_name = "[ADDRESS:]PORT", num_args = 0..=1, default_missing_value = address::DEFAULT,
        value_parser = address::parse, requires = "source", group = "service")]
    pub foxglove: Option<SocketAddr>,
    /// Publish the answers as a ROS 2 node, on this machine only or on the interface with this address (0.0.0.0: all);
    /// needs no terminal
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = address::HERE,
        value_parser = address::interface, requires = "source", group = "service")]
    pub ros2: Option<Ipv4Addr>,
    /// ROS 2 domain, 0 to 232; without it ROS_DOMAIN_ID, else 0
    #[arg(long, value_name = "ID", value_parser = address::parse_domain, requires = "ros2")]
    pub domain: Option<u16>,
    /// Write every sentence with its time to a new file in this directory
    #[arg(long, value_name = "DIR")]
    pub record: Option<PathBuf>,
    /// Baud rate of the port; the scanner uses 115200
    #[arg(long, default_value_t = REPORT_BAUD, value_parser = clap::value_parser!(u32).range(50..=4_000_000))]
    pub baud: u32,
    /// Estimator and seed of the demonstration or of the played recording
    #[command(flatten)]
    pub settings: Settings,
}

/// Checks that the recording or log of the source can be read and scanned, and that the session can be recorded.
///
/// # Errors
/// Names the file, and what is wrong.
pub fn check(args: &Args) -> Result<()> {
    let config = args.settings.config()?;
    let scanned = |path: &Path| {
        let recording = Recording::read(path)?;
        Playback::new(&recording, &config).map(|_| ())
    };
    match &args.play {
        Some(path) if logs::is_recording(path) => scanned(path)?,
        Some(path) if logs::read(path)?.is_none() => {
            logs::other(path, "a log of sentences or a recording")?;
        }
        _ => {}
    }
    args.demo.as_deref().map_or(Ok(()), scanned)?;
    args.record.as_deref().map_or(Ok(()), Keep::check)
}

/// Returns the port or the demonstration, with the screen's initial state; `None` if neither is given.
pub fn source(args: &Args, started: Instant) -> Result<Option<(Source, State)>> {
    if let Some(path) = &args.play {
        ensure!(
            !logs::is_recording(path),
            "{}: --play of a recording: expected --foxglove or --ros2; --demo shows it here",
            path.display()
        );
        let log = logs::expect(path)?;
        let state = State::new(&log.name, 0).about("a log, at its true speed".to_owned());
        return Ok(Some((Source::log(started, log), state)));
    }
    Ok(Some(match (&args.port, &args.demo) {
        (Some(port), _) => (
            Source::port(started, port, args.baud),
            State::new(port, args.baud),
        ),
        (None, Some(path)) => {
            let recording = Recording::read(path)?;
            let config = args.settings.config()?;
            // A recording that cannot be scanned is reported before the screen is drawn.
            Playback::new(&recording, &config)?;
            let about = format!("a scanner on this machine scans {}", recording.name);
            let source = Source::run(started, move |inside| {
                let _ = device::run(&recording, &config, &mut device::Direct::new(inside));
            });
            (source, State::new("demo", 0).about(about))
        }
        (None, None) => return Ok(None),
    }))
}

/// Shows a source on a screen or, without a terminal, as one line for each answer. `look` is called with each answer.
pub fn watch(
    args: &Args,
    (started, source, state): (Instant, &Source, State),
    look: &mut dyn FnMut(&Answer),
) -> Result<ExitCode> {
    let keep = begin(args.record.as_deref(), &state.port)?;
    let kept = keep.as_ref().map(|keep| keep.path.clone());
    let session = &mut Session { state, keep, look };
    show(started, source, session)?;
    if let Some(path) = kept.filter(|_| session.keep.as_ref().is_some_and(|keep| keep.used)) {
        emit(&format!("recorded in {}\n", path.display()));
    }
    Ok(ExitCode::SUCCESS)
}

/// Shows a session on a screen or, without a terminal, as lines, until the user or a signal ends it.
pub fn show(started: Instant, source: &Source, session: &mut Session<'_>) -> Result<()> {
    if stdout().is_terminal() {
        return terminal::run(started, source, session);
    }
    let print = &mut |line: &str| emit(&format!("{line}\n"));
    plain::run(started, source, session, &*interrupted()?, print)
}

/// Returns a flag that Ctrl-C, SIGTERM and SIGHUP set; the second signal ends the program at once.
pub fn interrupted() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    // `nohup` ignores it.
    let hangup = (!ignored(SIGHUP)).then_some(SIGHUP);
    for signal in [SIGINT, SIGTERM].into_iter().chain(hangup) {
        signal_hook::flag::register_conditional_shutdown(signal, 128 + signal, stop.clone())?;
        signal_hook::flag::register(signal, stop.clone())?;
    }
    Ok(stop)
}

/// Whether this process ignores a signal, as Linux tells it.
fn ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask & (1 << (signal - 1)) != 0)
}

/// Creates the file that records a session in `dir`, if requested.
pub fn begin(dir: Option<&Path>, port: &str) -> Result<Option<Keep>> {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    let about = format!(
        "live of {port}, begun {} s after 1970-01-01 UTC; ms since then, < came, > was sent",
        since.unwrap_or_default().as_secs()
    );
    dir.map(|dir| Keep::begin(dir, &about)).transpose()
}
