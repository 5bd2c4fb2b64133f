//! `live PORT`: the scanner as it reports, in a terminal.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use anyhow::{Result, bail};

use super::{Settings, emit};
use crate::live::keep::Keep;
use crate::live::model::State;
use crate::live::port::Source;
use crate::live::trouble::REPORT_BAUD;
use crate::live::{device, ports, terminal};
use crate::playback::Playback;
use crate::recording::Recording;

/// Arguments of `live`.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Commands are typed on the screen's last lines: status, scan, stop, start, get KEY ... `set`, `save` and
`calibrate` count only inside a sentence with a CRC: the sentence is offered, and the next Enter sends it.
DTR and RTS are never touched: nothing is reset."
)]
pub struct Args {
    /// The report port, such as /dev/ttyUSB0; without it the ports of this machine are listed
    #[arg(conflicts_with = "demo")]
    port: Option<String>,
    /// Show a scanner on this machine that scans this recording
    #[arg(long, value_name = "REC")]
    demo: Option<PathBuf>,
    /// Keep every sentence with its time in a new file of this directory
    #[arg(long, value_name = "DIR")]
    record: Option<PathBuf>,
    /// Speed of the port; the scanner's is 115200
    #[arg(long, default_value_t = REPORT_BAUD, value_parser = clap::value_parser!(u32).range(50..=4_000_000))]
    baud: u32,
    #[command(flatten)]
    settings: Settings,
}

/// Shows the port, or the demonstration, or lists the ports.
pub fn run(args: &Args) -> Result<ExitCode> {
    let started = Instant::now();
    let (source, state) = match (&args.port, &args.demo) {
        (Some(port), _) => (
            Source::port(started, port, args.baud),
            State::new(port, args.baud),
        ),
        (None, Some(path)) => {
            let recording = Recording::read(path)?;
            let config = args.settings.config()?;
            // What no scan can be made of is told before the screen is.
            Playback::new(&recording, &config)?;
            let about = format!("a scanner on this machine scans {}", recording.name);
            let source = Source::run(started, move |inside| {
                let _ = device::run(&recording, &config, &mut device::Direct::new(inside));
            });
            (source, State::new("demo", 0).about(about))
        }
        (None, None) => return list(),
    };
    let keep = begin(args.record.as_deref(), &state.port)?;
    let kept = keep.as_ref().map(|keep| keep.path.clone());
    terminal::run(started, &source, state, keep)?;
    if let Some(path) = kept {
        emit(&format!("recorded in {}\n", path.display()));
    }
    Ok(ExitCode::SUCCESS)
}

/// The file of a session, if one is wanted.
pub fn begin(dir: Option<&std::path::Path>, port: &str) -> Result<Option<Keep>> {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    let about = format!(
        "live of {port}, begun {} s after 1970-01-01 UTC; ms since then, < came, > was sent",
        since.unwrap_or_default().as_secs()
    );
    dir.map(|dir| Keep::begin(dir, &about)).transpose()
}

fn list() -> Result<ExitCode> {
    let ports = ports::list();
    if ports.is_empty() {
        bail!(
            "no serial port here. Is the adapter plugged in? `dmesg | tail` shows whether the system has seen \
             it. Without hardware: `cargo sim live --demo recordings/stair_a`"
        );
    }
    emit(&format!(
        "serial ports:\n{ports}choose one: cargo sim live PORT\n"
    ));
    Ok(ExitCode::SUCCESS)
}
