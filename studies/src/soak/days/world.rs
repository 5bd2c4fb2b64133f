//! The simulated hardware around one scanner, on one clock, and its handle, which implements the scanner's hardware
//! traits.

use std::cell::RefCell;
use std::rc::Rc;

use stairscan::scanner::mirror::{PulseState, StepPort};
use stairscan::scanner::ramp::Ramp;
use stairscan::scanner::{BytePort, Micros};
use stairscan::signal::radar::wire::Wire;
use testbed::{Board, Module, Port, Shared};

use super::gaps::{Instant, SPAN_US};
use super::shaft::ShaftModel;

/// Number of erasures that a sector endures (STM32F405 datasheet DS8626, flash memory endurance: at least 10 kcycles).
pub const ENDURANCE: u64 = 10_000;
/// Minimum and maximum duration of erasing a sector, µs (DS8626, table 42: 250 ms typical, 500 ms at most, 32 bits at a
/// time).
const ERASE_US: [u64; 2] = [250_000, 500_000];
/// Duration of writing a word, µs (DS8626, table 42: 16 typical).
const WORD_US: u64 = 16;

/// Bit rate of the radar module's link, baud: the fastest, at which the guard reaches its sweep rate with default
/// settings.
const LINK_BAUD: u32 = 3_000_000;
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
    pub module: Shared<Module>,
    /// The report port at 115,200 baud: command lines arrive at given times, and sent bytes leave one after the other.
    pub port: Port,
    /// Bytes of the incoming line that the scanner has read.
    line: Vec<u8>,
    /// The board, with the flash of settings.
    pub board: Shared<Board>,
    /// Numbers of erasures and of words written whose time has passed.
    flash_done: [u64; 2],
    /// Whether a sector has been erased in the present pass of the scanner's loop; the erasure blocks that pass.
    pub erased: bool,
    /// Texts of the data path's failed checks that have not been recorded yet.
    pub failed: Vec<String>,
    state: u64,
}

impl World {
    /// Creates the hardware before its first boot; `seed` selects the random delays.
    pub fn new(seed: u64) -> Self {
        let mut board = Board::new(seed);
        board.flash.counts_misuse = true;
        let mut module = Module::new(());
        module.wire = Wire {
            baud: LINK_BAUD,
            ahead: true,
            pin: false,
        };
        module.takes_time = true;
        Self {
            now: 0,
            booted: 0,
            clock_error: 0,
            busy_us: 0,
            touched: false,
            heard: [0; 4],
            shaft: ShaftModel::new(),
            module: Shared::new(module),
            port: report_port(),
            line: Vec::new(),
            board: Shared::new(board),
            flash_done: [0; 2],
            erased: false,
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
        let module = self
            .module
            .get()
            .next_event(seen)
            .min(self.next_port_event(seen));
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

    /// Blocks the present pass for as long as the flash has taken since the last call.
    pub fn pass_flash_time(&mut self) {
        let (erasures, words) = {
            let flash = &self.board.get().flash;
            (flash.erasures.iter().sum(), flash.words)
        };
        let [erasures_before, words_before] =
            std::mem::replace(&mut self.flash_done, [erasures, words]);
        for _ in erasures_before..erasures {
            let unit = self.jitter(1_000) as f64 * 1e-3;
            let [least, most] = ERASE_US;
            self.busy_us += least + ((most - least) as f64 * unit) as u64;
            self.erased = true;
        }
        self.busy_us += WORD_US * (words - words_before);
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
