//! Commands: lines of the report port, carried out one by one.

use super::states::{Errand, Machine};
use crate::report::command::{self, Command, Input, LineReader};
use crate::scan::board::{Board, BytePort};
use crate::scan::chain::DataPath;
use crate::scan::link::RadarLink;
use crate::scan::mirror::Mirror;
use crate::scan::settings::{self, Settings};
use crate::scan::time::Micros;

/// The line that comes in over the report port, and the list that goes out.
#[derive(Debug, Default)]
pub(super) struct Console {
    reader: LineReader,
    /// Next key that `get` lists.
    listing: Option<usize>,
}

impl Console {
    /// Carries out what has been typed, and hands the port what there is to say.
    pub(super) fn step<M: Mirror, L: RadarLink, P: BytePort, B: Board, D: DataPath>(
        &mut self,
        now: Micros,
        machine: &mut Machine<'_, M, L, P, B, D>,
    ) {
        self.list(machine);
        self.read(now, machine);
        machine.reports.pump(&mut machine.hardware.port);
    }

    /// Reads at most one line, and only when its answer has room.
    fn read<M: Mirror, L: RadarLink, P: BytePort, B: Board, D: DataPath>(
        &mut self,
        now: Micros,
        machine: &mut Machine<'_, M, L, P, B, D>,
    ) {
        while self.listing.is_none() && machine.reports.has_room() {
            let Some(byte) = machine.hardware.port.read() else {
                return;
            };
            match self.reader.push(byte) {
                Input::Partial => {}
                Input::Line => return self.execute(now, machine),
                Input::Bad(error) => {
                    return machine.reports.refuse("-", error.field, error.expected);
                }
            }
        }
    }

    // Out of line for the stack, as in `states`.
    #[inline(never)]
    fn execute<M: Mirror, L: RadarLink, P: BytePort, B: Board, D: DataPath>(
        &mut self,
        now: Micros,
        machine: &mut Machine<'_, M, L, P, B, D>,
    ) {
        let parsed = match command::parse(self.reader.line()) {
            Ok(command) => command,
            Err(bad) => {
                let error = bad.error;
                return machine
                    .reports
                    .refuse(bad.command, error.field, error.expected);
            }
        };
        match parsed {
            Command::Start => machine.start(now),
            Command::Stop => machine.stop(),
            Command::Scan => machine.errand(now, "scan", Errand::Once),
            Command::SelfTest => machine.errand(now, "selftest", Errand::Answer),
            Command::Status => {
                let status = machine.status();
                machine.reports.status(&status);
            }
            Command::Version => machine.reports.version(&machine.identity),
            Command::GetAll => self.listing = Some(0),
            Command::Get(key) => tell_setting(machine, key),
            Command::Set(key, value) => match machine.settings.set(key, value) {
                Ok(()) => tell_setting(machine, key),
                Err(error) => machine.reports.refuse("set", error.field, error.expected),
            },
            Command::Measure(measure) => {
                let value = settings::number(i64::from(machine.hardware.board.measure(measure)));
                machine.reports.value(measure.key(), &value);
            }
        }
    }

    /// One more sentence of `get`'s list.
    #[inline(never)]
    fn list<M, L, P, B, D>(&mut self, machine: &mut Machine<'_, M, L, P, B, D>) {
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

fn tell_setting<M, L, P, B, D>(machine: &mut Machine<'_, M, L, P, B, D>, key: &str) {
    let value = machine.settings.get(key).unwrap_or_default();
    machine.reports.value(key, &value);
}
