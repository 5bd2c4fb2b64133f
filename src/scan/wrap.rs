//! Recorder and fault injector: wrappers around any radar link.

use core::task::Poll;

use super::frame::FrameError;
use super::link::{LinkError, RadarLink};
use super::time::Micros;
use crate::Iq;
use crate::config::RadarConfig;

/// What a [`Recorder`] hands on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event<'a> {
    /// What the module said about itself.
    Settings(Result<RadarConfig, LinkError>),
    /// A chirp that came for the shaft angle (0.001°).
    Chirp(i32, &'a [Iq]),
    /// A chirp that did not come for the shaft angle (0.001°).
    Lost(i32, LinkError),
}

/// Shows everything that passes a link to `observer` and changes nothing.
#[derive(Debug)]
pub struct Recorder<L, F> {
    link: L,
    observer: F,
    shaft_angle: i32,
}

impl<L: RadarLink, F: FnMut(Event<'_>)> Recorder<L, F> {
    /// Wraps `link`.
    pub const fn new(link: L, observer: F) -> Self {
        Self {
            link,
            observer,
            shaft_angle: 0,
        }
    }
}

impl<L: RadarLink, F: FnMut(Event<'_>)> RadarLink for Recorder<L, F> {
    fn configure(&mut self, now: Micros, timeout_us: u32) {
        self.link.configure(now, timeout_us);
    }

    fn poll_settings(&mut self, now: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        let poll = self.link.poll_settings(now);
        if let Poll::Ready(settings) = poll {
            (self.observer)(Event::Settings(settings));
        }
        poll
    }

    fn trigger(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) {
        self.shaft_angle = shaft_angle;
        self.link.trigger(now, shaft_angle, timeout_us);
    }

    fn poll_chirp(&mut self, now: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        let poll = self.link.poll_chirp(now, samples);
        match poll {
            Poll::Ready(Ok(())) => (self.observer)(Event::Chirp(self.shaft_angle, samples)),
            Poll::Ready(Err(error)) => (self.observer)(Event::Lost(self.shaft_angle, error)),
            Poll::Pending => {}
        }
        poll
    }
}

/// What a [`FaultInjector`] does to one answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// It never comes.
    Lost,
    /// It comes damaged.
    Corrupt,
    /// Only another request's answer comes.
    Stale,
    /// The module reports an error of this code.
    Module(u8),
}

/// Replaces answers by errors; `plan` is asked with the number of each trigger, from 0.
#[derive(Debug)]
pub struct FaultInjector<L, F> {
    link: L,
    plan: F,
    triggers: u32,
    fault: Option<Fault>,
    deadline: Micros,
}

impl<L: RadarLink, F: FnMut(u32) -> Option<Fault>> FaultInjector<L, F> {
    /// Wraps `link`.
    pub const fn new(link: L, plan: F) -> Self {
        Self {
            link,
            plan,
            triggers: 0,
            fault: None,
            deadline: Micros(0),
        }
    }
}

impl<L: RadarLink, F: FnMut(u32) -> Option<Fault>> RadarLink for FaultInjector<L, F> {
    fn configure(&mut self, now: Micros, timeout_us: u32) {
        self.link.configure(now, timeout_us);
    }

    fn poll_settings(&mut self, now: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        self.link.poll_settings(now)
    }

    fn trigger(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) {
        self.fault = (self.plan)(self.triggers);
        self.triggers = self.triggers.wrapping_add(1);
        self.deadline = now.plus(timeout_us);
        self.link.trigger(now, shaft_angle, timeout_us);
    }

    fn poll_chirp(&mut self, now: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        let Some(fault) = self.fault else {
            return self.link.poll_chirp(now, samples);
        };
        let error = match fault {
            Fault::Lost => LinkError::Timeout,
            Fault::Stale => LinkError::Sequence,
            Fault::Corrupt => LinkError::Frame(FrameError::Crc),
            Fault::Module(code) => LinkError::Module(code),
        };
        // What shows only by the answer's absence takes as long as it would on the wire.
        let waits = matches!(fault, Fault::Lost | Fault::Stale);
        if waits && !now.reached(self.deadline) {
            return Poll::Pending;
        }
        Poll::Ready(Err(error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Answers every trigger with its angle.
    struct Echo(i16);

    impl RadarLink for Echo {
        fn configure(&mut self, _: Micros, _: u32) {}
        fn poll_settings(&mut self, _: Micros) -> Poll<Result<RadarConfig, LinkError>> {
            Poll::Ready(Ok(RadarConfig::default()))
        }
        fn trigger(&mut self, _: Micros, shaft_angle: i32, _: u32) {
            self.0 = shaft_angle as i16;
        }
        fn poll_chirp(&mut self, _: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
            samples.fill(Iq::new(self.0, 0));
            Poll::Ready(Ok(()))
        }
    }

    #[test]
    fn recorder_sees_what_the_injector_makes() {
        let mut seen = Vec::new();
        let plan = |n| match n {
            1 => Some(Fault::Lost),
            2 => Some(Fault::Corrupt),
            3 => Some(Fault::Module(2)),
            _ => None,
        };
        let mut link = Recorder::new(FaultInjector::new(Echo(0), plan), |event: Event<'_>| {
            seen.push(match event {
                Event::Settings(_) => (0, Ok(0)),
                Event::Chirp(angle, samples) => (angle, Ok(samples[0].i)),
                Event::Lost(angle, error) => (angle, Err(error)),
            })
        });
        let mut samples = [Iq::default(); 4];
        let now = Micros(0);
        assert!(link.poll_settings(now).is_ready());
        for n in 0..5 {
            link.trigger(now, n, 100);
            let early = link.poll_chirp(now.plus(99), &mut samples);
            assert_eq!(early.is_pending(), n == 1);
            if n == 1 {
                assert!(link.poll_chirp(now.plus(100), &mut samples).is_ready());
            }
        }
        let crc = LinkError::Frame(FrameError::Crc);
        let expected = [
            (0, Ok(0)),
            (0, Ok(0)),
            (1, Err(LinkError::Timeout)),
            (2, Err(crc)),
            (3, Err(LinkError::Module(2))),
            (4, Ok(4)),
        ];
        assert_eq!(seen, expected);
    }
}
