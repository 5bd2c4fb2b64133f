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
//! A fault leaves the motor's driver off, and so does `stop`. After `fault-hold` the self-test homes the
//! mirror and asks the module again; nothing has to be reset by hand. Only after crashes that followed
//! one another the scanner stands still until `start`, `scan` or `selftest`.
//!
//! | file | what it does | over |
//! |---|---|---|
//! | `keeper` | the settings in force: who vouches for them, whether memory still holds them | [`super::record`] |
//! | `fitness` | whether processor, memory, clock and supply are fit to scan | |
//! | `reports` | which sentences tell a scan, a state, an answer | [`super::outbox`] |
//! | `pulse` | when `LIVE` is due, and its times | [`super::time`] |
//! | `states` | the machine above: what is under way, and until when | `keeper`, `reports`, [`super::sweep`] |
//! | `calibrating` | a scan of a floor and a wall becomes settings | `states`, [`crate::mount::command`] |
//! | `commands` | lines of the report port, carried out on the machine; `LIVE` | `states`, `reports`, `pulse` |

mod calibrating;
mod commands;
mod fitness;
mod keeper;
mod pulse;
mod reports;
mod states;

pub use reports::Reports;

use crate::motion::{Drive, Odometry};
use crate::scan::board::{Board, BytePort, Hardware, Identity};
use crate::scan::chain::DataPath;
use crate::scan::mirror::Mirror;
use crate::scan::settings::Settings;
use crate::scan::time::Micros;
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
