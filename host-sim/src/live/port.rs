//! The thread that reads and writes a port, and reopens it after it has disappeared.
//!
//! DTR and RTS are not changed from the system's setting: an adapter may have a reset wired to one of them.

use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use serialport::SerialPort;

use super::Ms;
use super::lines::Splitter;
use super::log::Log;
use super::model::{Event, Way};
use super::ports;
use super::trouble::Trouble;

/// Timeout of a read: the maximum delay of a typed line.
const READ: Duration = Duration::from_millis(20);
/// Interval between two attempts to open a port.
const RETRY: Duration = Duration::from_millis(300);
/// Time after which the end of a line that has begun is overdue; a sentence takes 20 ms at 115,200 baud.
const OVERDUE: Duration = Duration::from_millis(500);
/// Timeout of a write. A command of one line takes 8 ms at 115,200 baud.
const WRITE: Duration = Duration::from_secs(1);

/// Source of a port's events and sink of lines to send: a serial port, or a simulated scanner.
#[derive(Debug)]
pub struct Source {
    /// Events of the port with their times, ms since the session began.
    pub events: Receiver<(Ms, Event)>,
    /// Lines to send to the scanner, without line ends.
    pub lines: Sender<String>,
    /// Whether the source is a log, which ends.
    pub is_log: bool,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// End of a [`Source`] that the thread of its port uses.
#[derive(Debug)]
pub struct Inside {
    started: Instant,
    events: Sender<(Ms, Event)>,
    lines: Receiver<String>,
    stop: Arc<AtomicBool>,
}

impl Inside {
    /// Sends an event with the current time.
    pub fn send(&self, event: Event) {
        let at = self.started.elapsed().as_millis() as Ms;
        // Without a receiver [`Self::ended`] is true.
        let _ = self.events.send((at, event));
    }

    /// Returns the next line to send to the scanner; `None` if there is none at present.
    pub fn line(&self) -> Option<String> {
        self.lines.try_recv().ok()
    }

    /// Whether the [`Source`] was dropped, so that the thread must end.
    pub fn ended(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

impl Source {
    /// Runs `work` in a thread until the source is dropped. Times count from `started`.
    pub fn run(started: Instant, work: impl FnOnce(Inside) + Send + 'static) -> Self {
        let (to_screen, events) = mpsc::channel();
        let (lines, from_screen) = mpsc::channel();
        let stop = Arc::new(AtomicBool::new(false));
        let inside = Inside {
            started,
            events: to_screen,
            lines: from_screen,
            stop: stop.clone(),
        };
        Self {
            events,
            lines,
            is_log: false,
            stop,
            thread: Some(std::thread::spawn(move || work(inside))),
        }
    }

    /// Creates the source that plays a log at its true speed.
    pub fn log(started: Instant, log: Log) -> Self {
        let play = move |inside: Inside| {
            inside.send(Event::Opened);
            let received = log.lines.into_iter().filter(|line| line.way == Way::In);
            for line in received {
                let due = started + Duration::from_millis(line.at);
                while Instant::now() < due {
                    if inside.ended() {
                        return;
                    }
                    std::thread::sleep(READ.min(due.saturating_duration_since(Instant::now())));
                }
                inside.send(Event::Line(line.text));
            }
        };
        let mut source = Self::run(started, play);
        source.is_log = true;
        source
    }

    /// Creates the source for the serial port `path`, which is reopened after each failure.
    pub fn port(started: Instant, path: &str, baud: u32) -> Self {
        let path = path.to_owned();
        Self::run(started, move |inside| keep_open(&inside, &path, baud))
    }
}

impl Drop for Source {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn keep_open(inside: &Inside, path: &str, baud: u32) {
    while !inside.ended() {
        match open(path, baud) {
            Ok(mut port) => {
                inside.send(Event::Opened);
                if let Some(why) = talk(inside, path, &mut *port) {
                    inside.send(Event::Failed(Trouble::Unplugged(why)));
                }
            }
            Err(error) => inside.send(Event::Failed(ports::trouble(path, &error))),
        }
        // Lines for a scanner that is absent must not go to the next one.
        while inside.line().is_some() {}
        std::thread::sleep(RETRY);
    }
}

/// Opens a port exclusively. DTR and RTS are not changed.
///
/// # Errors
/// The library's error; [`ports::trouble`] explains it.
pub fn open(path: &str, baud: u32) -> serialport::Result<Box<dyn SerialPort>> {
    serialport::new(path, baud)
        .timeout(READ)
        .preserve_dtr_on_open()
        .open()
}

/// Reads and writes an open port until the session ends (`None`) or the port disappears (the cause).
fn talk(inside: &Inside, path: &str, port: &mut dyn SerialPort) -> Option<String> {
    let mut splitter = Splitter::default();
    let mut buffer = [0; 1024];
    // Time of the last bytes, if a line has begun and its end may be overdue.
    let mut begun: Option<Instant> = None;
    while !inside.ended() {
        while let Some(line) = inside.line() {
            if let Err(error) = write(port, format!("{line}\r\n").as_bytes()) {
                return Some(error.to_string());
            }
        }
        match port.read(&mut buffer) {
            Ok(0) => return Some("its end was reached".to_owned()),
            Ok(count) => {
                let lines = splitter.push(&buffer[..count]);
                lines
                    .into_iter()
                    .for_each(|line| inside.send(Event::Line(line)));
                begun = Some(Instant::now());
            }
            Err(error) if passes(error.kind()) => {
                // Not every driver reports to a reader that its device was unplugged.
                if !Path::new(path).exists() {
                    return Some("no such device any more".to_owned());
                }
                if begun.take_if(|begun| begun.elapsed() > OVERDUE).is_some()
                    && let Some(text) = splitter.pending()
                {
                    inside.send(Event::Pending(text));
                }
            }
            Err(error) => return Some(error.to_string()),
        }
    }
    None
}

/// Whether a read or write error of this kind is no fault of the port: a timeout, no data available, or an
/// interruption.
pub fn passes(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
    )
}

fn write(port: &mut dyn SerialPort, mut bytes: &[u8]) -> std::io::Result<()> {
    let begun = Instant::now();
    while !bytes.is_empty() {
        match port.write(bytes) {
            Ok(count) => bytes = &bytes[count..],
            Err(error) if passes(error.kind()) && begun.elapsed() < WRITE => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}
