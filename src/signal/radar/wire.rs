//! The wire between scanner and module: how long what takes on it.

/// Rate that every module begins with: both clocks of the board divide to it exactly.
pub const LINK_BAUD: u32 = 1_000_000;
/// Bytes of a frame before its payload.
pub const HEADER: usize = 8;
/// Bytes after it.
pub const TRAILER: usize = 4;

/// Bits of a byte on the wire: start, eight, stop.
const BITS: u32 = 10;
/// Bytes of a trigger.
const TRIGGER: u32 = (HEADER + 4 + TRAILER) as u32;
/// From a trigger's last byte, or its edge, until the module sweeps, and by how much its sweep may be longer
/// than the scanner was told, microseconds.
pub const SLACK_US: u32 = 100;

/// Times of a row whose chirp is triggered while the mirror turns, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowTimes {
    /// From the trigger's call until the module sweeps.
    pub trigger_us: u32,
    /// Of that, what may begin late, when the port has taken the whole trigger.
    pub held_us: u32,
    /// Duration of the chirp where the module knows it; else that of the settings counts.
    pub chirp_us: Option<u32>,
    /// From the end of the chirp until its samples have come.
    pub answer_us: u32,
    /// Whether the next chirp may be triggered while the answer to the last trigger is on its way.
    pub ahead: bool,
}

/// Bytes of a trigger that a port may still hold when it has taken the last one: the one under way and the next.
const HELD: u32 = 2;

/// The serial wire between scanner and module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wire {
    /// Bits a second.
    pub baud: u32,
    /// Whether the next chirp may be triggered while the answer to the last trigger is on its way.
    pub ahead: bool,
    /// Whether a chirp begins at the edge of the TRIG pin, not with the trigger's last byte.
    pub pin: bool,
}

impl Default for Wire {
    fn default() -> Self {
        Self {
            baud: LINK_BAUD,
            ahead: false,
            pin: false,
        }
    }
}

impl Wire {
    /// Time of so many bytes, microseconds, rounded up.
    pub fn time_us(&self, bytes: u32) -> u32 {
        // At most 10^9 of 32 bits: the longest frame has 1036 bytes.
        let bits = bytes.saturating_mul(BITS);
        let baud = (self.baud / 1000).max(1);
        bits.saturating_mul(1000).div_ceil(baud)
    }

    /// Time of one byte, microseconds, rounded up.
    pub fn byte_us(&self) -> u32 {
        self.time_us(1)
    }

    /// From a trigger's call until the module has it, microseconds.
    pub fn trigger_us(&self) -> u32 {
        if self.pin { 0 } else { self.time_us(TRIGGER) }
    }

    /// The times of a row of `samples`.
    pub fn row_times(&self, samples: u16) -> RowTimes {
        RowTimes {
            trigger_us: self.trigger_us(),
            // What a pin starts waits for no byte.
            held_us: if self.pin { 0 } else { self.time_us(HELD) },
            chirp_us: None,
            answer_us: self.chirp_us(samples),
            ahead: self.ahead,
        }
    }

    /// Time of the answer with a chirp of `samples`, microseconds.
    pub fn chirp_us(&self, samples: u16) -> u32 {
        self.time_us(4 * u32::from(samples) + (HEADER + TRAILER) as u32)
    }
}
