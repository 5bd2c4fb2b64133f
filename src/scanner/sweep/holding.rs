//! Time after a trigger for which the mirror must not move.

use crate::signal::radar::module::RadarModule;
use crate::signal::radar::wire::SLACK_US;
use crate::time::Micros;

/// Detector of the end of a chirp's capture. The capture begins when the trigger's last byte has left the port,
/// and takes as long as the setting says.
///
/// The port takes the bytes one by one as the link is polled, so a trigger leaves late if the scanner has been
/// busy. The time therefore counts from when the last byte has been handed over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct CaptureTimer {
    /// Time at which the port was first seen to have taken the whole trigger; `None` before.
    out: Option<Micros>,
}

impl CaptureTimer {
    /// Whether the chirp of the last trigger, which takes `chirp_us` microseconds, has been captured by `now`;
    /// `false` if its duration is unknown (0).
    pub fn captured(&mut self, now: Micros, link: &impl RadarModule, chirp_us: u32) -> bool {
        if chirp_us == 0 || !link.sent() {
            return false;
        }
        let out = *self.out.get_or_insert(now);
        let held = link.row_times(0).map_or(0, |times| times.held_us);
        now.reached(out.plus(held).plus(chirp_us).plus(SLACK_US))
    }
}

#[cfg(test)]
mod tests {
    use core::task::Poll;

    use super::*;
    use crate::Iq;
    use crate::config::RadarConfig;
    use crate::signal::radar::module::{LinkError, RequestedSettings};
    use crate::signal::radar::wire::{RowTimes, Wire};

    /// Link stub: whether the trigger has been sent, and the timing of the wire.
    struct Link(bool, Option<Wire>);

    impl RadarModule for Link {
        fn program(&mut self, _: Micros, _: &RequestedSettings, _: u32) {}
        fn settings(&mut self, _: Micros) -> Poll<Result<RadarConfig, LinkError>> {
            Poll::Pending
        }
        fn trigger(&mut self, _: Micros, _: i32, _: u32) {}
        fn poll(&mut self, _: Micros, _: &mut [Iq]) -> Poll<Result<(), LinkError>> {
            Poll::Pending
        }
        fn sent(&self) -> bool {
            self.0
        }
        fn row_times(&self, samples: u16) -> Option<RowTimes> {
            self.1.map(|wire| wire.row_times(samples))
        }
    }

    fn held(link: &Link) -> u32 {
        let (start, mut hold) = (Micros(u32::MAX - 500), CaptureTimer::default());
        let found = (0..).find(|&us| hold.captured(start.plus(us), link, 1_000));
        found.unwrap()
    }

    #[test]
    fn what_the_port_holds_then_the_chirp() {
        // Two bytes at 1 Mbaud, 1,000 µs for the chirp, and the slack.
        let wire = Wire::default();
        assert_eq!(held(&Link(true, Some(wire))), 1_120);
        let wire = Wire {
            baud: 2_000_000,
            ..wire
        };
        assert_eq!(held(&Link(true, Some(wire))), 1_110);
        assert_eq!(held(&Link(true, Some(Wire { pin: true, ..wire }))), 1_100);
        assert_eq!(held(&Link(true, None)), 1_100);
    }

    #[test]
    fn a_trigger_that_is_not_out_is_waited_for() {
        let mut hold = CaptureTimer::default();
        let link = Link(false, None);
        assert!((0..1000).all(|k| !hold.captured(Micros(1000 * k), &link, 1)));
        // The time counts from the moment when it is out, not from the trigger's call.
        let link = Link(true, None);
        assert!(!hold.captured(Micros(2_000_000), &link, 1_000));
        assert!(hold.captured(Micros(2_001_100), &link, 1_000));
    }

    #[test]
    fn a_chirp_of_unknown_length_is_waited_for() {
        let mut hold = CaptureTimer::default();
        let link = Link(true, None);
        assert!((0..1000).all(|k| !hold.captured(Micros(1000 * k), &link, 0)));
    }
}
