//! The scanner's states: what is under way, what follows, and by when.

use core::task::Poll;

use super::guard::{GuardMode, GuardState};
use super::keeper::{Keeper, ScanSettings};
use super::planes::asks_below;
use super::reports::{Reports, Telling};
use crate::config::{ConfigError, Planes};
use crate::crc;
use crate::drive::{Drive, Retention};
use crate::motion::Odometry;
use crate::port::BytePort;
use crate::report::{GuardLine, Sentence};
use crate::scanner::board::{Board, Hardware, Identity};
use crate::scanner::chain::DataPath;
use crate::scanner::command::CalibrationRequest;
use crate::scanner::mirror::{Mirror, Motion};
use crate::scanner::settings::{Settings, Sweeping, Switch};
use crate::scanner::sweep::{Rows, Sweep, Task, link_reason, mirror_reason};
use crate::schedule::MICROSTEPS_PER_TURN;
use crate::signal::radar::module::RadarModule;
use crate::time::Micros;
use crate::verdict::{Conditions, GuardWord, Outcome, Reason, Reasons, Status};

/// What the self-test is at.
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
pub(super) enum Errand {
    /// Scan again and again, or stand still if stopped.
    Resume,
    /// One scan, also when stopped.
    Once,
    /// One guard sweep.
    Guard,
    /// Answer the `selftest` command.
    Answer,
}

#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is no heap, and the room is the machine's own either way"
)]
enum ScannerState {
    Boot,
    SelfTest(Test, Errand),
    Idle,
    Scanning(Sweep),
    Reporting(Telling),
    /// The word of a guard sweep waits for the port; whether hardware ended the sweep.
    Warning(GuardLine, bool),
    Fault {
        until: Until,
        told: bool,
    },
}

/// How long a fault holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Until {
    /// Then the self-test runs again.
    Time(Micros),
    /// Until a command starts something: trying again by itself has only led back here.
    Told,
}

/// The scanner's states over its hardware; lines from the report port are `commands`' business.
#[derive(Debug)]
pub(super) struct Machine<'a, M, L, P, B, D> {
    pub hardware: Hardware<M, L, P, B>,
    pub(super) data: D,
    pub reports: &'a mut Reports,
    pub odometry: &'a mut Odometry,
    pub settings: Keeper,
    /// Of the scan under way, or the last one.
    pub(super) scan: ScanSettings,
    pub(super) guard: GuardState,
    pub identity: Identity,
    state: ScannerState,
    scans: u32,
    backward: bool,
    pub(super) connected: bool,
    reasons: Reasons,
    deadline: Micros,
    /// When the scanner booted, until it has run for [`SURVIVED_US`].
    booted: Option<Micros>,
    /// Whether the next answer shall be a first one.
    forgets: bool,
    /// Whether the last answer asks for a scan in the height plane.
    below: bool,
    /// When the last row of an answer was worked off, until that is noted.
    pub answered: Option<Micros>,
    /// Requests that the module did not answer as it should.
    pub link_errors: u16,
    /// What the next scan is for, where it is for no answer.
    pub(super) calibration: Option<CalibrationRequest>,
}

/// After so long, and a scan, crashes before this boot are forgotten: 60 s.
const SURVIVED_US: u32 = 60_000_000;
/// An idle poll, or any other that nothing else bounds.
const POLL_US: u32 = 500_000;

impl<M, L, P, B, D> Machine<'_, M, L, P, B, D> {
    /// The data path.
    pub fn data(&self) -> &D {
        &self.data
    }

    /// What is known of the chair's motion in the last scan.
    pub fn drive(&self) -> Drive<'_> {
        self.odometry.drive(self.scan.motion, self.scan.chirp_us)
    }

    /// What earlier scans said has no say in the next answer.
    pub fn forget(&mut self) {
        self.forgets = true;
    }

    /// Number of scans begun since boot.
    pub fn scans(&self) -> u32 {
        self.scans
    }

    /// Name of the present state.
    pub fn state(&self) -> &'static str {
        match self.state {
            ScannerState::Boot => "boot",
            ScannerState::SelfTest(..) => "self-test",
            ScannerState::Idle => "idle",
            ScannerState::Scanning(_) if self.scan.guard => "guarding",
            ScannerState::Warning(..) => "guarding",
            ScannerState::Scanning(_) => "scanning",
            ScannerState::Reporting(_) => "reporting",
            ScannerState::Fault { .. } => "fault",
        }
    }

    /// Whether nothing is under way and nothing moves.
    pub fn stands(&self) -> bool {
        matches!(self.state, ScannerState::Idle | ScannerState::Fault { .. })
    }

    /// Whether the present state has met its own deadline.
    pub fn healthy(&self, now: Micros) -> bool {
        !now.reached(self.deadline)
    }

    /// What `status` says.
    pub fn status(&self, now: Micros) -> Sentence<'static> {
        Sentence::State {
            state: self.state(),
            clock: self.identity.clock,
            scans: self.scans,
            estimator: self.settings.get().config.estimator.as_str(),
            reasons: self.reasons,
            motion: self.odometry.state(now).as_str(),
            motion_faults: self.odometry.faults(),
            settings: self.settings.hash(),
        }
    }
}

