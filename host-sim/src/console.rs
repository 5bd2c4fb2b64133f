//! Output to stdout; notes, errors and progress bars on stderr.

use std::io::{IsTerminal as _, Write as _};
use std::process::ExitCode;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use anyhow::Result;
use clap::ValueEnum;
use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle, WeakProgressBar};

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
/// Interval of progress lines where stderr is no terminal.
const LINES: Duration = Duration::from_secs(10);

/// From when the speed of the work counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Since {
    /// The bar's creation.
    Start,
    /// The first finished item, before which something else was waited for.
    FirstItem,
}

/// Returns a progress bar with elapsed and remaining time on stderr; if that is no terminal, a line every ten seconds.
pub fn progress(length: u64) -> ProgressBar {
    timed(ProgressBar::new(length), Some(Pace::new(Since::Start)))
}

/// Returns [`progress`] for items that begin only after a preparation, such as the boot of an emulated image: the
/// remaining time is that of the items.
pub fn progress_after_start(length: u64) -> ProgressBar {
    timed(ProgressBar::new(length), Some(Pace::new(Since::FirstItem)))
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
    let style = ProgressStyle::with_template("{spinner} {msg}: {elapsed} gone");
    let style = style.unwrap_or_else(|_| ProgressStyle::default_spinner());
    let bar = ProgressBar::new_spinner().with_style(style);
    timed(bar.with_message(what.to_owned()), None)
}

/// Speed of the work, for the time that is left.
#[derive(Clone, Copy, Debug)]
struct Pace {
    since: Since,
    /// Time and number of finished items from which the speed counts.
    first: Option<(Instant, u64)>,
}

impl Pace {
    /// Fewest items after the first by which the remaining time is estimated.
    const FEWEST: u64 = 3;

    fn new(since: Since) -> Self {
        let first = (since == Since::Start).then(|| (Instant::now(), 0));
        Self { since, first }
    }

    /// Returns the remaining time at `now`, when `done` items of `all` are finished; `None` while it is unknown.
    fn left(&mut self, now: Instant, done: u64, all: u64) -> Option<Duration> {
        if done == 0 {
            return None;
        }
        let (begun, at) = *self.first.get_or_insert((now, done));
        let counted = done.saturating_sub(at);
        let fewest = match self.since {
            Since::Start => 1,
            Since::FirstItem => Self::FEWEST,
        };
        let each = now.duration_since(begun).as_secs_f64() / counted as f64;
        (counted >= fewest).then(|| Duration::from_secs_f64(each * all.saturating_sub(done) as f64))
    }

    /// Returns [`Self::left`] as text.
    fn text(&mut self, now: Instant, done: u64, all: u64) -> String {
        let left = self.left(now, done, all);
        left.map_or("?".to_owned(), |left| format!("{:#}", HumanDuration(left)))
    }
}

fn timed(bar: ProgressBar, pace: Option<Pace>) -> ProgressBar {
    // Hidden where stderr is no terminal.
    if bar.is_hidden() {
        let weak = bar.downgrade();
        std::thread::spawn(move || in_lines(&weak, pace, LINES, |line| crate::note!("{line}")));
        return bar;
    }
    if let Some(pace) = pace {
        let pace = Arc::new(Mutex::new(pace));
        let left = move |state: &ProgressState, text: &mut dyn std::fmt::Write| {
            let all = state.len().unwrap_or_default();
            if let Ok(mut pace) = pace.lock() {
                let _ = text.write_str(&pace.text(Instant::now(), state.pos(), all));
            }
        };
        let style = "{prefix} {bar:40} {pos}/{len}, {elapsed} gone, {left} to go";
        let style = ProgressStyle::with_template(style);
        let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
        bar.set_style(style.with_key("left", left));
    }
    // The time advances also during a long item.
    bar.enable_steady_tick(TICK);
    bar
}

/// Passes a line with the bar's state to `show` at every interval, until the bar is finished or dropped.
fn in_lines(
    bar: &WeakProgressBar,
    mut pace: Option<Pace>,
    every: Duration,
    mut show: impl FnMut(String),
) {
    // The first finished item is to be noticed in time.
    const STEPS: u32 = 20;
    for step in 1.. {
        std::thread::sleep(every / STEPS);
        let Some(bar) = bar.upgrade().filter(|bar| !bar.is_finished()) else {
            return;
        };
        let (done, all) = (bar.position(), bar.length().unwrap_or_default());
        let left = pace
            .as_mut()
            .map(|pace| pace.text(Instant::now(), done, all));
        if step % STEPS > 0 {
            continue;
        }
        let gone = HumanDuration(bar.elapsed());
        let line = match left {
            Some(left) => format!("{} {done}/{all}, {gone:#} gone, {left} to go", bar.prefix()),
            None => format!("{}: {gone:#} gone", bar.message()),
        };
        show(line.trim_start().to_owned());
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;

    #[test]
    fn without_a_terminal_lines_tell_the_progress_until_the_end() {
        let bar = ProgressBar::hidden();
        bar.set_length(8);
        let bar = bar.with_prefix("rows");
        bar.inc(2);
        let (sender, lines) = mpsc::channel();
        let (weak, pace) = (bar.downgrade(), Pace::new(Since::Start));
        let every = Duration::from_millis(40);
        let thread = std::thread::spawn(move || {
            in_lines(&weak, Some(pace), every, |line| sender.send(line).unwrap());
        });
        let line = lines.recv().unwrap();
        assert!(
            line.starts_with("rows 2/8, ") && line.ends_with("s to go"),
            "{line}"
        );
        bar.inc(1);
        lines.recv().unwrap();
        assert!(lines.recv().unwrap().starts_with("rows 3/8, "));
        bar.finish_and_clear();
        thread.join().unwrap();
    }

    #[test]
    fn remaining_time_counts_no_preparation() {
        let (begun, second) = (Instant::now(), Duration::from_secs(1));
        let mut pace = Pace::new(Since::FirstItem);
        // A boot of 100 s, then a row a second.
        let at = |s| begun + s * second;
        assert_eq!(pace.left(at(100), 0, 281), None);
        for done in 1..=3 {
            assert_eq!(pace.left(at(100 + done), done.into(), 281), None);
        }
        assert_eq!(pace.left(at(104), 4, 281), Some(277 * second));
        let mut pace = Pace::new(Since::Start);
        let left = pace.left(Instant::now() + 10 * second, 1, 3).unwrap();
        assert_eq!(left.as_secs(), 20);
    }
}
