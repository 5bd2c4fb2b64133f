//! Time of a free-running microsecond counter.

/// A time in microseconds of a free-running 32-bit counter, which wraps after 71 minutes.
///
/// Only differences below half of the counter's span are meaningful; every timeout is held below that
/// ([`crate::scanner::settings::MAX_TIME`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Micros(pub u32);

impl Micros {
    /// Returns the microseconds from `earlier` to this time, modulo 2³².
    pub const fn since(self, earlier: Micros) -> u32 {
        self.0.wrapping_sub(earlier.0)
    }

    /// Returns the time `us` microseconds later.
    #[must_use]
    pub const fn plus(self, us: u32) -> Self {
        Self(self.0.wrapping_add(us))
    }

    /// Returns whether `deadline` is at or before this time.
    pub const fn reached(self, deadline: Micros) -> bool {
        self.since(deadline) < 1 << 31
    }
}

/// Age at which a time that is kept stops ageing, µs: 18 minutes, a quarter of the counter's span and more than any
/// timeout ([`crate::scanner::settings::MAX_TIME`]).
pub const MAX_AGE_US: u32 = 1 << 30;

impl Micros {
    /// Returns this time, or, where it is longer ago, the time 18 minutes before `now`. Applied to a kept time more
    /// often than that, it prevents the counter's wrap from making an old time a recent one. A time after `now` is
    /// unchanged.
    #[must_use]
    pub const fn aged(self, now: Micros) -> Self {
        if now.reached(self) && now.since(self) > MAX_AGE_US {
            Self(now.0.wrapping_sub(MAX_AGE_US))
        } else {
            self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kept_time_never_becomes_recent_again() {
        let then = Micros(u32::MAX - 10);
        let mut kept = then;
        // Every 10 minutes for 10 hours: eight wraps.
        for k in 1..=60_u32 {
            let now = then.plus(k.wrapping_mul(600_000_000));
            kept = kept.aged(now);
            assert!(now.since(kept) >= 600_000_000, "{k}");
        }
        let soon = Micros(7).plus(500);
        assert_eq!(soon.aged(Micros(7)), soon);
    }

    #[test]
    fn deadlines_survive_the_wrap() {
        let start = Micros(u32::MAX - 10);
        let deadline = start.plus(100);
        assert!(!start.reached(deadline));
        assert!(!start.plus(99).reached(deadline));
        assert!(start.plus(100).reached(deadline));
        assert!(start.plus(1_000_000).reached(deadline));
        assert_eq!(start.plus(100).since(start), 100);
    }
}
