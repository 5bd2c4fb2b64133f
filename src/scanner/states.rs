//! State machine of the scanner: the current activity, what follows it, and its deadline.

mod reporting;
mod self_test;

use core::task::Poll;

use super::chain::DataPath as _;
use super::guard::{GuardMode, GuardState};
use super::keeper::{ActiveSettings, ScanSettings};
use super::reports::{ReportProgress, Reports};
use crate::config::ConfigError;
use crate::crc;
use crate::drive::Drive;
use crate::motion::Odometry;
use crate::report::{GuardLine, Sentence};
use crate::scanner::board::{Board, BootInfo};
use crate::scanner::command::CalibrationRequest;
use crate::scanner::mirror::Mirror;
use crate::scanner::parts::{Hardware, LentParts, Parts};
use crate::scanner::rest::Rest;
use crate::scanner::settings::{Settings, Sweeping};
use crate::scanner::sweep::{Sweep, Task};
use crate::signal::radar::module::RadarModule;
use crate::time::Micros;
use crate::verdict::{Conditions, Reason, Reasons};

/// Stage of the self-test: arithmetic, homing of the mirror, then radar module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Test {
    Arithmetic,
    Home,
    /// The radar module is queried: `until` is the timeout of its first answer, `again` the time of the next
    /// query after one that failed.
    Link {
        until: Micros,
        again: Option<Micros>,
    },
}

/// Activity that follows a passed self-test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Activity {
    /// Scan repeatedly, or stay idle if stopped.
    Resume,
    /// One scan, also when stopped.
    Once,
    /// One guard sweep.
    Guard,
    /// Answer the command `selftest`.
    Answer,
}

#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is no heap, and the room is the machine's own either way"
)]
enum ScannerState {
    Boot,
    SelfTest(Test, Activity),
    Idle,
    Scanning(Sweep),
    Reporting(ReportProgress),
    /// The sentence of a guard sweep waits for room; `true` if a hardware fault prevented or ended the sweep.
    ReportingGuard(GuardLine, bool),
    Fault {
        until: Until,
        reported: bool,
    },
}

/// Condition that ends the state `fault`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Until {
    /// The state ends at this time; then the self-test runs again.
    Time(Micros),
    /// The state ends when a command starts something: after a series of crashes the scanner does not begin by itself.
    Command,
}

/// The scanner's state machine over its hardware; `commands` executes the lines of the report port with it.
pub(super) struct Machine<'a, H: Parts> {
    pub hardware: Hardware<H::Mirror, H::Module, H::Port, H::Board>,
    pub(super) data: H::Data,
    pub reports: &'a mut Reports,
    pub odometry: &'a mut Odometry,
    pub settings: ActiveSettings,
    /// Settings of the current scan, or of the last one.
    pub(super) scan: ScanSettings,
    pub(super) guard: GuardState,
    pub identity: BootInfo,
    state: ScannerState,
    scans: u32,
    backward: bool,
    pub(super) connected: bool,
    reasons: Reasons,
    deadline: Micros,
    /// Time of the boot; `None` once the count of earlier crashes has been cleared.
    booted: Option<Micros>,
    /// Whether the next answer discards the evidence of earlier scans.
    discard_evidence: bool,
    /// Whether the last answer requests a scan in the height plane.
    height_requested: bool,
    /// Time when the last row of an answer was processed, until `LIVE` has taken it over.
    pub answered: Option<Micros>,
    /// Number of requests since boot that the radar module did not answer correctly; saturates.
    pub link_errors: u16,
    /// Calibration request that the next scan serves; such a scan gives no answer.
    pub(super) calibration: Option<CalibrationRequest>,
}

/// Time within which the state machine must run again when idle, or in any step without a limit of its own, µs.
const POLL_US: u32 = 500_000;

impl<H: Parts> Machine<'_, H> {
    /// Returns the data path.
    pub fn data(&self) -> &H::Data {
        &self.data
    }

    /// Returns the chair's motion during the last scan, as far as it is known.
    pub fn drive(&self) -> Drive<'_> {
        self.odometry.drive(self.scan.motion, self.scan.chirp_us)
    }

    /// Has the next answer discard the evidence of earlier scans.
    pub fn discard_evidence(&mut self) {
        self.discard_evidence = true;
    }

    /// Returns the number of scans begun since boot.
    pub fn scans(&self) -> u32 {
        self.scans
    }

    /// Returns the name of the scanner's current state, such as `idle` or `scanning`.
    pub fn state(&self) -> &'static str {
        match self.state {
            ScannerState::Boot => "boot",
            ScannerState::SelfTest(..) => "self-test",
            ScannerState::Idle => "idle",
            ScannerState::Scanning(_) if self.scan.guard => "guarding",
            ScannerState::ReportingGuard(..) => "guarding",
            ScannerState::Scanning(_) => "scanning",
            ScannerState::Reporting(_) => "reporting",
            ScannerState::Fault { .. } => "fault",
        }
    }

    /// Whether the scanner is idle or in the state `fault`, so that nothing moves.
    pub fn stands(&self) -> bool {
        matches!(self.state, ScannerState::Idle | ScannerState::Fault { .. })
    }

    /// Whether the current state is within its deadline.
    pub fn healthy(&self, now: Micros) -> bool {
        !now.reached(self.deadline)
    }

    /// Keeps the ages of past events from wrapping with the clock; to be called every few minutes.
    // Out of line because of the stack.
    #[inline(never)]
    pub fn keep_ages(&mut self, now: Micros) {
        self.odometry.keep_ages(now);
        self.guard.keep_ages(now);
        self.booted = self.booted.map(|at| at.aged(now));
    }

    /// Returns the answer to the command `status`.
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

