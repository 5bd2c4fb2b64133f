//! The scanner: mirror motor, settings, and the state machine that connects them to the data path.
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
//! While the scanner guards, `guarding` replaces `scanning`: guard sweeps follow each other, and `scan` inserts
//! a full scan between two of them.
//!
//! The scanner is polled: [`Scanner::step`] never waits. So a command is answered during a scan, the watchdog
//! sees the deadline of every state, and a chirp is transmitted and processed while the mirror moves to the
//! next angle. The hardware is behind four narrow traits ([`Mirror`], [`RadarModule`], [`BytePort`], [`Board`])
//! and the time is an argument, so the code that scans on the chip is the code that runs in the emulator and
//! behind `replay`.
//!
//! A fault switches the motor driver off, and so does `stop`. After `fault-hold` the self-test homes the mirror
//! and queries the module again; no manual reset is needed. Only after a series of crashes the scanner stays
//! idle until `start`, `scan` or `selftest`.
//!
//! | module of the state machine | purpose | uses |
//! |---|---|---|
//! | `states` | the state machine above: the current activity and its deadline | `keeper`, `reports`, [`sweep`] |
//! | `commands` | executes the commands of the report port; `LIVE` | `states`, `reports`, `pulse` |
//! | `calibrating` | turns a scan of a floor and a wall into settings | `states`, [`crate::mount::command`] |
//! | `keeper` | the settings in force: whether they were configured, and whether memory still holds them | [`record`] |
//! | `guarding` | guard sweeps, and full scans in between | `states`, `guard` |
//! | `guard` | guard state between two sweeps, and whether the settings allow a guard | [`pace`] |
//! | `planes` | plane of each scan, with `plane both` | [`crate::drive`], [`crate::verdict`] |
//! | `fitness` | whether processor, memory, clock and supply are fit to scan | |
//! | `reports` | sentences that report a scan, a state, an answer | [`outbox`] |
//! | `pulse` | due time of `LIVE`, and the times that it reports | [`crate::time`] |
//!
//! | other module | purpose |
//! |---|---|
//! | [`settings`] | configuration, timeouts and motor data, by key |
//! | [`record`] | settings as 32-bit words: hash, checksum and layout of a record |
//! | [`seal`] | a checksum over the whole image |
//! | [`handover`] | words that boot loader and image exchange over a reset |
//! | [`option_bytes`] | the chip's brown-out reset and protections |
//! | [`store`] | non-volatile settings: records in two sectors of flash |
//! | [`mirror`] | the mirror as the sweep sees it; homing over any step generator |
//! | [`shaft`] | a mirror shaft without a motor |
//! | [`driver`] | the motor driver as the mirror sees it |
//! | [`tmc2209`] | UART and registers of the TMC2209 motor driver |
//! | [`encoder`] | an absolute encoder on the mirror's shaft: AS5600 over I²C |
//! | [`ramp`] | acceleration-limited moves: the time from one step to the next |
//! | [`pulser`] | STEP/DIR/EN over embedded-hal pins |
//! | [`step_timer`] | the timer's next interrupt, less the time that the last one took |
//! | [`board`] | state that survives a reset, identity of the firmware |
//! | [`command`] | lines of the report port → commands, checked against the settings' keys |
//! | [`chain`] | the data path: samples, map, estimator |
//! | [`pace`] | maximum speed of a mirror that does not stop |
//! | [`sweep`] | one scan: move, settle, trigger, receive, retry; or all rows in passing |
//! | [`outbox`] | queue of outgoing sentences |
//! | [`rest`] | whether the loop may sleep until an interrupt |
//! | [`resets`] | number of resets in a row, which boot loader and image exchange |

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
pub mod option_bytes;
pub mod outbox;
pub mod pace;
mod parts;
mod planes;
mod pulse;
pub mod pulser;
pub mod ramp;
pub mod record;
mod reports;
pub mod resets;
pub mod rest;
pub mod seal;
pub mod settings;
pub mod shaft;
mod states;
pub mod step_timer;
pub mod store;
pub mod sweep;
pub mod tmc2209;

pub use crate::port::BytePort;
pub use crate::schedule::{MICROSTEPS_PER_TURN, Schedule};
pub use crate::time::Micros;
pub use board::{Board, BootInfo, SecondMemory};
pub use chain::DataPath;
pub use fitness::BoardHealth;
pub use mirror::{Mirror, MirrorError, Motion};
pub use parts::{Hardware, LentParts, Parts};
pub use reports::Reports;
use rest::Rest;
pub use settings::Settings;

use crate::drive::Drive;
use crate::signal::radar::module::RadarModule;
use commands::Console;
use states::Machine;

/// The scanner: its state machine and the commands of the report port, over its hardware.
pub struct Scanner<'a, H: Parts> {
    machine: Machine<'a, H>,
    console: Console,
}

impl<'a, M: Mirror, L: RadarModule, P: BytePort, B: Board, D: DataPath>
    Scanner<'a, (Hardware<M, L, P, B>, D)>
{
    /// Creates a scanner that has just booted. `settings` are those that were saved, and must be valid. With
    /// `None` it begins with defaults, and no answer is `ok` before the mounting has been set.
    // Out of line: its temporaries would otherwise stay on the stack beneath the estimator.
    #[inline(never)]
    pub fn new(
        hardware: Hardware<M, L, P, B>,
        data: D,
        lent: LentParts<'a>,
        settings: Option<Settings>,
        identity: BootInfo,
        now: Micros,
    ) -> Self {
        Self {
            machine: Machine::new(hardware, data, lent, settings, identity, now),
            console: Console::new(now),
        }
    }
}

impl<H: Parts> Scanner<'_, H> {
    /// Returns the data path: map and estimator of the last scan.
    pub fn data(&self) -> &H::Data {
        self.machine.data()
    }

    /// Returns the chair's motion during the last scan, as far as it is known.
    pub fn drive(&self) -> Drive<'_> {
        self.machine.drive()
    }

    /// Returns the report port.
    pub fn port_mut(&mut self) -> &mut H::Port {
        &mut self.machine.hardware.port
    }

    /// Returns the number of scans begun since boot.
    pub fn scans(&self) -> u32 {
        self.machine.scans()
    }

    /// Returns the number of guard sweeps begun since the guard was switched on.
    pub fn sweeps(&self) -> u32 {
        self.machine.guard.sweep
    }

    /// Returns the name of the scanner's current state, such as `idle` or `scanning`.
    pub fn state(&self) -> &'static str {
        self.machine.state()
    }

    /// Whether the current state is within its deadline: only then may the watchdog be fed.
    pub fn healthy(&self, now: Micros) -> bool {
        self.machine.healthy(now)
    }

    /// Returns how long the next step may wait if no interrupt comes, as of the last [`Scanner::step`].
    pub fn rest(&self, now: Micros) -> Rest {
        self.machine.rest(now).min(self.console.rest(&self.machine))
    }

    /// Advances state machine and commands as far as possible without waiting.
    pub fn step(&mut self, now: Micros) {
        // The state first: the boot sentence precedes any command's answer.
        self.machine.run(now);
        self.console.step(now, &mut self.machine);
    }
}