// Whatever is inlined into the main loop lies on the stack beneath the estimator, whose frames are
// the deepest of the firmware. Functions with more than a few words of their own are out of line.
impl<'a, M: Mirror, L: RadarModule, P: BytePort, B: Board, D: DataPath> Machine<'a, M, L, P, B, D> {
    /// Just booted; the first call of [`Machine::run`] says so.
    pub fn new(
        hardware: Hardware<M, L, P, B>,
        data: D,
        (reports, odometry): (&'a mut Reports, &'a mut Odometry),
        stored: Option<Settings>,
        identity: Identity,
        now: Micros,
    ) -> Self {
        // What was calibrated with another chip's mirror and mounting is not this one's.
        let chip = crc::of_words(&identity.serial);
        let stored = stored.filter(|settings| settings.calibrated.fits(chip));
        let settings = Keeper::new(stored, hardware.board.settings_before());
        let mut machine = Self {
            scan: ScanSettings::of(&settings, false),
            guard: GuardState::OFF,
            booted: Some(now),
            hardware,
            data,
            reports,
            odometry,
            settings,
            identity,
            state: ScannerState::Boot,
            scans: 0,
            backward: false,
            connected: false,
            reasons: identity.reasons(),
            deadline: now.plus(POLL_US),
            forgets: false,
            below: false,
            answered: None,
            link_errors: 0,
            calibration: None,
        };
        machine.note();
        machine
    }

    /// Lets the board remember settings that somebody vouches for, and no others: a reset that loses
    /// them is to be told until they come again.
    fn note(&mut self) {
        if self.settings.configured() {
            let hash = self.settings.hash();
            self.hardware.board.note_settings(hash);
        }
    }

    /// `set`: what `settings` became by setting `key`.
    pub fn change(&mut self, key: &'static str, settings: &Settings) -> Result<(), ConfigError> {
        if self.guard.is_on() {
            self.fit_to_guard(settings)?;
        }
        self.settings.change(key, settings)?;
        self.note();
        Ok(())
    }

    /// `start`: on and on, from now if nothing is under way.
    pub fn start(&mut self, now: Micros) {
        self.hardware.board.set_stopped(false);
        self.guard.mode = GuardMode::Off;
        self.reports.done("start");
        self.wake(now);
    }

    /// Begins what is to be done, if nothing is under way.
    pub(super) fn wake(&mut self, now: Micros) {
        let until = Until::Told;
        if matches!(self.state, ScannerState::Idle)
            || matches!(self.state, ScannerState::Fault { until: u, .. } if u == until)
        {
            self.resume(now);
        }
    }

    /// `stop`: stand still, whatever is under way, with the motor's driver off. The position is lost
    /// with it, and the next scan homes.
    pub fn stop(&mut self) {
        self.hardware.board.set_stopped(true);
        self.hardware.mirror.disable();
        self.calibration = None;
        self.below = false;
        self.guard = GuardState::OFF;
        self.state = ScannerState::Idle;
        self.reports.done("stop");
    }

    /// `scan` and `selftest`: only from a standstill, where nothing else is under way.
    pub fn errand(&mut self, now: Micros, command: &str, errand: Errand) {
        if errand == Errand::Once && self.guard.is_on() && !self.stands() {
            // What is under way ends before.
            self.guard.asked = true;
            return self.reports.done(command);
        }
        if !self.stands() {
            return self.reports.refuse(command, "state", "idle: stop first");
        }
        if errand == Errand::Answer {
            self.state = ScannerState::SelfTest(Test::Arithmetic, errand);
        } else {
            self.reports.done(command);
            self.begin(now, errand);
        }
    }

