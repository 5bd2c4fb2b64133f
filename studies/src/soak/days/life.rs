//! One life of the scanner, from a boot to the next: the loop of the image with its watchdog, in simulated time.
//!
//! The loop runs pass after pass while something happens, and otherwise skips to the next event of the hardware, with
//! a random delay.

use std::cell::RefCell;
use std::rc::Rc;

use anyhow::{Result, bail};
use stairscan::config::RadarConfig;
use stairscan::motion::Odometry;
use stairscan::motion::odometry::MAX_AGE_US;
use stairscan::report::Sentence;
use stairscan::scanner::command::framed;
use stairscan::scanner::mirror::Stepper;
use stairscan::scanner::pace::{Cruise, RowWork};
use stairscan::scanner::settings::SweepMode;
use stairscan::scanner::{BootInfo, Hardware, LentParts, Reports, Scanner, Schedule, Settings};

use testbed::{Board, Module, Shared};

use super::controller::Controller;
use super::data::StubPath;
use super::gaps::{Instant, SPAN_US};
use super::watch::{ExpectedInput, Watch};
use super::world::{Handle, World};
use host_sim::scene::maths::Random;
use host_sim::volatile::identity;

/// Timeout of the watchdog, µs (src/board/start.rs).
const WATCHDOG_US: u64 = 2_000_000;
/// Minimum time between two resets of the watchdog's counter, µs (src/board/start.rs).
const WATCHDOG_PAUSE_US: u64 = 50_000;
/// Period of `LIVE`, µs (docs/user/report.md).
const LIVE_US: u64 = 200_000;
/// Longest time that the loop skips while the scanner is idle, µs: within the 100 ms of margin of a deadline.
const SKIP_IDLE_US: u64 = 40_000;
/// Longest time that the loop skips in a continuous sweep, µs: the times of its events are known.
const SKIP_TURN_US: u64 = 20_000;
/// Longest time that the loop skips in any other state, µs, where the scanner waits for times that the simulation does
/// not know.
const SKIP_US: u64 = 3_000;
/// Timeout of the reply to a command, µs: a listing of all settings takes a third of a second, a self-test seconds.
const REPLY_US: u64 = 30_000_000;

/// State of the endurance run, which outlives the scanner's resets.
pub struct Run {
    /// Simulated hardware and clock around the scanner.
    pub world: Rc<RefCell<World>>,
    /// The chair's controller, which sends motion sentences.
    pub controller: Controller,
    /// Checks of the scanner's sentences.
    pub watch: Watch,
    /// Random number generator of the plan.
    pub random: Random,
    /// Settings that the scanner should have in force.
    pub active: Settings,
    /// Settings that were saved to flash last; `None` before the first save.
    pub saved: Option<Settings>,
    /// Number of wraps of the scanner's 32-bit clock.
    pub wraps: u64,
    /// Number of times that the settings were saved.
    pub saves: u64,
    /// Number of boots of the scanner.
    pub boots: u64,
    /// Defect that is still to come, for a test of the checks; `None` without one, or once it has come.
    pub defect: Option<Defect>,
    /// Time from which on motion sentences arrive without a disturbance, µs of the run.
    motion_from: u64,
}

/// A defect that the plan does not announce, so that the checks must find it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Defect {
    /// The scanner's clock jumps by a second.
    ClockJumps,
    /// A byte of a sent sentence changes.
    ByteChanges,
    /// The radar module falls silent.
    ModuleSilent,
    /// The scanner's loop hangs for three seconds.
    LoopHangs,
}

/// Time of the defect, µs of the run: 2 hours.
const DEFECT_AT_US: u64 = 7_200_000_000;
/// Error of a clock that jumps, µs.
const JUMP_US: u32 = 1_000_000;
/// Time for which a loop hangs, µs: longer than the watchdog's timeout.
const HANG_US: u64 = 3_000_000;

/// Number of the plan's stream of random numbers.
const STREAM: u64 = 0x4441_5953;