// Everything that is inlined into the main loop stays on the stack beneath the estimator, whose frames are the
// deepest of the firmware. So functions with more than a few words of locals are out of line.
impl<'a, H: Parts> Machine<'a, H> {
    /// Creates the state machine after boot; the first call of [`Machine::run`] sends the boot sentence.
    pub fn new(
        hardware: Hardware<H::Mirror, H::Module, H::Port, H::Board>,
        data: H::Data,
        LentParts { reports, odometry }: LentParts<'a>,
        stored: Option<Settings>,
        identity: BootInfo,
        now: Micros,
    ) -> Self {
        // A calibration with another chip belongs to another mirror and mounting.
        let chip = crc::of_words(&identity.serial);
        let stored = stored.filter(|settings| settings.calibrated.fits(chip));
        let settings = ActiveSettings::new(stored, hardware.board.retained_settings_hash());
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
            discard_evidence: false,
            height_requested: false,
            answered: None,
            link_errors: 0,
            calibration: None,
        };
        machine.note();
        machine
    }

    /// Has the board retain the hash of the settings if they are configured. If a reset loses these settings,
    /// `unconfigured` is reported until they are set again.
    fn note(&mut self) {
        if self.settings.configured() {
            let hash = self.settings.hash();
            self.hardware.board.retain_settings_hash(hash);
        }
    }

    /// Executes `set`: replaces the settings in force by `settings`, in which `key` has changed.
    pub fn change(&mut self, key: &'static str, settings: &Settings) -> Result<(), ConfigError> {
        if self.guard.is_on() {
            self.fit_to_guard(settings)?;
        }
        self.settings.change(key, settings)?;
        self.note();
        Ok(())
    }

    /// Executes `start`: scans repeatedly, from now on if nothing is under way.
    pub fn start(&mut self, now: Micros) {
        self.hardware.board.set_stopped(false);
        self.guard.mode = GuardMode::Off;
        self.reports.done("start");
        self.wake(now);
    }

    /// Begins the next activity if the scanner is idle, or in a fault that waits for a command.
    pub(super) fn wake(&mut self, now: Micros) {
        let until = Until::Command;
        if matches!(self.state, ScannerState::Idle)
            || matches!(self.state, ScannerState::Fault { until: u, .. } if u == until)
        {
            self.resume(now);
        }
    }

    /// Executes `stop`: ends any activity and switches the motor driver off. The position is lost with it, and
    /// the next scan homes.
    pub fn stop(&mut self) {
        self.hardware.board.set_stopped(true);
        self.hardware.mirror.disable();
        self.calibration = None;
        self.height_requested = false;
        self.guard = GuardState::OFF;
        self.state = ScannerState::Idle;
        self.reports.done("stop");
    }

    /// Executes `scan` or `selftest`, by `errand`: only when idle or in a fault; while guarding, a scan follows
    /// the current sweep.
    pub fn errand(&mut self, now: Micros, command: &str, errand: Activity) {
        if errand == Activity::Once && self.guard.is_on() && !self.stands() {
            // The current sweep ends first.
            self.guard.asked = true;
            return self.reports.done(command);
        }
        if !self.stands() {
            return self.reports.refuse(command, "state", "idle: stop first");
        }
        if errand == Activity::Answer {
            self.state = ScannerState::SelfTest(Test::Arithmetic, errand);
        } else {
            self.reports.done(command);
            self.begin(now, errand);
        }
    }

    /// Returns how long the next step may wait if no interrupt comes.
    pub fn rest(&self, now: Micros) -> Rest {
        let link = &self.hardware.link;
        let waits = || Rest::Short.only_if(!self.reports.has_room());
        match &self.state {
            ScannerState::Boot | ScannerState::SelfTest(Test::Arithmetic, _) => Rest::None,
            ScannerState::SelfTest(Test::Home, _) => Rest::Short,
            ScannerState::SelfTest(Test::Link { again: None, .. }, _) => {
                Rest::Reply.only_if(link.waits())
            }
            ScannerState::SelfTest(Test::Link { .. }, _) | ScannerState::Idle => Rest::Long,
            ScannerState::Scanning(sweep) => sweep.may_rest(now, link),
            ScannerState::Reporting(_) | ScannerState::ReportingGuard(..) => waits(),
            ScannerState::Fault { reported: true, .. } => Rest::Long,
            ScannerState::Fault { .. } => waits(),
        }
    }

    /// Runs the current state once, without waiting. The state that follows sets the next deadline.
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
                if let Some((row, at)) = sweep.triggered() {
                    if let Some(travel) = self.odometry.expected_travel(self.scan.motion, at) {
                        self.data.expect_motion(travel);
                    }
                    let mid = sweep.settings().capture_us() / 2;
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
            ScannerState::ReportingGuard(line, broken) => {
                let (line, broken) = (*line, *broken);
                self.report_guard(now, line, broken);
            }
            ScannerState::Fault { .. } => self.fault(now),
        }
    }

    #[inline(never)]
    fn boot(&mut self, now: Micros) {
        let last = self.hardware.board.last_crash();
        self.reports
            .boot(&self.identity, self.settings.hash(), last);
        if self.identity.crash_loop && !self.hardware.board.stopped() {
            self.hardware.mirror.disable();
            let (until, reported) = (Until::Command, false);
            self.state = ScannerState::Fault { until, reported };
        } else {
            self.resume(now);
        }
    }

    /// Continues after an activity: with a full scan that has been requested, with guard sweeps while guarding,
    /// or else with scans unless stopped. A scan in the height plane that an answer requests is made even when
    /// stopped.
    pub(super) fn resume(&mut self, now: Micros) {
        let guards = self.guard.is_on();
        if core::mem::take(&mut self.guard.asked) || (guards && self.height_requested) {
            self.begin(now, Activity::Once);
        } else if guards {
            self.begin(now, Activity::Guard);
        } else if self.hardware.board.stopped() && !self.height_requested {
            self.state = ScannerState::Idle;
            self.deadline = now.plus(POLL_US);
        } else {
            self.begin(now, Activity::Resume);
        }
    }

    /// Begins a scan or guard sweep, or the self-test before it if home or link is unknown. `errand` is the
    /// activity after that self-test.
    #[inline(never)]
    pub(super) fn begin(&mut self, now: Micros, errand: Activity) {
        self.deadline = now.plus(POLL_US);
        let below = core::mem::take(&mut self.height_requested);
        let unfit = self.identity.health.fault(self.settings.get()).is_some();
        self.hardware.mirror.check(&self.settings.get().motor);
        if unfit || !self.hardware.mirror.homed() || !self.connected {
            self.state = ScannerState::SelfTest(Test::Arithmetic, errand);
            return;
        }
        if errand == Activity::Guard
            && let Err(error) = self.fit_to_guard(self.settings.get())
        {
            // The module differs from what the settings request.
            return self.end_guard(now, error);
        }
        self.scan = ScanSettings::of(&self.settings, below);
        self.scan.guard = errand == Activity::Guard;
        let number = match self.scan.guard {
            true => &mut self.guard.sweep,
            false => &mut self.scans,
        };
        *number = number.wrapping_add(1);
        let number = *number;
        if self.scan.guard {
            self.guard.reported_sweep = number;
        }
        if !self.settings.intact() {
            return self.report_broken(Reason::SettingsDamaged, Conditions::GOOD, 0);
        }
        let backward = match self.settings.get().sweeping {
            // Guard sweeps alternate in direction. With `sweep up` the first one is backward; otherwise it continues
            // the alternation of the sweeps before.
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
            mirror_moving: core::mem::take(&mut self.guard.mirror_moving),
        };
        match Sweep::start(now, self.settings.get(), task, backward, mirror, link) {
            Ok(sweep) => {
                let settings = self.settings.get();
                self.odometry.set_max_age(settings.timing.motion_timeout);
                let angles = match task.guard {
                    true => settings.guard.sweep(),
                    false => settings.config.sweep,
                };
                self.odometry.begin(angles.angle_count);
                // A scan in the height plane takes the direction of the next scan, whose start position then is
                // near.
                if !self.scan.is_other_plane() {
                    self.backward = !backward;
                }
                self.state = ScannerState::Scanning(sweep);
            }
            Err(reason) => self.report_broken(reason, Conditions::GOOD, 0),
        }
    }

    fn enter_fault(&mut self, now: Micros, reported: bool) {
        self.hardware.mirror.disable();
        self.connected = false;
        let until = now.plus(self.settings.get().timing.fault_hold);
        self.deadline = until.plus(POLL_US);
        let until = Until::Time(until);
        self.state = ScannerState::Fault { until, reported };
    }

    #[inline(never)]
    fn fault(&mut self, now: Micros) {
        let settings = self.settings.hash();
        let ScannerState::Fault { until, reported } = &mut self.state else {
            return;
        };
        if !*reported {
            *reported = self.reports.failed_test(self.reasons, settings);
        }
        let (until, stated) = (*until, *reported);
        match until {
            Until::Command => self.deadline = now.plus(POLL_US),
            Until::Time(until) if stated && now.reached(until) => self.resume(now),
            Until::Time(_) => {}
        }
    }
}