    /// One call of the present state. Whatever it leaves behind sets the next deadline.
    pub fn run(&mut self, now: Micros) {
        match &mut self.state {
            ScannerState::Boot => self.boot(now),
            ScannerState::SelfTest(test, errand) => {
                let (test, errand) = (*test, *errand);
                self.self_test(now, test, errand);
            }
            ScannerState::Idle => self.deadline = now.plus(POLL_US),
            ScannerState::Scanning(sweep) => {
                let (mirror, link, data) = (
                    &mut self.hardware.mirror,
                    &mut self.hardware.link,
                    &mut self.data,
                );
                let poll = sweep.poll(now, mirror, link, data);
                if let Some((row, at)) = sweep.fired() {
                    let mid = sweep.settings().timing.chirp_duration / 2;
                    self.odometry.row(row, at.plus(mid));
                }
                self.deadline = sweep.deadline();
                self.link_errors = self.link_errors.saturating_add(sweep.failed());
                if let Poll::Ready(rows) = poll {
                    let radar = sweep.settings().config.radar;
                    self.settings.adopt(radar);
                    match self.scan.guard {
                        true => self.guarded(now, rows),
                        false => self.conclude(now, rows),
                    }
                }
            }
            ScannerState::Reporting(_) => self.report(now),
            ScannerState::Warning(line, broken) => {
                let (line, broken) = (*line, *broken);
                self.told(now, line, broken);
            }
            ScannerState::Fault { .. } => self.fault(now),
        }
    }

    #[inline(never)]
    fn boot(&mut self, now: Micros) {
        self.reports.boot(&self.identity, self.settings.hash());
        if self.identity.crash_loop && !self.hardware.board.stopped() {
            self.hardware.mirror.disable();
            let (until, told) = (Until::Told, false);
            self.state = ScannerState::Fault { until, told };
        } else {
            self.resume(now);
        }
    }

    /// Scans on unless told to stand still; the scan in the height plane that an answer asks for belongs to it.
    pub(super) fn resume(&mut self, now: Micros) {
        let guards = self.guard.is_on();
        if core::mem::take(&mut self.guard.asked) || (guards && self.below) {
            self.begin(now, Errand::Once);
        } else if guards {
            self.begin(now, Errand::Guard);
        } else if self.hardware.board.stopped() && !self.below {
            self.state = ScannerState::Idle;
            self.deadline = now.plus(POLL_US);
        } else {
            self.begin(now, Errand::Resume);
        }
    }

    /// Begins a scan, or the self-test if home or link is unknown.
    #[inline(never)]
    pub(super) fn begin(&mut self, now: Micros, errand: Errand) {
        self.deadline = now.plus(POLL_US);
        let below = core::mem::take(&mut self.below);
        let unfit = self.identity.fitness.fault(self.settings.get()).is_some();
        self.hardware.mirror.check(&self.settings.get().motor);
        if unfit || !self.hardware.mirror.homed() || !self.connected {
            self.state = ScannerState::SelfTest(Test::Arithmetic, errand);
            return;
        }
        if errand == Errand::Guard
            && let Err(error) = self.fit_to_guard(self.settings.get())
        {
            // The module is not what the settings ask for.
            return self.end_guard(now, error);
        }
        self.scan = ScanSettings::of(&self.settings, below);
        self.scan.guard = errand == Errand::Guard;
        let number = match self.scan.guard {
            true => &mut self.guard.sweep,
            false => &mut self.scans,
        };
        *number = number.wrapping_add(1);
        let number = *number;
        if !self.settings.intact() {
            return self.report_broken(Reason::SettingsDamaged, Conditions::GOOD, 0);
        }
        let backward = match self.settings.get().sweeping {
            // The guard goes both ways in turn, and the first one as is set.
            Sweeping::Backward if self.scan.guard && number == 1 => true,
            _ if self.scan.guard => self.backward,
            Sweeping::Both => self.backward,
            Sweeping::Forward => false,
            Sweeping::Backward => true,
        };
        let (mirror, link) = (&mut self.hardware.mirror, &mut self.hardware.link);
        let task = Task {
            number,
            plane: self.scan.plane,
            guard: self.scan.guard,
            running: core::mem::take(&mut self.guard.running),
        };
        match Sweep::start(now, self.settings.get(), task, backward, mirror, link) {
            Ok(sweep) => {
                let settings = self.settings.get();
                self.odometry.allow(settings.timing.motion_timeout);
                let angles = match task.guard {
                    true => settings.guard.sweep(),
                    false => settings.config.sweep,
                };
                self.odometry.begin(angles.angle_count);
                // A scan in between goes the way of the next one, whose beginning then is near.
                if !self.scan.stands_aside() {
                    self.backward = !backward;
                }
                self.state = ScannerState::Scanning(sweep);
            }
            Err(reason) => self.report_broken(reason, Conditions::GOOD, 0),
        }
    }

