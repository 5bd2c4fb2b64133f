//! The simulated hardware around one scanner, on one clock, and its handle, which implements the scanner's hardware
//! traits.

use std::cell::RefCell;
use std::rc::Rc;
use std::task::Poll;

use stairscan::Iq;
use stairscan::config::RadarConfig;
use stairscan::scanner::command::Measure;
use stairscan::scanner::mirror::{PulseState, StepPort};
use stairscan::scanner::ramp::Ramp;
use stairscan::scanner::store::{Store, StoreError};
use stairscan::scanner::{Board, BytePort, Micros, Settings};
use stairscan::signal::radar::module::RequestedSettings;
use stairscan::signal::radar::wire::RowTimes;
use stairscan::signal::radar::{LinkError, RadarModule};
use testbed::{Flash, Port, Power};

use super::gaps::{Instant, SPAN_US};
use super::module::ModuleModel;
use super::shaft::ShaftModel;

/// Size of a sector, bytes: sectors 1 and 2 of the STM32F405 (RM0090, table 5).
pub const SECTOR: usize = 16 * 1024;
/// Number of erasures that a sector endures (STM32F405 datasheet DS8626, flash memory endurance: at least 10 kcycles).
pub const ENDURANCE: u64 = 10_000;
/// Minimum and maximum duration of erasing a sector, µs (DS8626, table 42: 250 ms typical, 500 ms at most, 32 bits at a
/// time).
const ERASE_US: [u64; 2] = [250_000, 500_000];
/// Duration of writing a word, µs (DS8626, table 42: 16 typical).
const WORD_US: u64 = 16;

/// Bit rate of the report port, baud.
const REPORT_BAUD: u32 = 115_200;
/// Maximum time for which bytes have left since the loop's last pass, µs. The chip's loop passes every few
/// microseconds; here it skips time up to this, and while it is blocked nothing is handed to the port.
const SKIPPED_US: u64 = 3_000;

/// Returns the report port, on a clock in µs.
fn report_port() -> Port {
    let mut port = Port::default();
    port.wires.ticks = Some(1_000_000);
    port.wires.rates = [REPORT_BAUD; 2];
    port.wires.skipped = SKIPPED_US;
    port
}

/// State that the board retains over a reset.
#[derive(Clone, Copy, Debug, Default)]
pub struct Retained {
    /// Whether `stop` was the last of `start` and `stop`.
    pub stopped: bool,
    /// Hash of the settings in force; `None` before it is retained first.
    pub settings: Option<u32>,
    /// Number of boots since power-up.
    pub boots: u32,
}

/// Simulated hardware and clock around the scanner.
#[derive(Debug)]
pub struct World {
    /// Time since the beginning of the run, µs.
    pub now: u64,
    /// Time of the last reset, µs of the run; the scanner's clock counts from it.
    pub booted: u64,
    /// Error of the scanner's clock, µs, by a test's defect; else 0.
    pub clock_error: u32,
    /// Time for which the present pass of the loop is blocked by processing or flash, µs.
    pub busy_us: u64,
    /// Whether the present pass has changed anything, so that the next one follows at once.
    pub touched: bool,
    /// Times at which the last four motion sentences were read, µs of the run, the newest last.
    pub heard: [u64; 4],
    /// The mirror's motor and shaft.
    pub shaft: ShaftModel,
    /// The radar module.
    pub module: ModuleModel,
    /// The report port at 115,200 baud: command lines arrive at given times, and sent bytes leave one after the other.
    pub port: Port,
    /// Bytes of the incoming line that the scanner has read.
    line: Vec<u8>,
    /// Flash with the settings.
    pub flash: Flash<SECTOR>,
    /// Whether a sector has been erased in the present pass of the scanner's loop; the erasure blocks that pass.
    pub erased: bool,
    /// State that survives a reset.
    pub retained: Retained,
    /// Texts of the data path's failed checks that have not been recorded yet.
    pub failed: Vec<String>,
    state: u64,
}

impl World {
    /// Creates the hardware before its first boot; `seed` selects the random delays.
    pub fn new(seed: u64) -> Self {
        Self {
            now: 0,
            booted: 0,
            clock_error: 0,
            busy_us: 0,
            touched: false,
            heard: [0; 4],
            shaft: ShaftModel::new(),
            module: ModuleModel::default(),
            port: report_port(),
            line: Vec::new(),
            flash: Flash {
                counts_misuse: true,
                ..Flash::new(2, &Power::new(seed))
            },
            erased: false,
            retained: Retained::default(),
            failed: Vec::new(),
            state: seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1,
        }
    }

    /// Returns the reading of the scanner's clock, with its error.
    pub fn clock(&self) -> Micros {
        Micros((self.now - self.booted) as u32).plus(self.clock_error)
    }

    /// Returns the present time of the run, with the scanner's clock.
    pub fn instant(&self) -> Instant {
        Instant {
            at: self.now,
            clock: self.clock().0,
            wrapped: self.now - self.booted >= SPAN_US,
        }
    }

    /// Returns a random integer from 0 to below `end` (xorshift64, since it is drawn every pass).
    pub fn jitter(&mut self, end: u64) -> u64 {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 7;
        self.state ^= self.state << 17;
        (self.state >> 20) % end
    }

    /// Returns the first time after `seen` at which module, report wire or shaft have an event, µs of the run.
    pub fn next_event(&mut self, seen: u64) -> u64 {
        let module = self.module.next_event(seen).min(self.next_port_event(seen));
        self.shaft.next_event(seen).min(module)
    }

