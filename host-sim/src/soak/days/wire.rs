//! Report port at 115,200 baud: lines arrive at their times, and bytes leave one after the other.

use std::collections::VecDeque;

use stairscan::report::sentence::Line;

/// Time of a byte, µs: ten bits at 115,200 baud.
const BYTE_US: u64 = 87;
/// Maximum time for which bytes have left since the loop's last pass, µs. The chip's loop passes every few
/// microseconds; here it skips time up to this, and while it is blocked nothing is handed to the port.
const SKIPPED_US: u64 = 3_000;

/// Bytes under way in both directions.
#[derive(Debug, Default)]
pub struct ReportWire {
    incoming: VecDeque<(u64, Line)>,
    /// Number of bytes of the first line that have been read.
    read: usize,
    /// Bytes that have left.
    pub printed: Vec<u8>,
    /// Time up to which the transmitter is busy.
    busy_until: u64,
    /// Whether the last write did not take all bytes.
    waiting: bool,
}

impl ReportWire {
    /// Loses the sentence that is being sent: at a reset.
    pub fn cut(&mut self) {
        self.printed.clear();
        self.waiting = false;
    }

    /// Adds a line that arrives at `at`.
    pub fn send(&mut self, at: u64, line: Line) {
        self.incoming.push_back((at, line));
    }

    /// Whether lines are still to be read.
    pub fn pending(&self) -> bool {
        !self.incoming.is_empty()
    }

    /// Returns the next byte that has arrived, and whether it ends a motion sentence.
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

    /// Takes the bytes that have left since the last pass of the loop, and one that waits.
    pub fn write(&mut self, now: u64, bytes: &[u8]) -> usize {
        let from = self.busy_until.max(now.saturating_sub(SKIPPED_US));
        let room = ((now + 2 * BYTE_US).saturating_sub(from) / BYTE_US) as usize;
        let taken = room.min(bytes.len());
        self.busy_until = from + BYTE_US * taken as u64;
        self.printed.extend_from_slice(&bytes[..taken]);
        self.waiting = taken < bytes.len();
        taken
    }

    /// Returns the next time after `seen` at which a line arrives, or waiting bytes fit.
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
