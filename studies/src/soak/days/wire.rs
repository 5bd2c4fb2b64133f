//! Wire of the report port at 115,200 baud: command lines arrive at given times, and sent bytes leave one after the
//! other.

use std::collections::VecDeque;

use stairscan::report::sentence::Line;

/// Time of a byte, µs: ten bits at 115,200 baud.
const BYTE_US: u64 = 87;
/// Maximum time for which bytes have left since the loop's last pass, µs. The chip's loop passes every few
/// microseconds; here it skips time up to this, and while it is blocked nothing is handed to the port.
const SKIPPED_US: u64 = 3_000;

/// Bytes under way on the report port's wire in both directions.
#[derive(Debug, Default)]
pub struct ReportWire {
    incoming: VecDeque<(u64, Line)>,
    /// Number of bytes of the first incoming line that the scanner has read.
    read: usize,
    /// Bytes that the scanner has sent and the checks have not taken yet.
    pub printed: Vec<u8>,
    /// Time up to which the transmitter is busy, µs of the run.
    busy_until: u64,
    /// Whether the scanner's last write did not fit completely.
    waiting: bool,
}

impl ReportWire {
    /// Discards the sent bytes that the checks have not taken, at a reset of the scanner.
    pub fn cut(&mut self) {
        self.printed.clear();
        self.waiting = false;
    }

    /// Adds a line that arrives at time `at`, µs of the run.
    pub fn send(&mut self, at: u64, line: Line) {
        self.incoming.push_back((at, line));
    }

    /// Whether the scanner has still to read a line, arrived or not.
    pub fn pending(&self) -> bool {
        !self.incoming.is_empty()
    }

    /// Returns the next byte if its line has arrived by `now`, and whether it ends a motion sentence.
    pub fn read(&mut self, now: u64) -> Option<(u8, bool)> {
        let (at, line) = self.incoming.front()?;
        if *at > now {
            return None;
        }
        let byte = *line.as_bytes().get(self.read)?;
        self.read += 1;
        let mut ended = false;
        if self.read == line.len() {
            ended = line.starts_with(stairscan::report::motion::PREFIX);
            self.incoming.pop_front();
            self.read = 0;
        }
        Some((byte, ended))
    }

    /// Takes as many of `bytes` as have left since the last pass of the loop, and one that waits; returns their number.
    pub fn write(&mut self, now: u64, bytes: &[u8]) -> usize {
        let from = self.busy_until.max(now.saturating_sub(SKIPPED_US));
        let room = ((now + 2 * BYTE_US).saturating_sub(from) / BYTE_US) as usize;
        let taken = room.min(bytes.len());
        self.busy_until = from + BYTE_US * taken as u64;
        self.printed.extend_from_slice(&bytes[..taken]);
        self.waiting = taken < bytes.len();
        taken
    }

    /// Returns the first time after `seen` at which a line arrives, or bytes that did not fit can be written, µs of the
    /// run.
    pub fn next_event(&self, seen: u64) -> u64 {
        let arrivals = self.incoming.front().map(|(at, _)| *at);
        let arrives = arrivals.filter(|&at| at > seen).unwrap_or(u64::MAX);
        let leaves = if self.waiting {
            self.busy_until + SKIPPED_US / 2
        } else {
            u64::MAX
        };
        arrives.min(leaves)
    }
}
