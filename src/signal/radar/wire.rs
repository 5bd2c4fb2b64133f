//! Transmission times on the serial wire between scanner and radar module.

/// Initial bit rate of the wire with every module, baud: both clocks of the board divide to it exactly.
pub const LINK_BAUD: u32 = 1_000_000;
/// Length of a frame's header, bytes.
pub const HEADER: usize = 8;
/// Length of the CRC that ends a frame, bytes.
pub const TRAILER: usize = 4;

/// Number of bits of a byte on the serial wire: start, eight data bits, stop.
const BITS: u32 = 10;
/// Length of a trigger frame, bytes.
const TRIGGER: u32 = (HEADER + 4 + TRAILER) as u32;
/// Maximum delay from a trigger's last byte, or its edge, to the start of the chirp, and maximum excess of the
/// chirp's duration over the configured one, microseconds.
pub const SLACK_US: u32 = 100;

/// Times of a row whose chirp is triggered while the mirror turns, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowTimes {
    /// Time from the call of trigger to the start of the chirp.
    pub trigger_us: u32,
    /// Part of `trigger_us` that may remain when the port has taken the whole trigger, because it still holds
    /// bytes.
    pub held_us: u32,
    /// Duration of the chirp if the module knows it; `None`: the configured duration applies.
    pub chirp_us: Option<u32>,
    /// Time from the end of the chirp until all samples have been received.
    pub answer_us: u32,
    /// Whether the next chirp may be triggered while the answer to the last trigger is still being sent.
    pub ahead: bool,
}

/// Maximum number of a trigger's bytes that a port still holds when it has taken the last one: the one being
/// sent and the next.
const HELD: u32 = 2;

/// Serial wire between scanner and radar module: bit rate and abilities, which give the times of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wire {
    /// Bit rate of the wire, baud.
    pub baud: u32,
    /// Whether the next chirp may be triggered while the answer to the last trigger is still being sent.
    pub ahead: bool,
    /// Whether a chirp begins at the edge of the TRIG pin instead of the trigger's last byte.
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
    /// Returns the transmission time of `bytes` bytes, microseconds, rounded up.
    pub fn time_us(&self, bytes: u32) -> u32 {
        // No overflow in practice: the longest frame has 1036 bytes.
        let bits = bytes.saturating_mul(BITS);
        let baud = (self.baud / 1000).max(1);
        bits.saturating_mul(1000).div_ceil(baud)
    }

    /// Returns the time from the call of trigger until the module has received it, microseconds; 0 if the TRIG
    /// pin starts the chirp.
    pub fn trigger_us(&self) -> u32 {
        if self.pin { 0 } else { self.time_us(TRIGGER) }
    }

    /// Returns the times of trigger, chirp and answer of a row of `samples` samples.
    pub fn row_times(&self, samples: u16) -> RowTimes {
        RowTimes {
            trigger_us: self.trigger_us(),
            // A chirp triggered by the pin does not wait for any byte.
            held_us: if self.pin { 0 } else { self.time_us(HELD) },
            chirp_us: None,
            answer_us: self.chirp_us(samples),
            ahead: self.ahead,
        }
    }

    /// Returns the transmission time of the answer with a chirp of `samples` samples, microseconds.
    pub fn chirp_us(&self, samples: u16) -> u32 {
        self.time_us(4 * u32::from(samples) + (HEADER + TRAILER) as u32)
    }
}
