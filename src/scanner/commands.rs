//! Executes commands: lines of the report port, one by one.

use super::guard::GuardMode;
use super::pulse::LiveTimer;
use super::states::{Activity, Machine};
use crate::config::ConfigError;
use crate::port::BytePort;
use crate::report::LiveLine;
use crate::scanner::board::Board;
use crate::scanner::command::{self, Command, LineReader, ParserEvent};
use crate::scanner::parts::Parts;
use crate::scanner::rest::Rest;
use crate::scanner::settings::{self, Settings};
use crate::time::Micros;

/// Maximum number of bytes that one call of `Console::read` takes from the report port, so that a continuous
/// sender cannot block the scanner: more than the port's queue holds.
const MAX_READ: u32 = 1024;

/// Reader of the report port's lines, and progress in listing all settings for `get`.
#[derive(Debug)]
pub(super) struct Console {
    reader: LineReader,
    /// Index in [`Settings::KEYS`] of the next setting that `get` lists; `None` if no listing is under way.
    listing: Option<usize>,
    /// Received line that waits until there is room for its answer; no other line is read until then.
    held: Option<Held>,
    /// Number of lines of the report port since boot that were damaged or no command; saturates.
    refused: u16,
    live_timer: LiveTimer,
}

/// Received line that is still to be executed and answered.
#[derive(Clone, Copy, Debug)]
enum Held {
    /// A complete line.
    Line,
    /// A line that cannot be a command, and the error to report.
    Bad(ConfigError),
}

impl Console {
    /// Creates a console that has received nothing, at the boot time `now`.
    pub fn new(now: Micros) -> Self {
        Self {
            reader: LineReader::default(),
            listing: None,
            held: None,
            refused: 0,
            live_timer: LiveTimer::new(now),
        }
    }

    /// Executes the received motion sentences and at most one other command, and hands queued sentences to the
    /// report port.
    pub(super) fn step<H: Parts>(&mut self, now: Micros, machine: &mut Machine<'_, H>) {
        self.list(machine);
        self.read(now, machine);
        self.send_live(now, machine);
        machine.reports.pump(&mut machine.hardware.port);
    }

    /// Returns how long the next step may wait: bytes of queued sentences and the answer to a line wait for the port.
    pub(super) fn rest<H: Parts>(&self, machine: &Machine<'_, H>) -> Rest {
        let answering = self.listing.is_some() || self.held.is_some();
        if answering && machine.reports.has_room() {
            Rest::None
        } else if machine.reports.all_sent() {
            Rest::Long
        } else {
            Rest::Short
        }
    }

    /// Queues the sentence `LIVE` when it is due and nothing else waits for the port, so that a slow or blocked
    /// port gets no additional load.
    fn send_live<H: Parts>(&mut self, now: Micros, machine: &mut Machine<'_, H>) {
        if let Some(at) = machine.answered.take() {
            self.live_timer.answered(at);
        }
        self.live_timer.count(now);
        if !self.live_timer.due() {
            return;
        }
        // Five times a second is more often than ages need; no other timer runs in every state.
        machine.keep_ages(now);
        if self.queue_live(now, machine) {
            self.live_timer.mark_sent();
        }
    }

    #[inline(never)]
    fn queue_live<H: Parts>(&self, now: Micros, machine: &mut Machine<'_, H>) -> bool {
        let live = LiveLine {
            state: machine.state(),
            scan: machine.scans(),
            uptime_ms: self.live_timer.uptime_ms(),
            age_ms: self.live_timer.age_ms(),
            motion: machine.odometry.state(now).as_str(),
            motion_faults: machine.odometry.faults(),
            refused: self.refused,
            port_errors: machine.hardware.port.errors(),
            link_errors: machine.link_errors,
        };
        machine.reports.live(live)
    }

    /// Reads motion sentences, which have no answer, and at most one other line, which waits until there is
    /// room for its answer.
    fn read<H: Parts>(&mut self, now: Micros, machine: &mut Machine<'_, H>) {
        for _ in 0..MAX_READ {
            if self.held.is_some() {
                break;
            }
            let Some(byte) = machine.hardware.port.read() else {
                return;
            };
            self.held = match self.reader.push(byte) {
                ParserEvent::Partial => None,
                ParserEvent::Line if command::is_motion(self.reader.line()) => {
                    self.drive(now, machine);
                    None
                }
                ParserEvent::Line => Some(Held::Line),
                ParserEvent::Bad(error) => Some(Held::Bad(error)),
            };
        }
        if self.listing.is_some() || !machine.reports.has_room() {
            return;
        }
        match self.held.take() {
            Some(Held::Line) => self.execute(now, machine),
            Some(Held::Bad(error)) => {
                self.refused = self.refused.saturating_add(1);
                machine.reports.refuse("-", error.field, error.expected);
            }
            None => {}
        }
    }