    /// Returns the first time after `seen` at which a line arrives at the report port, or bytes that did not fit can be
    /// written, µs of the run.
    fn next_port_event(&self, seen: u64) -> u64 {
        let wires = &self.port.wires;
        let arrival = wires.incoming.front().map(|byte| byte.at);
        let arrives = arrival.filter(|&at| at > seen).unwrap_or(u64::MAX);
        let leaves = match wires.waiting {
            true => wires.busy_until() + SKIPPED_US / 2,
            false => u64::MAX,
        };
        arrives.min(leaves)
    }

    /// Returns the next byte of a line that has arrived at the report port, and notes when a motion sentence has been
    /// read.
    fn read(&mut self) -> Option<u8> {
        self.port.wires.now = self.now;
        let byte = self.port.read()?;
        self.touched = true;
        self.line.push(byte);
        if byte == b'\n' {
            if self
                .line
                .starts_with(stairscan::report::motion::PREFIX.as_bytes())
            {
                self.heard.rotate_left(1);
                self.heard[3] = self.now;
            }
            self.line.clear();
        }
        Some(byte)
    }

    /// Saves `settings`, and blocks the present pass for as long as the flash takes.
    fn save(&mut self, settings: &Settings) -> Result<(), StoreError> {
        let (erasures, words) = (self.erasures(), self.flash.words);
        let saved = Store::new(&mut self.flash).save(settings);
        for _ in erasures..self.erasures() {
            let unit = self.jitter(1_000) as f64 * 1e-3;
            let [least, most] = ERASE_US;
            self.busy_us += least + ((most - least) as f64 * unit) as u64;
            self.erased = true;
        }
        self.busy_us += WORD_US * (self.flash.words - words);
        saved
    }

    fn erasures(&self) -> u64 {
        self.flash.erasures.iter().sum()
    }

    fn deadline(&self, now: Micros, timeout_us: u32) -> (Micros, u64) {
        (now.plus(timeout_us), self.now + u64::from(timeout_us))
    }
}

/// Handle of the world that implements the scanner's hardware traits.
#[derive(Clone, Debug)]
pub struct Handle(pub Rc<RefCell<World>>);

impl StepPort for Handle {
    fn begin(&mut self, target: i32, ramp: Ramp, until_home: bool) {
        let world = &mut *self.0.borrow_mut();
        world.touched = true;
        world.shaft.begin(world.now, target, ramp, until_home);
    }

    fn state(&mut self) -> PulseState {
        let world = &mut *self.0.borrow_mut();
        world.shaft.state(world.now)
    }

    fn home_pressed(&mut self) -> bool {
        let world = self.0.borrow();
        world.shaft.pressed(world.now)
    }

    fn set_position(&mut self, position: i32) {
        self.0.borrow_mut().shaft.set_position(position);
    }

    fn set_enabled(&mut self, on: bool) {
        let world = &mut *self.0.borrow_mut();
        world.shaft.set_enabled(world.now, on);
    }
}

impl RadarModule for Handle {
    fn program(&mut self, now: Micros, _: &RequestedSettings, timeout_us: u32) {
        let world = &mut *self.0.borrow_mut();
        let deadline = world.deadline(now, timeout_us);
        world.module.program(world.now, deadline);
    }

    fn settings(&mut self, now: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        let world = &mut *self.0.borrow_mut();
        let answer = world.module.settings(world.now, now);
        world.touched |= answer.is_ready();
        answer
    }

    fn trigger(&mut self, now: Micros, _: i32, timeout_us: u32) {
        let world = &mut *self.0.borrow_mut();
        let deadline = world.deadline(now, timeout_us);
        world.module.trigger(world.now, deadline, false);
    }

    fn trigger_ahead(&mut self, now: Micros, _: i32, timeout_us: u32) -> bool {
        let world = &mut *self.0.borrow_mut();
        let deadline = world.deadline(now, timeout_us);
        world.module.trigger(world.now, deadline, true)
    }

    fn poll(&mut self, now: Micros, _: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        let world = &mut *self.0.borrow_mut();
        let answer = world.module.poll(world.now, now);
        world.touched |= answer.is_ready();
        answer
    }

    fn row_times(&self, samples: u16) -> Option<RowTimes> {
        Some(ModuleModel::row_times(samples))
    }
}

impl BytePort for Handle {
    fn read(&mut self) -> Option<u8> {
        self.0.borrow_mut().read()
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        let world = &mut *self.0.borrow_mut();
        world.port.wires.now = world.now;
        world.port.write(bytes)
    }
}

impl Board for Handle {
    fn stopped(&self) -> bool {
        self.0.borrow().retained.stopped
    }

    fn set_stopped(&mut self, stopped: bool) {
        self.0.borrow_mut().retained.stopped = stopped;
    }

    fn retained_settings_hash(&self) -> Option<u32> {
        self.0.borrow().retained.settings
    }

    fn retain_settings_hash(&mut self, hash: u32) {
        self.0.borrow_mut().retained.settings = Some(hash);
    }

    fn save(&mut self, settings: &Settings) -> Result<(), StoreError> {
        self.0.borrow_mut().save(settings)
    }

    fn clear_crashes(&mut self) {}

    fn measure(&self, _: Measure) -> u32 {
        0
    }
}