impl Run {
    /// Creates the state of a run before its first boot.
    pub fn new(seed: u64) -> Self {
        Self {
            world: Rc::new(RefCell::new(World::new(seed))),
            controller: Controller::new(seed),
            watch: Watch::default(),
            random: Random::new(seed, STREAM),
            active: Settings::default(),
            saved: None,
            wraps: 0,
            saves: 0,
            boots: 0,
            defect: None,
            motion_from: 0,
        }
    }

    /// Returns the present time of the run, with the scanner's clock.
    pub fn instant(&self) -> Instant {
        self.world.borrow().instant()
    }
}

/// Memory that a scanner borrows: reports and odometry.
pub struct LifeMemory {
    reports: Reports,
    odometry: Odometry,
}

impl LifeMemory {
    /// Memory after a reset.
    pub fn new() -> Self {
        Self {
            reports: Reports::new(),
            odometry: Odometry::new(),
        }
    }
}

/// Hardware of the scanner under test.
type Simulated = Hardware<Stepper<Handle>, Shared<Module>, Handle, Shared<Board>>;

/// A running scanner, from one reset to the next.
pub struct Life<'a> {
    scanner: Scanner<'a, (Simulated, StubPath)>,
    answered: Rc<RefCell<Option<u64>>>,
    /// The run of which this life is a part.
    pub run: &'a mut Run,
    fed: u64,
    /// Time at which the next `LIVE` is due, µs of the run, and the delay behind it with which the loop comes to it,
    /// µs.
    live: u64,
    late: u64,
}

impl<'a> Life<'a> {
    /// Resets the scanner; `reset` is the cause.
    pub fn new(memory: &'a mut LifeMemory, run: &'a mut Run, reset: &'static str) -> Self {
        let handle = || Handle(run.world.clone());
        let now = {
            let world = &mut *run.world.borrow_mut();
            (world.booted, world.clock_error) = (world.now, 0);
            world.board.get().boots += 1;
            world.port.device.clear();
            world.port.wires.waiting = false;
            world.now
        };
        run.boots += 1;
        let board = run.world.borrow().board.clone();
        let saved = board.get().load();
        let clock = run.world.borrow().clock();
        let hardware = Hardware {
            mirror: Stepper::new(handle()),
            link: run.world.borrow().module.clone(),
            port: handle(),
            board: board.clone(),
        };
        let data = StubPath::new(run.world.clone(), run.controller.true_travel());
        let answered = data.answered.clone();
        let identity = BootInfo {
            reset,
            boots: board.get().boots,
            ..identity("soak")
        };
        run.watch.boot(run.world.borrow().instant());
        let lent = LentParts {
            reports: &mut memory.reports,
            odometry: &mut memory.odometry,
        };
        let scanner = Scanner::new(hardware, data, lent, saved, identity, clock);
        Self {
            scanner,
            answered,
            run,
            fed: now,
            live: now + LIVE_US,
            late: 0,
        }
    }

    /// Returns the time since the beginning of the run, µs.
    pub fn now(&self) -> u64 {
        self.run.world.borrow().now
    }

    /// Returns the time of the next wrap of the scanner's clock, µs of the run.
    pub fn next_wrap(&self) -> u64 {
        let world = self.run.world.borrow();
        let gone = (world.now - world.booted) / SPAN_US;
        world.booted + (gone + 1) * SPAN_US
    }