    /// Handles a motion sentence. A damaged one is counted, and reported by `status` and with the scan.
    #[inline(never)]
    fn drive<H: Parts>(&mut self, now: Micros, machine: &mut Machine<'_, H>) {
        match command::parse(self.reader.line()) {
            Ok(Command::Motion(reading)) => machine.odometry.take(now, reading),
            _ => machine.odometry.garbled(),
        }
    }

    // Out of line because of the stack, as in `states`.
    #[inline(never)]
    fn execute<H: Parts>(&mut self, now: Micros, machine: &mut Machine<'_, H>) {
        let parsed = match command::parse(self.reader.line()) {
            Ok(command) => command,
            Err(bad) => {
                let error = bad.error;
                self.refused = self.refused.saturating_add(1);
                return machine
                    .reports
                    .refuse(bad.command, error.field, error.expected);
            }
        };
        match parsed {
            Command::Start => machine.start(now),
            Command::Stop => machine.stop(),
            Command::Scan => machine.errand(now, "scan", Activity::Once),
            Command::Guard(on) => machine.guard(now, on, GuardMode::Guard),
            Command::Watch(on) => machine.guard(now, on, GuardMode::Watch),
            Command::SelfTest => machine.errand(now, "selftest", Activity::Answer),
            Command::Status => {
                let status = machine.status(now);
                machine.reports.status(&status);
            }
            Command::Reset => {
                machine.discard_evidence();
                machine.reports.done("reset");
            }
            Command::Crash => {
                let last = machine.hardware.board.last_crash();
                machine.reports.crash(last);
            }
            Command::ForgetCrash => {
                machine.hardware.board.forget_crash();
                machine.reports.done("crash-clear");
            }
            Command::Version => machine.reports.version(&machine.identity),
            Command::GetAll => self.listing = Some(0),
            Command::Get(key) => tell_setting(machine, key),
            Command::Set(key, value) => {
                let mut settings = *machine.settings.get();
                let framed = command::is_framed(self.reader.line());
                let valid = settings.set(key, value);
                if valid.is_ok() && !framed {
                    return machine.reports.offer("set", &["set", key, value]);
                }
                match valid.and_then(|()| machine.change(key, &settings)) {
                    Ok(()) => tell_setting(machine, key),
                    Err(error) => machine.reports.refuse("set", error.field, error.expected),
                }
            }
            Command::Save if command::is_framed(self.reader.line()) => save(machine),
            Command::Save => machine.reports.offer("save", &["save"]),
            Command::Update if command::is_framed(self.reader.line()) => update(machine),
            Command::Update => machine.reports.offer("update", &["update"]),
            Command::Calibrate(task) if command::is_framed(self.reader.line()) => {
                machine.calibrate(now, task);
            }
            Command::Calibrate(task) => {
                let [wall, date] = [task.wall_mm.into(), task.date].map(i64::from);
                let [wall, date] = [wall, date].map(settings::number);
                machine
                    .reports
                    .offer("calibrate", &["calibrate", &wall, &date]);
            }
            // Handled before: `drive`.
            Command::Motion(_) => {}
            Command::Measure(measure) => {
                let word = machine.hardware.board.measure(measure);
                machine.reports.value(measure.key(), &measure.text(word));
            }
        }
    }

    /// Queues the sentence of the next setting if `get` is listing all of them, and `DONE` after the last.
    #[inline(never)]
    fn list<H: Parts>(&mut self, machine: &mut Machine<'_, H>) {
        let Some(next) = self.listing else { return };
        if !machine.reports.has_room() {
            return;
        }
        self.listing = match Settings::KEYS.get(next) {
            Some(key) => {
                tell_setting(machine, key);
                Some(next + 1)
            }
            None => {
                machine.reports.done("get");
                None
            }
        };
    }
}

/// Executes `save`: writes the settings to flash. Refused unless the scanner is idle or in a fault, since nothing
/// runs while flash is erased, and until every setting of the mounting has been set.
#[inline(never)]
fn save<H: Parts>(machine: &mut Machine<'_, H>) {
    let refused = if !machine.stands() {
        Some(("state", "idle: stop first"))
    } else if let Err(error) = machine.settings.fit_to_save() {
        Some((error.field, error.expected))
    } else {
        let saved = machine.hardware.board.save(machine.settings.get());
        saved.err().map(|error| ("flash", error.expected()))
    };
    match refused {
        Some((field, expected)) => machine.reports.refuse("save", field, expected),
        None => machine.reports.done("save"),
    }
}

/// Executes `update`: resets the chip into its boot loader if nothing moves; refused if there is no boot loader.
#[inline(never)]
fn update<H: Parts>(machine: &mut Machine<'_, H>) {
    let (field, expected) = if machine.stands() {
        machine.hardware.board.enter_loader();
        ("loader", "a chip with a boot loader")
    } else {
        ("state", "idle: stop first")
    };
    machine.reports.refuse("update", field, expected);
}

fn tell_setting<H: Parts>(machine: &mut Machine<'_, H>, key: &str) {
    let value = machine.settings.get().get(key).unwrap_or_default();
    machine.reports.value(key, &value);
}
