//! Radar module with this project's binary frames and a serial port of its own.

use core::task::Poll;

use super::link::Frames;
use crate::Iq;
use crate::config::RadarConfig;
use crate::port::BytePort;
use crate::signal::radar::module::{LinkError, RadarModule, RequestedSettings};
use crate::signal::radar::wire::RowTimes;
use crate::time::Micros;

/// Radar module with this project's binary frames: the protocol ([`Frames`]) and its serial port.
#[derive(Debug)]
pub struct FrameLink<P> {
    pub(in crate::signal::radar) port: P,
    pub(in crate::signal::radar) frames: Frames,
}

impl<P> FrameLink<P> {
    /// Creates a link over `port`.
    pub const fn new(port: P) -> Self {
        Self {
            port,
            frames: Frames::new(),
        }
    }
}

impl<P: BytePort> RadarModule for FrameLink<P> {
    fn program(&mut self, now: Micros, requested: &RequestedSettings, timeout_us: u32) {
        self.frames
            .program(&mut self.port, now, requested, timeout_us);
    }

    fn settings(&mut self, now: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        self.frames.settings(&mut self.port, now)
    }

    fn trigger(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) {
        let port = &mut self.port;
        self.frames.trigger(port, now, shaft_angle, timeout_us);
    }

    fn poll(&mut self, now: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        self.frames.poll(&mut self.port, now, samples)
    }

    fn retry(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) {
        let port = &mut self.port;
        self.frames.retry(port, now, shaft_angle, timeout_us);
    }

    fn sent(&self) -> bool {
        self.frames.sent()
    }

    fn waits(&self) -> bool {
        self.frames.waits()
    }

    fn row_times(&self, samples: u16) -> Option<RowTimes> {
        Some(self.frames.wire().row_times(samples))
    }

    fn trigger_ahead(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) -> bool {
        let port = &mut self.port;
        self.frames
            .trigger_ahead(port, now, shaft_angle, timeout_us)
    }
}
