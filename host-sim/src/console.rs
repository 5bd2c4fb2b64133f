//! Output to stdout; notes, errors and progress bars on stderr.

use std::io::{IsTerminal as _, Write as _};
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Result;
use clap::ValueEnum;
use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};

/// How results are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Text
    #[default]
    Text,
    /// JSON; nothing else goes to stdout
    Json,
}

/// Writes a line to stderr, formatted as by `format!`. A closed stderr (`2>&1 | head -1`) ends no work: `eprintln!` would
/// panic.
#[macro_export]
macro_rules! note {
    ($($text:tt)*) => {
        $crate::console::aside(format_args!($($text)*))
    };
}

/// Writes a line to stderr, or nowhere if that is closed; what [`note!`] calls.
pub fn aside(line: std::fmt::Arguments<'_>) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// Writes to stdout. If the reader closes the pipe (`| head`) the program ends without an error message.
pub fn emit(text: &str) {
    let mut out = std::io::stdout().lock();
    if let Err(error) = out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        let broken_pipe = error.kind() == std::io::ErrorKind::BrokenPipe;
        if !broken_pipe {
            crate::note!("error: stdout: {error}");
        }
        std::process::exit(if broken_pipe { 0 } else { 1 });
    }
}

/// Returns the exit status of a command, after its error message on stderr.
pub fn exit(done: Result<ExitCode>) -> ExitCode {
    done.unwrap_or_else(|error| {
        crate::note!("error: {error:#}");
        ExitCode::FAILURE
    })
}

/// Update interval of the time on a progress bar.
const TICK: Duration = Duration::from_millis(200);

/// Returns a progress bar with elapsed and remaining time, on stderr if that is a terminal; otherwise a hidden one.
pub fn progress(length: u64) -> ProgressBar {
    timed(
        ProgressBar::new(length),
        "{prefix} {bar:40} {pos}/{len}, {elapsed} gone, {left} to go",
    )
}

/// Returns [`progress`] for commands that print results one by one. It is hidden if stdout is a terminal, where the
/// results show the progress.
pub fn progress_aside(length: u64) -> ProgressBar {
    if std::io::stdout().is_terminal() {
        return ProgressBar::hidden();
    }
    progress(length)
}

/// Returns a spinner with a text and the elapsed time, for work of unknown length.
pub fn busy(what: &str) -> ProgressBar {
    timed(
        ProgressBar::new_spinner(),
        "{spinner} {msg}: {elapsed} gone",
    )
    .with_message(what.to_owned())
}

fn timed(bar: ProgressBar, style: &str) -> ProgressBar {
    // Without a finished item the remaining time is unknown.
    let left = |state: &ProgressState, text: &mut dyn std::fmt::Write| {
        let _ = match state.pos() {
            0 => write!(text, "?"),
            _ => write!(text, "{:#}", HumanDuration(state.eta())),
        };
    };
    let style = ProgressStyle::with_template(style);
    let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.set_style(style.with_key("left", left));
    // The time advances also during a long item. Hidden bars need no thread.
    if !bar.is_hidden() {
        bar.enable_steady_tick(TICK);
    }
    bar
}