    #[inline(never)]
    fn self_test(&mut self, now: Micros, test: Test, errand: Errand) {
        match test {
            Test::Arithmetic => {
                if let Some(unfit) = self.identity.fitness.fault(self.settings.get()) {
                    return self.fail_test(now, unfit, errand);
                }
                if !self.data.self_test() {
                    return self.fail_test(now, Reason::SelfTest, errand);
                }
                self.hardware.mirror.start_home(&self.settings.get().motor);
                self.state = ScannerState::SelfTest(Test::Home, errand);
                self.deadline = now.plus(self.home_bound_us());
            }
            Test::Home => match self.hardware.mirror.poll(now) {
                Err(error) => self.fail_test(now, mirror_reason(error), errand),
                Ok(Motion::Moving) => {}
                Ok(Motion::Still) => {
                    let until = now.plus(self.settings.get().timing.connect_timeout);
                    self.ask(now, until, errand);
                }
            },
            Test::Link { until, again } => self.test_link(now, until, again, errand),
        }
    }

    /// Homing takes at most a turn to the switch and a few short moves at an eighth of the speed.
    fn home_bound_us(&self) -> u32 {
        let speed = self.settings.get().motor.search_speed.max(1);
        let seconds = 3 * MICROSTEPS_PER_TURN as u32 / speed + 1;
        seconds.saturating_mul(1_000_000)
    }

    fn ask(&mut self, now: Micros, until: Micros, errand: Errand) {
        let timeout = self.settings.get().timing.configure_timeout;
        let wish = &self.settings.get().module;
        self.hardware.link.program(now, wish, timeout);
        let test = Test::Link { until, again: None };
        self.state = ScannerState::SelfTest(test, errand);
        self.deadline = now.plus(timeout).plus(POLL_US);
    }

    fn test_link(&mut self, now: Micros, until: Micros, again: Option<Micros>, errand: Errand) {
        if let Some(again) = again {
            if now.reached(again) {
                self.ask(now, until, errand);
            }
            return;
        }
        // The module may be booting for seconds; a stall meanwhile is still a stall.
        if let Err(error) = self.hardware.mirror.poll(now) {
            return self.fail_test(now, mirror_reason(error), errand);
        }
        let Poll::Ready(answer) = self.hardware.link.settings(now) else {
            return;
        };
        self.link_errors = (self.link_errors).saturating_add(answer.is_err().into());
        match answer {
            Ok(radar) => {
                self.connected = true;
                // Whether a scan can be made of it is for the scan to say, which asks again.
                self.settings.adopt(radar);
                self.passed(now, errand);
            }
            Err(error) if now.reached(until) => self.fail_test(now, link_reason(error), errand),
            Err(_) => {
                // An error that came at once is not asked for again at once.
                let pause = now.plus(self.settings.get().timing.configure_timeout);
                let again = Some(pause);
                self.state = ScannerState::SelfTest(Test::Link { until, again }, errand);
                self.deadline = pause.plus(POLL_US);
            }
        }
    }

    fn passed(&mut self, now: Micros, errand: Errand) {
        self.hardware.board.self_test_passed();
        match errand {
            Errand::Once => self.begin(now, errand),
            Errand::Guard | Errand::Resume => self.resume(now),
            Errand::Answer => {
                self.reports.done("selftest");
                self.reasons = Reasons::NONE;
                self.resume(now);
            }
        }
    }

    /// A failed self-test is told as scan 0: the scanner has no answer, and says why.
    fn fail_test(&mut self, now: Micros, reason: Reason, errand: Errand) {
        if self.calibration.take().is_some() {
            self.refuse_calibration(ConfigError {
                field: reason.as_str(),
                expected: "a test that passes",
            });
        }
        if errand == Errand::Answer {
            self.reports
                .refuse("selftest", reason.as_str(), "a test that passes");
        }
        self.reasons = match self.scans {
            // Why the chip was reset is told as long as it has not scanned.
            0 => self.identity.reasons().with(reason),
            _ => Reasons::NONE.with(reason),
        };
        self.enter_fault(now, false);
    }

    fn enter_fault(&mut self, now: Micros, told: bool) {
        self.hardware.mirror.disable();
        self.connected = false;
        let until = now.plus(self.settings.get().timing.fault_hold);
        self.deadline = until.plus(POLL_US);
        let until = Until::Time(until);
        self.state = ScannerState::Fault { until, told };
    }

