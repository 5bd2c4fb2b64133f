//! The scanner: boot, self-test, idle, scanning, reporting, fault; commands at any time.
//!
//! ```text
//!            ┌────────── stopped ──────────┐
//!   boot ────┤                             ▼
//!            └─► self-test ──passed──► (go on?) ──no──► idle ◄──stop── any state
//!                  ▲   │failed            │yes            │ start, scan, selftest
//!                  │   ▼                  ▼               ▼
//!       hold over  └─ fault ◄─fault── scanning      scanning, or self-test
//!                       ▲                 │          if home or link is unknown
//!                       └──fault── reporting ──► (go on?)
//! ```
//!
//! A fault leaves the motor's driver off. After `fault-hold` the self-test homes the mirror and
//! asks the module again; nothing has to be reset by hand.

use core::task::Poll;

use super::chain::DataPath;
use super::link::{BytePort, RadarLink};
use super::mirror::{Mirror, Motion};
use super::outbox::Outbox;
use super::schedule::MICROSTEPS_PER_TURN;
use super::settings::{Settings, Sweeping};
use super::sweep::{Rows, Sweep, link_reason, mirror_reason};
use super::time::Micros;
use crate::answer::{Outcome, Reason, Reasons, Status};
use crate::config::RadarConfig;
use crate::report::command::{self, Command, Input, LineReader, Measure};
use crate::report::{ScanLine, Sentence, StepLine};

/// What the first sentence after boot says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Version of the firmware.
    pub version: &'static str,
    /// Git revision that it was built from.
    pub revision: &'static str,
    /// Why the chip was reset.
    pub reset: &'static str,
    /// What drives the core.
    pub clock: &'static str,
    /// What `status` shows until a scan has succeeded: a reset by watchdog or crash.
    pub reasons: Reasons,
}

/// What else the scanner needs of its board.
pub trait Board {
    /// Whether `stop` was the last word; survives a reset.
    fn stopped(&self) -> bool;
    /// Remembers whether to stand still.
    fn set_stopped(&mut self, stopped: bool);
    /// A diagnostic value.
    fn measure(&self, measure: Measure) -> u32;
}

/// Stages of the self-test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Test {
    Arithmetic,
    Home,
    /// Until when the module may take, and when to ask again.
    Link {
        until: Micros,
        again: Option<Micros>,
    },
}

/// What is to be done once the self-test has passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Errand {
    /// Scan again and again, or stand still if stopped.
    Resume,
    /// One scan, also when stopped.
    Once,
    /// Answer the `selftest` command.
    Answer,
}

#[derive(Debug)]
enum State {
    Boot,
    SelfTest(Test, Errand),
    Idle,
    Scanning(Sweep),
    /// Rows that were lost, and sentences queued so far.
    Reporting {
        lost: u16,
        next: u8,
    },
    Fault {
        until: Micros,
        told: bool,
    },
}

/// The scanner over its hardware.
#[derive(Debug)]
pub struct Scanner<M, L, P, B, D> {
    mirror: M,
    link: L,
    port: P,
    board: B,
    data: D,
    settings: Settings,
    identity: Identity,
    state: State,
    /// The last scan's answer.
    outcome: Outcome,
    reader: LineReader,
    outbox: Outbox,
    /// Next key that `get` lists.
    listing: Option<usize>,
    scans: u32,
    backward: bool,
    connected: bool,
    reasons: Reasons,
    deadline: Micros,
}

/// An idle poll, or any other that nothing else bounds.
const POLL_US: u32 = 500_000;

impl<M: Mirror, L: RadarLink, P: BytePort, B: Board, D: DataPath> Scanner<M, L, P, B, D> {
    /// A scanner that has just booted. `settings` must be valid.
    pub fn new(
        hardware: (M, L, P, B),
        data: D,
        settings: Settings,
        identity: Identity,
        now: Micros,
    ) -> Self {
        let (mirror, link, port, board) = hardware;
        Self {
            mirror,
            link,
            port,
            board,
            data,
            settings,
            identity,
            state: State::Boot,
            outcome: Outcome::clear(),
            reader: LineReader::default(),
            outbox: Outbox::default(),
            listing: None,
            scans: 0,
            backward: false,
            connected: false,
            reasons: identity.reasons,
            deadline: now.plus(POLL_US),
        }
    }

    /// The data path: map and estimator of the last scan.
    pub fn data(&self) -> &D {
        &self.data
    }

    /// The serial port.
    pub fn port_mut(&mut self) -> &mut P {
        &mut self.port
    }

    /// The mirror.
    pub fn mirror(&self) -> &M {
        &self.mirror
    }

    /// Number of scans begun since boot.
    pub fn scans(&self) -> u32 {
        self.scans
    }

