//! A simulated scanner in real time: the scanner's own loop over a recording, with a port that accepts commands.
//!
//! Its answers are those of `replay` (of `replay --by-trigger` if the recording contains the chair's motion). A
//! recording of one scan is repeated. After the last scan of a sequence the scanner restarts. Guard sweeps begin at the
//! times of their recording.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant};

use anyhow::Result;
use stairscan::config::Config;
use stairscan::motion::Odometry;
use stairscan::pipeline::Pipeline;
use stairscan::scanner::{BytePort, Hardware, LentParts, Micros, Reports, Scanner};

use super::lines::Splitter;
use super::model::Event;
use super::port::Inside;
use super::sweep_times::{PacedLink, SweepTimes};
use crate::motion::Timetable;
use crate::motion::inlet::Inlet;
use crate::playback::{Playback, PlaybackLink, SimShaft};
use crate::recording::Recording;
use crate::setup::{self, Kind};
use crate::volatile::{Volatile, identity};

/// Time between two steps of the simulated scanner's loop. About four steps a row: a scan takes about as long as on
/// the chip.
const STEP: Duration = Duration::from_millis(1);
/// Same, while the guard sweeps: a sweep of 31 rows takes less time than the 100 ms from one to the next at its highest
/// rate.
const GUARD_STEP: Duration = Duration::from_micros(200);
/// Time for which the simulated shaft settles at a row of a guard sweep, µs: the shortest. It does not move.
const GUARD_SETTLE_US: u32 = 100;

/// Far end of a simulated scanner's report port: sends commands to the scanner and receives its sentences.
pub trait Cable {
    /// Returns the bytes of the command lines that have arrived for the scanner since the last call; whole lines only.
    fn read(&mut self) -> Vec<u8>;
    /// Takes bytes of the scanner's sentences. Does not wait for a reader, like a UART.
    fn write(&mut self, bytes: &[u8]);
    /// Whether the far end is closed, so that the scanner is no longer needed.
    fn ended(&self) -> bool;
}

/// Runs a simulated scanner on `recording`, again from its boot after the last scan, until the cable has ended.
///
/// # Errors
/// The recording cannot be scanned; the message names the cause.
pub fn run(recording: &Recording, base: &Config, cable: &mut dyn Cable) -> Result<()> {
    let mut playback = Playback::new(recording, base)?.by_trigger();
    if setup::kind(recording)? == Kind::Guard {
        playback = playback.guarding();
    }
    while !cable.ended() {
        boot(recording, &playback, cable);
    }
    Ok(())
}

/// Runs the scanner from its boot until the cable ends it or all scans of the recording are answered.
fn boot(recording: &Recording, playback: &Playback<'_>, cable: &mut dyn Cable) {
    let table = playback.motion().map(Timetable::by_trigger);
    let table = table.map(|table| Rc::new(RefCell::new(table)));
    let (mut reports, mut odometry) = (Reports::new(), Odometry::new());
    let mut pipeline = Box::new(Pipeline::new());
    let guard = playback.kind() == Kind::Guard;
    let mut settings = playback.settings();
    if guard {
        settings.timing.settle = GUARD_SETTLE_US;
    }
    let hardware = Hardware {
        mirror: SimShaft::default(),
        link: PacedLink::new(
            PlaybackLink::new(playback, table.clone()),
            guard.then(|| SweepTimes::new(recording)),
        ),
        port: Wire {
            inlet: Inlet::new(table),
            out: Vec::new(),
        },
        board: Volatile::SCANNING,
    };
    let started = Instant::now();
    let mut scanner = Scanner::new(
        hardware,
        &mut *pipeline,
        LentParts {
            reports: &mut reports,
            odometry: &mut odometry,
        },
        Some(settings),
        identity("host"),
        Micros(0),
    );
    if guard {
        scanner.port_mut().inlet.type_in(b"guard on\n");
    }
    let mut commanded = 0;
    while !cable.ended() {
        let typed = cable.read();
        scanner.port_mut().inlet.type_in(&typed);
        scanner.step(Micros(started.elapsed().as_micros() as u32));
        let begun = if guard {
            scanner.sweeps()
        } else {
            scanner.scans()
        };
        let scans = begun as usize;
        if scans > commanded {
            let commands = playback.commands_after(commanded);
            scanner.port_mut().inlet.set(&commands);
            commanded += 1;
        }
        cable.write(&std::mem::take(&mut scanner.port_mut().out));
        if recording.scans() > 1 && scans > recording.scans() {
            return;
        }
        std::thread::sleep(if guard { GUARD_STEP } else { STEP });
    }
}

/// Report port of the simulated scanner, at its end of the cable.
struct Wire {
    inlet: Inlet,
    out: Vec<u8>,
}

impl BytePort for Wire {
    fn read(&mut self) -> Option<u8> {
        self.inlet.read()
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        self.out.extend(bytes);
        bytes.len()
    }
}

/// The cable of `--demo`: connects the scanner directly to the screen.
pub struct Direct {
    inside: Inside,
    splitter: Splitter,
}

impl Direct {
    /// Creates a cable to the screen at the other end of `inside`.
    pub fn new(inside: Inside) -> Self {
        inside.send(Event::Opened);
        let splitter = Splitter::default();
        Self { inside, splitter }
    }
}

impl Cable for Direct {
    fn read(&mut self) -> Vec<u8> {
        let line = self.inside.line().map(|line| format!("{line}\r\n"));
        line.unwrap_or_default().into_bytes()
    }

    fn write(&mut self, bytes: &[u8]) {
        for line in self.splitter.push(bytes) {
            self.inside.send(Event::Line(line));
        }
    }

    fn ended(&self) -> bool {
        self.inside.ended()
    }
}
