//! Due time of the sentence `LIVE`, and the times that it reports.

use crate::time::Micros;

/// Period of the sentence `LIVE`, ms.
const PERIOD_MS: u32 = 200;

/// Time since boot, time since the last answer, and whether the sentence `LIVE` is due.
#[derive(Debug)]
pub(super) struct LiveTimer {
    /// Time up to which the milliseconds below have been counted.
    counted: Micros,
    uptime_ms: u32,
    age_ms: Option<u32>,
    /// Time since the sentence `LIVE` was last due, ms.
    since_ms: u32,
    due: bool,
}

impl LiveTimer {
    /// Starts to count at boot, which is at `now`.
    pub const fn new(now: Micros) -> Self {
        Self {
            counted: now,
            uptime_ms: 0,
            age_ms: None,
            since_ms: 0,
            due: false,
        }
    }

    /// Counts the milliseconds up to `now`.
    pub fn count(&mut self, now: Micros) {
        let ms = now.since(self.counted) / 1000;
        self.counted = self.counted.plus(ms * 1000);
        self.uptime_ms = self.uptime_ms.wrapping_add(ms);
        self.age_ms = self.age_ms.map(|age_ms| age_ms.saturating_add(ms));
        self.since_ms = self.since_ms.saturating_add(ms);
        if self.since_ms >= PERIOD_MS {
            // One that could not be sent is not sent twice.
            self.since_ms %= PERIOD_MS;
            self.due = true;
        }
    }

    /// Sets the time since the last answer to 0 at `at`, when the last row of an answered scan was processed.
    pub fn answered(&mut self, at: Micros) {
        self.count(at);
        self.age_ms = Some(0);
    }

    /// Whether the sentence `LIVE` is due.
    pub fn due(&self) -> bool {
        self.due
    }

    /// Marks `LIVE` as sent.
    pub fn mark_sent(&mut self) {
        self.due = false;
    }

    /// Returns the time since boot, ms.
    pub fn uptime_ms(&self) -> u32 {
        self.uptime_ms
    }

    /// Returns the time since the last row of the last answered scan, ms; `None` before the first answer.
    pub fn age_ms(&self) -> Option<u32> {
        self.age_ms
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_times_a_second_and_never_twice_at_once() {
        let boot = Micros(u32::MAX - 700_000);
        let mut pulse = LiveTimer::new(boot);
        let mut reported = 0;
        // The counter wraps on the way.
        for k in 1..=20_000_u32 {
            pulse.count(boot.plus(k * 130));
            if pulse.due() {
                pulse.mark_sent();
                reported += 1;
            }
        }
        assert_eq!((reported, pulse.uptime_ms()), (13, 2_600));
        pulse.count(boot.plus(12_600_000));
        assert!(pulse.due());
        pulse.mark_sent();
        pulse.count(boot.plus(12_601_000));
        assert!(!pulse.due(), "what was missed is not made up for");
        assert_eq!(pulse.uptime_ms(), 12_601);
    }

    #[test]
    fn an_answer_ages() {
        let boot = Micros(7);
        let mut pulse = LiveTimer::new(boot);
        pulse.count(boot.plus(5_000_000));
        assert_eq!(pulse.age_ms(), None);
        pulse.answered(boot.plus(5_250_400));
        assert_eq!((pulse.age_ms(), pulse.uptime_ms()), (Some(0), 5_250));
        pulse.count(boot.plus(6_000_000));
        assert_eq!((pulse.age_ms(), pulse.uptime_ms()), (Some(750), 6_000));
    }
}
