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

#[cfg(test)]
mod tests {
    use super::*;

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
