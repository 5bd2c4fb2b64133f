//! How long the mirror must not move after a trigger.

use crate::scan::pace::{SLACK_US, Wire};
use crate::scan::time::Micros;

/// A chirp's capture as the scanner knows it: it begins when the trigger's last byte is out, and takes
/// as long as the setting says.
///
/// A port takes byte after byte as the link is polled, so that a trigger leaves later than it should
/// when the scanner has been busy. Of any time between two polls no more counts than the one byte takes
/// that the port held: the trigger is then out at the latest when its time has been counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Hold {
    /// The last look.
    seen: Micros,
    /// What may still be to go of the trigger, microseconds.
    unsent_us: u32,
    byte_us: u32,
    /// When the trigger was out.
    out: Option<Micros>,
}

impl Hold {
    /// From a trigger at `now` over `wire` on.
    pub fn new(now: Micros, wire: Wire) -> Self {
        Self {
            seen: now,
            // One byte more: the one under way when the trigger was begun.
            unsent_us: wire.trigger_us().saturating_add(wire.byte_us()),
            byte_us: wire.byte_us(),
            out: None,
        }
    }

    /// Whether a chirp of `chirp_us` is captured by `now`; never, where it is not known how long it takes.
    pub fn over(&mut self, now: Micros, chirp_us: u32) -> bool {
        if chirp_us == 0 {
            return false;
        }
        let counted = now.since(self.seen).min(self.byte_us);
        self.seen = now;
        self.unsent_us = self.unsent_us.saturating_sub(counted);
        if self.unsent_us > 0 {
            return false;
        }
        let out = *self.out.get_or_insert(now);
        now.reached(out.plus(chirp_us).plus(SLACK_US))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held(start: Micros, mut now: impl FnMut(u32) -> u32) -> (u32, u32) {
        let mut hold = Hold::new(start, Wire::default());
        let found = (1..).find(|&k| hold.over(start.plus(now(k)), 1_000));
        let k = found.unwrap();
        (k, now(k))
    }

    #[test]
    fn trigger_then_chirp() {
        // 160 µs for the trigger, a byte more, 1,000 for the chirp, the slack.
        let (_, us) = held(Micros(u32::MAX - 500), |k| 3 * k);
        assert!((1_270..1_280).contains(&us), "{us}");
    }

    #[test]
    fn a_busy_scanner_sends_its_trigger_late() {
        // 5 ms between two looks: a byte each.
        let (k, us) = held(Micros(7), |k| 5_000 * k);
        assert_eq!((k, us), (18, 90_000));
    }

    #[test]
    fn a_chirp_of_unknown_length_is_waited_for() {
        let mut hold = Hold::new(Micros(0), Wire::default());
        assert!((0..1000).all(|k| !hold.over(Micros(1000 * k), 0)));
    }
}