    #[inline(never)]
    fn fault(&mut self, now: Micros) {
        let settings = self.settings.hash();
        let ScannerState::Fault { until, told } = &mut self.state else {
            return;
        };
        if !*told {
            *told = self.reports.failed_test(self.reasons, settings);
        }
        let (until, told) = (*until, *told);
        match until {
            Until::Told => self.deadline = now.plus(POLL_US),
            Until::Time(until) if told && now.reached(until) => self.resume(now),
            Until::Time(_) => {}
        }
    }

    /// From the last row to the outcome.
    #[inline(never)]
    fn conclude(&mut self, now: Micros, rows: Rows) {
        let aside = self.scan.stands_aside();
        match aside {
            true => self.odometry.finish_aside(now),
            false => self.odometry.finish(now),
        }
        if let Some(task) = self.calibration.take() {
            self.calibrated(&rows, task);
            return self.resume(now);
        }
        let ScanSettings {
            motion,
            fusion,
            chirp_us,
            planes,
            ..
        } = self.scan;
        let conditions = Conditions {
            board: self.identity.fitness.doubts(),
            configured: self.scan.configured,
            lost_rows: rows.lost > 0,
        };
        if let Some(reason) = rows.fault {
            return self.report_broken(reason, conditions, rows.lost);
        }
        let memory = match fusion {
            _ if aside => Retention::Aside,
            Switch::Off => Retention::Off,
            Switch::On if self.forgets => Retention::Anew,
            Switch::On => Retention::Kept,
        };
        self.odometry.remember(memory);
        self.forgets &= aside;
        let drive = self.odometry.drive(motion, chirp_us);
        let outcome = self.data.conclude(&drive, conditions);
        if outcome.status() != Status::Fault {
            self.answered = Some(now);
        }
        self.guard.note(now, &outcome);
        let may = planes == Planes::Both && !aside;
        self.below = may && asks_below(&self.settings.get().config, &outcome, &drive);
        self.enter_reporting(outcome, rows.lost, false);
    }

    /// Tells that hardware did not let the scan begin, or ended it.
    // Out of line: its outcome would lie beneath the estimator beside the one that the estimator makes.
    #[inline(never)]
    fn report_broken(&mut self, reason: Reason, conditions: Conditions, lost: u16) {
        if self.scan.guard {
            return self.warn(&GuardWord::broken(reason), true);
        }
        let faults = Reasons::NONE.with(reason);
        self.enter_reporting(Outcome::broken(faults, conditions), lost, true);
    }

    /// Tells the word of a guard sweep; `broken` says that hardware ended it, or did not let it begin.
    pub(super) fn warn(&mut self, word: &GuardWord, broken: bool) {
        self.reasons = word.reasons();
        self.state = ScannerState::Warning(GuardLine::new(self.guard.sweep, word), broken);
    }

    /// Queues the word of a guard sweep once it fits, and goes on.
    #[inline(never)]
    fn told(&mut self, now: Micros, line: GuardLine, broken: bool) {
        self.deadline = now.plus(POLL_US);
        if !self.reports.guard(line) {
            return;
        }
        self.forget_crashes(now, line.status == Status::Fault);
        if broken {
            self.enter_fault(now, true);
        } else {
            self.resume(now);
        }
    }

    fn enter_reporting(&mut self, outcome: Outcome, lost: u16, broken: bool) {
        self.reasons = outcome.reasons();
        self.reports.outcome = outcome;
        self.state = ScannerState::Reporting(Telling {
            scan: self.scans,
            settings: self.scan.hash,
            plane: self.scan.told_plane(),
            lost,
            broken,
            queued: 0,
        });
    }

    /// Queues the answer's sentences as they fit, and goes on when all are queued.
    #[inline(never)]
    fn report(&mut self, now: Micros) {
        self.deadline = now.plus(POLL_US);
        let ScannerState::Reporting(telling) = &mut self.state else {
            return;
        };
        if !self.reports.tell(telling) {
            return;
        }
        let broken = telling.broken;
        let fault = self.reports.outcome.status() == Status::Fault;
        self.forget_crashes(now, fault);
        if broken {
            self.enter_fault(now, true);
        } else {
            self.resume(now);
        }
    }

    /// Once the firmware has run for a minute, a scan has come to its end.
    fn forget_crashes(&mut self, now: Micros, fault: bool) {
        if !fault && self.booted.is_some_and(|at| now.since(at) >= SURVIVED_US) {
            self.booted = None;
            self.hardware.board.survived();
        }
    }
}