    /// Name of the present state.
    pub fn state(&self) -> &'static str {
        match self.state {
            State::Boot => "boot",
            State::SelfTest(..) => "self-test",
            State::Idle => "idle",
            State::Scanning(_) => "scanning",
            State::Reporting { .. } => "reporting",
            State::Fault { .. } => "fault",
        }
    }

    /// Whether the present state has met its own deadline: only then may the watchdog be fed.
    pub fn healthy(&self, now: Micros) -> bool {
        !now.reached(self.deadline)
    }

    /// Gets as far as it can without waiting.
    pub fn step(&mut self, now: Micros) {
        // The state first: no command comes before the boot sentence.
        self.run(now);
        self.list();
        self.read(now);
        self.outbox.pump(&mut self.port);
    }

    // Most functions below are kept out of line: inlined into each other at every place of use they
    // are three times as much flash, and none of them is hot.

    // ----- commands ---------------------------------------------------------------------------

    /// Reads at most one line, and only when its answer has room.
    fn read(&mut self, now: Micros) {
        while self.listing.is_none() && self.outbox.has_room() {
            let Some(byte) = self.port.read() else { return };
            match self.reader.push(byte) {
                Input::Partial => {}
                Input::Line => return self.execute(now),
                Input::Bad(error) => {
                    self.refuse("-", error.field, error.expected);
                    return;
                }
            }
        }
    }

    #[inline(never)]
    fn refuse(&mut self, command: &str, field: &str, expected: &str) {
        self.outbox.push(&Sentence::Fail {
            command,
            field,
            expected,
        });
    }

    #[inline(never)]
    fn done(&mut self, command: &str) {
        self.outbox.push(&Sentence::Done { command });
    }

    #[inline(never)]
    fn execute(&mut self, now: Micros) {
        let parsed = match command::parse(self.reader.line()) {
            Ok(Command::Set(key, value)) => {
                let result = self.settings.set(key, value);
                match result {
                    Ok(()) => return self.tell_setting(key),
                    Err(error) => return self.refuse("set", error.field, error.expected),
                }
            }
            Ok(command) => command,
            Err(bad) => return self.refuse(bad.command, bad.error.field, bad.error.expected),
        };
        match parsed {
            Command::Start => {
                self.board.set_stopped(false);
                self.done("start");
                if matches!(self.state, State::Idle) {
                    self.resume(now);
                }
            }
            Command::Stop => self.stop(),
            Command::Scan => self.errand(now, "scan", Errand::Once),
            Command::SelfTest => self.errand(now, "selftest", Errand::Answer),
            Command::Status => {
                let status = self.status();
                self.outbox.push(&status);
            }
            Command::Version => self.tell_version(),
            Command::GetAll => self.listing = Some(0),
            Command::Get(key) => self.tell_setting(key),
            Command::Measure(measure) => {
                let value = super::settings::number(i64::from(self.board.measure(measure)));
                let key = measure.key();
                self.outbox.push(&Sentence::Config { key, value: &value });
            }
            Command::Set(..) => {}
        }
    }

    fn stop(&mut self) {
        self.board.set_stopped(true);
        // Half a homing is none; a move of a scan may end by itself and keeps its position.
        if matches!(self.state, State::SelfTest(..)) {
            self.mirror.disable();
        }
        self.state = State::Idle;
        self.done("stop");
    }

    /// `scan` and `selftest`: only from a standstill, where nothing else is under way.
    fn errand(&mut self, now: Micros, command: &str, errand: Errand) {
        if !matches!(self.state, State::Idle | State::Fault { .. }) {
            return self.refuse(command, "state", "idle: stop first");
        }
        if errand == Errand::Answer {
            self.state = State::SelfTest(Test::Arithmetic, errand);
        } else {
            self.done(command);
            self.begin(now, errand);
        }
    }

    #[inline(never)]
    fn tell_setting(&mut self, key: &str) {
        let value = self.settings.get(key).unwrap_or_default();
        self.outbox.push(&Sentence::Config { key, value: &value });
    }

    #[inline(never)]
    fn tell_version(&mut self) {
        let mut value = heapless::String::<64>::new();
        let _ = value.push_str(self.identity.version);
        let _ = value.push(' ');
        let _ = value.push_str(self.identity.revision);
        let key = "version";
        self.outbox.push(&Sentence::Config { key, value: &value });
    }

    /// One more sentence of `get`'s list.
    #[inline(never)]
    fn list(&mut self) {
        let Some(next) = self.listing else { return };
        if !self.outbox.has_room() {
            return;
        }
        match Settings::KEYS.get(next) {
            Some(key) => {
                self.tell_setting(key);
                self.listing = Some(next + 1);
            }
            None => {
                self.done("get");
                self.listing = None;
            }
        }
    }

    fn status(&self) -> Sentence<'static> {
        Sentence::State {
            state: self.state(),
            clock: self.identity.clock,
            scans: self.scans,
            estimator: self.settings.config.estimator.as_str(),
            reasons: self.reasons,
        }
    }

    // ----- states -----------------------------------------------------------------------------

    /// One call of the present state. Whatever it leaves behind sets the next deadline.
    fn run(&mut self, now: Micros) {
        match &mut self.state {
            State::Boot => self.boot(now),
            State::SelfTest(test, errand) => {
                let (test, errand) = (*test, *errand);
                self.self_test(now, test, errand);
            }
            State::Idle => self.deadline = now.plus(POLL_US),
            State::Scanning(sweep) => {
                let (mirror, link, data) = (&mut self.mirror, &mut self.link, &mut self.data);
                let poll = sweep.poll(now, mirror, link, data);
                self.deadline = sweep.deadline();
                if let Poll::Ready(rows) = poll {
                    let radar = sweep.settings().config.radar;
                    self.adopt(radar);
                    self.conclude(rows);
                }
            }
            State::Reporting { .. } => self.report(now),
            State::Fault { .. } => self.fault(now),
        }
    }

    #[inline(never)]
    fn boot(&mut self, now: Micros) {
        let Identity {
            version,
            revision,
            reset,
            clock,
            ..
        } = self.identity;
        self.outbox.push(&Sentence::Boot {
            version,
            revision,
            reset,
            clock,
        });
        self.resume(now);
    }

    /// Scans on unless told to stand still.
    fn resume(&mut self, now: Micros) {
        if self.board.stopped() {
            self.state = State::Idle;
            self.deadline = now.plus(POLL_US);
        } else {
            self.begin(now, Errand::Resume);
        }
    }

    /// Begins a scan, or the self-test if home or link is unknown.
    #[inline(never)]
    fn begin(&mut self, now: Micros, errand: Errand) {
        self.deadline = now.plus(POLL_US);
        if !self.mirror.homed() || !self.connected {
            self.state = State::SelfTest(Test::Arithmetic, errand);
            return;
        }
        self.scans = self.scans.wrapping_add(1);
        let backward = match self.settings.sweeping {
            Sweeping::Both => self.backward,
            Sweeping::Forward => false,
            Sweeping::Backward => true,
        };
        let (mirror, link) = (&mut self.mirror, &mut self.link);
        match Sweep::start(now, &self.settings, self.scans, backward, mirror, link) {
            Ok(sweep) => {
                self.backward = !backward;
                self.state = State::Scanning(sweep);
            }
            Err(reason) => self.enter_reporting(Outcome::fault(reason), 0),
        }
    }

    #[inline(never)]
    fn self_test(&mut self, now: Micros, test: Test, errand: Errand) {
        match test {
            Test::Arithmetic => {
                if !self.data.self_test() {
                    return self.fail_test(now, Reason::SelfTest, errand);
                }
                self.mirror.start_home(&self.settings.motor);
                self.state = State::SelfTest(Test::Home, errand);
                self.deadline = now.plus(self.home_bound_us());
            }
            Test::Home => match self.mirror.poll() {
                Err(error) => self.fail_test(now, mirror_reason(error), errand),
                Ok(Motion::Moving) => {}
                Ok(Motion::Still) => {
                    let until = now.plus(self.settings.timing.connect_timeout);
                    self.ask(now, until, errand);
                }
            },
            Test::Link { until, again } => self.test_link(now, until, again, errand),
        }
    }

    /// Homing takes at most a turn to the switch and a few short moves at an eighth of the speed.
    fn home_bound_us(&self) -> u32 {
        let speed = self.settings.motor.search_speed.max(1);
        let seconds = 3 * MICROSTEPS_PER_TURN as u32 / speed + 1;
        seconds.saturating_mul(1_000_000)
    }

    fn ask(&mut self, now: Micros, until: Micros, errand: Errand) {
        let timeout = self.settings.timing.configure_timeout;
        self.link.configure(now, timeout);
        let test = Test::Link { until, again: None };
        self.state = State::SelfTest(test, errand);
        self.deadline = now.plus(timeout).plus(POLL_US);
    }

    #[inline(never)]
    fn test_link(&mut self, now: Micros, until: Micros, again: Option<Micros>, errand: Errand) {
        if let Some(again) = again {
            if now.reached(again) {
                self.ask(now, until, errand);
            }
            return;
        }
        // The module may be booting for seconds; a stall meanwhile is still a stall.
        if let Err(error) = self.mirror.poll() {
            return self.fail_test(now, mirror_reason(error), errand);
        }
        let Poll::Ready(answer) = self.link.poll_settings(now) else {
            return;
        };
        match answer {
            Ok(radar) => {
                self.connected = true;
                // Whether a scan can be made of it is for the scan to say, which asks again.
                self.adopt(radar);
                self.passed(now, errand);
            }
            Err(error) if now.reached(until) => self.fail_test(now, link_reason(error), errand),
            Err(_) => {
                // An error that came at once is not asked for again at once.
                let pause = now.plus(self.settings.timing.configure_timeout);
                let again = Some(pause);
                self.state = State::SelfTest(Test::Link { until, again }, errand);
                self.deadline = pause.plus(POLL_US);
            }
        }
    }

    /// Keeps what the module says, so that commands are checked against it, unless no scan can be
    /// made of it: then the scan says so, and commands must still work.
    #[inline(never)]
    fn adopt(&mut self, radar: RadarConfig) {
        let mut settings = self.settings;
        settings.config.radar = radar;
        if settings.validate().is_ok() {
            self.settings = settings;
        }
    }

    fn passed(&mut self, now: Micros, errand: Errand) {
        match errand {
            Errand::Once => self.begin(now, errand),
            Errand::Resume => self.resume(now),
            Errand::Answer => {
                self.done("selftest");
                self.reasons = Reasons::NONE;
                self.resume(now);
            }
        }
    }

    /// A failed self-test is told as scan 0: the scanner has no answer, and says why.
    #[inline(never)]
    fn fail_test(&mut self, now: Micros, reason: Reason, errand: Errand) {
        if errand == Errand::Answer {
            self.refuse("selftest", reason.as_str(), "a test that passes");
        }
        self.reasons = Reasons::NONE.with(reason);
        self.enter_fault(now, false);
    }

    #[inline(never)]
    fn enter_fault(&mut self, now: Micros, told: bool) {
        self.mirror.disable();
        self.connected = false;
        let until = now.plus(self.settings.timing.fault_hold);
        self.state = State::Fault { until, told };
        self.deadline = until.plus(POLL_US);
    }

    #[inline(never)]
    fn fault(&mut self, now: Micros) {
        let reasons = self.reasons;
        let State::Fault { until, told } = &mut self.state else {
            return;
        };
        if !*told {
            *told = self.outbox.push(&Sentence::Scan(ScanLine {
                scan: 0,
                status: Status::Fault,
                direction: crate::answer::Direction::None,
                steps: 0,
                lost_rows: 0,
                reasons,
            }));
        } else if now.reached(*until) {
            self.resume(now);
        }
    }

    // ----- results ----------------------------------------------------------------------------

    /// From the last row to the outcome.
    #[inline(never)]
    fn conclude(&mut self, rows: Rows) {
        let mut outcome = match rows.fault {
            Some(reason) => Outcome::fault(reason),
            None => self.data.finish(),
        };
        if rows.lost > 0 {
            outcome.reasons.add(Reason::LostRows);
            if outcome.status == Status::Ok {
                outcome.status = Status::Degraded;
            }
        }
        self.enter_reporting(outcome, rows.lost);
    }

    #[inline(never)]
    fn enter_reporting(&mut self, outcome: Outcome, lost: u16) {
        self.reasons = outcome.reasons;
        self.outcome = outcome;
        self.state = State::Reporting { lost, next: 0 };
    }

    /// Queues the answer's sentences as they fit, and goes on when all are queued.
    #[inline(never)]
    fn report(&mut self, now: Micros) {
        self.deadline = now.plus(POLL_US);
        let scan = self.scans;
        let State::Reporting { lost, next } = &mut self.state else {
            return;
        };
        let outcome = &self.outcome;
        let count = outcome.steps.len() as u8;
        while *next <= count {
            let sentence = match next.checked_sub(1) {
                None => Sentence::Scan(ScanLine {
                    scan,
                    status: outcome.status,
                    direction: outcome.direction,
                    steps: count,
                    lost_rows: *lost,
                    reasons: outcome.reasons,
                }),
                Some(k) => {
                    let step = outcome.steps.get(usize::from(k));
                    let step = step.copied().unwrap_or_default();
                    Sentence::Step(StepLine::new(scan, *next, count, &step))
                }
            };
            if !self.outbox.push(&sentence) {
                return;
            }
            *next += 1;
        }
        if self.outcome.status == Status::Fault && self.broken() {
            self.enter_fault(now, true);
        } else {
            self.resume(now);
        }
    }

    /// Whether hardware is at fault, rather than what the radar sees.
    fn broken(&self) -> bool {
        const HARDWARE: [Reason; 6] = [
            Reason::TooManyLost,
            Reason::LinkSilent,
            Reason::ModuleError,
            Reason::ModuleConfig,
            Reason::MotorStall,
            Reason::HomeNotFound,
        ];
        HARDWARE.iter().any(|&reason| self.reasons.has(reason))
    }
}
