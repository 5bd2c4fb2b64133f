//! Time from one expiry of the step timer to the next.
//!
//! In: intervals from [`super::ramp`], and how late each pulse comes after its expiry. Out: the timer's next count. The
//! timer goes on counting while its interrupt waits and the handler runs; this time is part of the next interval, so
//! that latencies do not add up and the mean speed is that of the ramp. On the chip the timer is SysTick
//! (`src/board/motor.rs`).

/// Clocks from the last reading of the timer to its restart, which it does not count: loads, arithmetic and two stores,
/// counted in the disassembly of the handler.
pub const RESTART: u32 = 28;
/// Share of an interval by which it may be shortened after a late pulse: a quarter. At 102,400 steps/s and 168
/// MHz that is 410 clocks, 2.4 µs, and more than any interrupt waits here.
const CATCH_UP: u32 = 4;
/// Maximum lateness that is recovered, in intervals: the rest of a longer delay stays, so that the speed is above the
/// ramp's for a few steps only.
const MOST: u32 = 2;

/// Lateness of the timer's expiries behind the ramp's schedule, within one move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepTimer {
    /// Clocks by which the last expiry was later than the sum of the intervals.
    late: u32,
}

impl StepTimer {
    /// Returns the clocks from the last expiry to the next one, for a pulse `gone` clocks after the last expiry and an
    /// interval of `ticks` clocks. The next expiry is at least three quarters of the interval after the pulse.
    pub fn due(&mut self, gone: u32, ticks: u32) -> u32 {
        let earliest = gone.saturating_add(ticks - ticks / CATCH_UP);
        let due = ticks.saturating_sub(self.late).max(earliest);
        let late = self.late.saturating_add(due).saturating_sub(ticks);
        self.late = late.min(ticks.saturating_mul(MOST));
        due
    }

    /// Restarts the timer, whose last expiry was `elapsed` clocks ago, so that it expires `due` clocks after that: calls
    /// `start` with the clocks from now on, at least `least`. All are below 2³⁰.
    #[inline]
    pub fn restart(&mut self, due: u32, elapsed: u32, least: u32, start: impl FnOnce(u32)) {
        let gone = elapsed + RESTART;
        let left = due.saturating_sub(gone).max(least);
        start(left);
        self.late = self.late.saturating_add((gone + left).saturating_sub(due));
    }
}

/// Returns the clocks since the expiry of a timer that counts down from `reload` to 0 and then reloads, from its count
/// now; `again` if it has expired once more since, whose interrupt is pending.
#[inline]
pub fn elapsed(reload: u32, count: u32, again: bool) -> u32 {
    let period = reload + 1;
    let since = match count {
        0 => 0,
        _ => period.wrapping_sub(count),
    };
    match again {
        true => since + period,
        false => since,
    }
}

#[cfg(test)]
mod tests;