    /// Returns the name of the scanner's state, such as `idle`.
    pub fn state(&self) -> &'static str {
        self.scanner.state()
    }

    /// Gives the shaft model the positions of the rows of scans and guard sweeps in continuous mode, so that the loop
    /// does not skip their times.
    pub fn expect_turns(&mut self) {
        let settings = &self.run.active;
        let mut guard = *settings;
        guard.config.sweep = settings.guard.sweep();
        let wire = self.run.world.borrow().module.get().wire;
        let times = wire.row_times(RadarConfig::DEFAULT.samples);
        let turns: Vec<_> = [(settings, RowWork::Scan), (&guard, RowWork::Guard)]
            .into_iter()
            .filter(|(settings, _)| settings.sweep_mode == SweepMode::Continuous)
            .filter_map(|(settings, work)| {
                let schedule = Schedule::new(&settings.config).ok()?;
                Some((Cruise::new(settings, &schedule, times, work)?, schedule))
            })
            .collect();
        self.run.world.borrow_mut().shaft.expect_turns(&turns);
    }

    /// Runs one pass of the loop, checks its output, and goes on to the next event.
    fn pass(&mut self) {
        self.drive();
        if self.run.defect.is_some() && self.now() > DEFECT_AT_US {
            self.break_down();
        }
        let (seen, clock) = {
            let world = &mut *self.run.world.borrow_mut();
            world.touched = false;
            let mut module = world.module.get();
            (module.now, module.touched) = (world.now, false);
            drop(module);
            (world.now, world.clock())
        };
        self.scanner.step(clock);
        {
            let world = &mut *self.run.world.borrow_mut();
            world.touched |= world.module.get().touched;
            world.pass_flash_time();
            world.now += std::mem::take(&mut world.busy_us);
        }
        self.attend();
        self.read();
        self.advance(seen);
    }

    /// Applies the run's defect, and removes it from the run.
    fn break_down(&mut self) {
        let world = &mut *self.run.world.borrow_mut();
        match self.run.defect {
            Some(Defect::ClockJumps) => world.clock_error = JUMP_US,
            Some(Defect::ByteChanges) => match world.port.device.last_mut() {
                Some(byte) => *byte ^= 1,
                None => return,
            },
            Some(Defect::LoopHangs) => world.now += HANG_US,
            Some(Defect::ModuleSilent) => world.module.get().silent = true,
            None => return,
        }
        self.run.defect = None;
    }

    /// Lets the chair's controller send its sentences up to now.
    fn drive(&mut self) {
        let now = self.now();
        while self.run.controller.next <= now {
            let at = self.run.controller.next;
            let (line, restart) = self.run.controller.tick();
            if restart {
                self.motion_disturbed(at);
            }
            if let Some(line) = line {
                let world = &mut *self.run.world.borrow_mut();
                world.port.wires.type_in(at, line.as_bytes());
            }
        }
    }

    /// Notes that motion sentences are missing or their travel jumps up to `until`, µs of the run.
    pub fn motion_disturbed(&mut self, until: u64) {
        self.run.motion_from = self.run.motion_from.max(until);
        self.run.watch.motion_disturbed(until);
    }

    /// Checks the scanner's deadline and the watchdog's timeout, and resets the watchdog's counter as the image's loop
    /// does.
    fn attend(&mut self) {
        let instant = self.run.instant();
        let erasure = std::mem::take(&mut self.run.world.borrow_mut().erased);
        if erasure {
            self.run.watch.blocked(instant);
            // Sentences that have arrived meanwhile are read at once.
            self.motion_disturbed(instant.at + WATCHDOG_PAUSE_US);
        }
        let healthy = self.scanner.healthy(self.run.world.borrow().clock());
        if !healthy && !erasure {
            let message = format!("deadline missed in {}", self.scanner.state());
            self.run.watch.fail(instant, &message, "none");
        }
        if instant.at - self.fed > WATCHDOG_US {
            self.run.watch.fail(instant, "the watchdog resets", "none");
            self.fed = instant.at;
        }
        if healthy && instant.at - self.fed >= WATCHDOG_PAUSE_US {
            self.fed = instant.at;
        }
        self.run.watch.pass(instant);
    }

    /// Checks the complete lines that the scanner has sent, and records the failed checks of the data path.
    fn read(&mut self) {
        let instant = self.run.instant();
        let (printed, failed, heard, booted) = {
            let world = &mut *self.run.world.borrow_mut();
            let failed = std::mem::take(&mut world.failed);
            let printed = world.port.take_lines();
            (printed, failed, world.heard, world.booted)
        };
        for message in failed {
            self.run.watch.fail(instant, &message, "none");
        }
        let from = self.run.motion_from;
        let input = |queued: u64| expected_input(&heard, booted, booted + queued, from);
        for line in &printed {
            let answered = *self.answered.borrow();
            self.run.watch.hear(instant, line, answered, input);
        }
    }

    /// Advances the time: by one pass of the loop while something happens, else to the next event after `seen`, the
    /// time at which the pass began.
    fn advance(&mut self, seen: u64) {
        let skip = match self.scanner.state() {
            "idle" => SKIP_IDLE_US,
            "scanning" | "guarding" if self.run.active.sweep_mode == SweepMode::Continuous => {
                SKIP_TURN_US
            }
            _ => SKIP_US,
        };
        let world = &mut *self.run.world.borrow_mut();
        let before = world.clock().0;
        while self.live + self.late <= world.now {
            self.live += LIVE_US;
            self.late = world.jitter(2_500);
        }
        world.now = if world.touched {
            world.now + 8 + world.jitter(24)
        } else {
            let skip = world.now + skip / 3 + world.jitter(2 * skip / 3);
            let own = self.run.controller.next.min(self.live + self.late);
            let next = world.next_event(seen).min(own);
            // The loop comes to an event within one pass.
            skip.min(next + world.jitter(15)).max(world.now + 1)
        };
        self.run.wraps += u64::from(world.clock().0 < before);
    }

    /// Runs the loop until `time`, µs of the run.
    pub fn run_until(&mut self, time: u64) {
        while self.now() < time {
            self.pass();
        }
    }

    /// Runs the loop until `done` returns `true`, for `us` microseconds at most; returns whether it did.
    pub fn run_for(&mut self, us: u64, mut done: impl FnMut(&Self) -> bool) -> bool {
        let end = self.now() + us;
        while self.now() < end {
            self.pass();
            if done(self) {
                return true;
            }
        }
        false
    }

    /// Sends the scanner a framed command without waiting for its reply.
    pub fn send(&mut self, words: &[&str]) {
        let now = self.now();
        let world = &mut *self.run.world.borrow_mut();
        world.port.wires.type_in(now, framed(words).as_bytes());
    }

    /// Sends a command and waits for its reply; returns whether it was executed.
    ///
    /// # Errors
    /// No reply comes.
    pub fn command(&mut self, words: &[&str]) -> Result<bool> {
        self.run.watch.replies.clear();
        self.send(words);
        let mut answer = None;
        let replied = self.run_for(REPLY_US, |life| {
            let replies = &life.run.watch.replies;
            answer = replies.iter().find_map(|line| reply(words, line));
            answer.is_some()
        });
        if !replied {
            let instant = self.run.instant();
            bail!("{instant}: {}: no reply", words.join(","));
        }
        Ok(answer == Some(true))
    }
}

