//! Times of the run, printed as day, time of day and the scanner's clock, and the largest gap between two events.

use std::fmt;

/// Microseconds of a minute.
pub const MINUTE_US: u64 = 60_000_000;
/// Microseconds of a day.
pub const DAY_US: u64 = 24 * 60 * MINUTE_US;
/// Span after which the scanner's 32-bit clock wraps, µs.
pub const SPAN_US: u64 = 1 << 32;

/// A time of the run, with the scanner's clock at that time.
#[derive(Clone, Copy, Debug, Default)]
pub struct Instant {
    /// Time since the beginning of the run, µs.
    pub at: u64,
    /// Reading of the scanner's clock, µs since its boot, modulo 2³².
    pub clock: u32,
    /// Whether the scanner's clock has wrapped since its boot.
    pub wrapped: bool,
}

impl Instant {
    /// Whether the scanner's clock wraps within a minute before or after.
    fn near_wrap(self) -> bool {
        let clock = u64::from(self.clock);
        clock + MINUTE_US > SPAN_US || (self.wrapped && clock < MINUTE_US)
    }
}

impl fmt::Display for Instant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let day = self.at / DAY_US + 1;
        let ms = self.at % DAY_US / 1_000;
        let (s, ms) = (ms / 1_000, ms % 1_000);
        let (h, m, s) = (s / 3_600, s / 60 % 60, s % 60);
        write!(
            f,
            "day {day}, {h:02}:{m:02}:{s:02}.{ms:03}, clock {}",
            self.clock
        )
    }
}

/// Largest gap between two events of one kind, such as two `LIVE` sentences, µs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gap {
    /// Largest of all gaps, µs.
    pub all: u64,
    /// Largest of the gaps that end within a minute of a wrap of the scanner's clock, µs.
    pub near_wrap: u64,
    /// Number of the gaps that end within a minute of a wrap.
    pub count_near: u64,
}

impl Gap {
    /// Takes the gap between two consecutive events into account.
    pub fn add(&mut self, from: Instant, to: Instant) {
        let gap = to.at - from.at;
        self.all = self.all.max(gap);
        if to.near_wrap() {
            self.near_wrap = self.near_wrap.max(gap);
            self.count_near += 1;
        }
    }
}
