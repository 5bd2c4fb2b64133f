//! The scanner: mirror motor, settings, and the state machine that ties them to the stages.
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
//! While the scanner guards, `guarding` takes the place of `scanning`: guard sweeps follow each other, and `scan` puts a
//! full scan between two of them.
//!
//! It is polled: [`Scanner::step`] never waits, so that a command is answered during a scan, the watchdog
//! sees every state's own deadline, and a chirp is on the wire and worked off while the mirror moves to the
//! next angle. Hardware comes in behind four narrow traits ([`Mirror`],
//! [`RadarModule`], [`BytePort`], [`Board`]) and time as an argument, so the code that scans on the chip is
//! the code that runs in the emulator and behind `replay`.
//!
//! A fault leaves the motor's driver off, and so does `stop`. After `fault-hold` the self-test homes the
//! mirror and asks the module again; nothing has to be reset by hand. Only after crashes that followed
//! one another the scanner stands still until `start`, `scan` or `selftest`.
//!
//! | the machine | what it does | over |
//! |---|---|---|
//! | `states` | the machine above: what is under way, and until when | `keeper`, `reports`, [`sweep`] |
//! | `commands` | lines of the report port, carried out on the machine; `LIVE` | `states`, `reports`, `pulse` |
//! | `calibrating` | a scan of a floor and a wall becomes settings | `states`, [`crate::mount::command`] |
//! | `keeper` | the settings in force: who vouches for them, whether memory still holds them | [`record`] |
//! | `guarding` | guard sweeps, and full scans in between | `states`, `guard` |
//! | `guard` | the guard between two sweeps, and whether settings allow one | [`pace`] |
//! | `planes` | which plane a scan is made in, with `plane both` | [`crate::drive`], [`crate::verdict`] |
//! | `fitness` | whether processor, memory, clock and supply are fit to scan | |
//! | `reports` | which sentences tell a scan, a state, an answer | [`outbox`] |
//! | `pulse` | when `LIVE` is due, and its times | [`crate::time`] |
//!
//! | its parts | what they do |
//! |---|---|
//! | [`settings`] | configuration, time-outs and motor data, by key |
//! | [`record`] | settings as text: their hash, and what a record of them holds |
//! | [`seal`] | a checksum over the whole image |
//! | [`handover`] | what boot loader and image tell each other over a reset |
//! | [`store`] | settings that outlive the power: records in two sectors of flash |
//! | [`mirror`] | the mirror as the sweep sees it; homing over any step generator |
//! | [`driver`] | the motor's driver as the mirror sees it |
//! | [`tmc2209`] | that driver's wire and registers |
//! | [`encoder`] | an absolute encoder on the mirror's shaft: AS5600 over I²C |
//! | [`ramp`] | acceleration-limited moves: the time from one step to the next |
//! | [`pulser`] | STEP/DIR/EN over embedded-hal pins |
//! | [`board`] | what survives a reset, who the firmware is |
//! | [`command`] | lines of the report port → commands, checked against the settings' keys |
//! | [`chain`] | the data's way: samples, map, estimator |
//! | [`pace`] | how fast a mirror that does not stop may turn |
//! | [`sweep`] | one scan: move, settle, trigger, receive, retry; or all rows in passing |
//! | [`outbox`] | sentences on their way out |

pub mod board;
mod calibrating;
pub mod chain;
pub mod command;
mod commands;
pub mod driver;
pub mod encoder;
mod fitness;
mod guard;
mod guarding;
pub mod handover;
mod keeper;
pub mod mirror;
pub mod outbox;
pub mod pace;
mod planes;
mod pulse;
pub mod pulser;
pub mod ramp;
pub mod record;
mod reports;
pub mod seal;
pub mod settings;
mod states;
pub mod store;
pub mod sweep;
pub mod tmc2209;

pub use crate::port::BytePort;
pub use crate::schedule::{MICROSTEPS_PER_TURN, Schedule};
pub use crate::time::Micros;
pub use board::{Board, Hardware, Identity};
pub use chain::DataPath;
pub use fitness::Fitness;
pub use mirror::{Mirror, MirrorError, Motion};
pub use reports::Reports;
pub use settings::Settings;

use crate::drive::Drive;
use crate::motion::Odometry;
use crate::signal::radar::module::RadarModule;
use commands::Console;
use states::Machine;

/// The scanner over its hardware.
///
/// Its larger parts, what it has to say ([`Reports`]) and what it is told of the chair's motion
/// ([`Odometry`]), are lent to it: a scanner on a small stack keeps them elsewhere.
#[derive(Debug)]
pub struct Scanner<'a, M, L, P, B, D> {
    machine: Machine<'a, M, L, P, B, D>,
    console: Console,
}

impl<'a, M: Mirror, L: RadarModule, P: BytePort, B: Board, D: DataPath> Scanner<'a, M, L, P, B, D> {
    /// A scanner that has just booted. `settings` are those that were saved, and must be valid; without
    /// them it begins with defaults, and no answer is `ok` before it has been told how it is mounted.
    // Out of line: what it is put together in would lie beneath the estimator for good.
    #[inline(never)]
    pub fn new(
        hardware: Hardware<M, L, P, B>,
        data: D,
        memory: (&'a mut Reports, &'a mut Odometry),
        settings: Option<Settings>,
        identity: Identity,
        now: Micros,
    ) -> Self {
        Self {
            machine: Machine::new(hardware, data, memory, settings, identity, now),
            console: Console::new(now),
        }
    }

    /// The data path: map and estimator of the last scan.
    pub fn data(&self) -> &D {
        self.machine.data()
    }

    /// What is known of the chair's motion in the last scan.
    pub fn drive(&self) -> Drive<'_> {
        self.machine.drive()
    }

    /// The serial port.
    pub fn port_mut(&mut self) -> &mut P {
        &mut self.machine.hardware.port
    }

    /// Number of scans begun since boot.
    pub fn scans(&self) -> u32 {
        self.machine.scans()
    }

    /// Number of guard sweeps begun since the guard was switched on.
    pub fn sweeps(&self) -> u32 {
        self.machine.guard.sweep
    }

    /// Name of the present state.
    pub fn state(&self) -> &'static str {
        self.machine.state()
    }

    /// Whether the present state has met its own deadline: only then may the watchdog be fed.
    pub fn healthy(&self, now: Micros) -> bool {
        self.machine.healthy(now)
    }

    /// Gets as far as it can without waiting.
    pub fn step(&mut self, now: Micros) {
        // The state first: no command comes before the boot sentence.
        self.machine.run(now);
        self.console.step(now, &mut self.machine);
    }
}