/// Returns whether the command `words` was executed, if `line` is the last line of its reply; else `None`.
fn reply(words: &[&str], line: &str) -> Option<bool> {
    match (Sentence::parse(line).ok()?, words) {
        (Sentence::Done { command }, _) if command == words[0] => Some(true),
        (Sentence::Fail { command, .. }, _) if command == words[0] => Some(false),
        (Sentence::Config { key, .. }, ["get" | "set", wanted, ..]) if key == *wanted => Some(true),
        (Sentence::Config { key: "version", .. }, ["version"]) => Some(true),
        (Sentence::State { .. }, ["status"]) => Some(true),
        _ => None,
    }
}

/// Returns the state of the motion input that `LIVE` should report at time `at`, from the times `heard` of the last
/// motion sentences, which are undisturbed from `from` on; all times are µs of the run.
fn expected_input(heard: &[u64; 4], booted: u64, at: u64, from: u64) -> ExpectedInput {
    /// Tolerance of a time between motion sentences, µs: the rounding of the times in `LIVE`, and a pass of the loop.
    const TOLERANCE_US: u64 = 2_000;
    let timeout = u64::from(MAX_AGE_US);
    let mut times = heard.iter().rev().filter(|&&time| time <= at + 1_000);
    let fits =
        |(later, earlier): (u64, u64)| later.saturating_sub(earlier) + TOLERANCE_US <= timeout;
    match (times.next(), times.next(), times.next()) {
        (Some(&last), _, _) if last <= booted || at > last + timeout + TOLERANCE_US => {
            ExpectedInput::Stale
        }
        (Some(&a), Some(&b), Some(&c))
            if c > booted.max(from) && [(at, a), (a, b), (b, c)].into_iter().all(fits) =>
        {
            ExpectedInput::Good
        }
        _ => ExpectedInput::Any,
    }
}
