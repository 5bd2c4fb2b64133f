//! Radar module selected by a setting: one image contains all protocols.

use core::task::Poll;

use embedded_hal::spi::SpiDevice;

use super::bgt60::Bgt60;
use super::link::Frames;
use super::module::{LinkError, ModuleKind, RadarModule, RequestedSettings};
use super::sirad::SiRad;
use super::wire::{RowTimes, Wire};
use crate::Iq;
use crate::config::RadarConfig;
use crate::port::BytePort;
use crate::time::Micros;

/// Protocol in use. The protocols share their memory, because only one module is connected.
#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is no heap, and the room is that of the largest either way"
)]
enum Protocol {
    Pstr(Frames),
    SiRad(SiRad),
    Bgt60(Bgt60),
}

/// Returns the times of trigger, chirp and answer of a row of `samples` samples, as expected from the requested
/// settings before the module has answered; `None` if the mirror must stop for each chirp.
pub fn row_times(requested: &RequestedSettings, samples: u16) -> Option<RowTimes> {
    match requested.kind {
        ModuleKind::Pstr => {
            let wire = Wire {
                baud: requested.baud,
                ahead: true,
                pin: requested.pin,
            };
            Some(wire.row_times(samples))
        }
        ModuleKind::SiRad => None,
        ModuleKind::Bgt60 => Some(Bgt60::times(requested)),
    }
}

/// Radar module selected by the setting `module`, on a serial port or an SPI bus.
#[derive(Debug)]
pub struct AnyModule<P, S> {
    port: P,
    spi: S,
    protocol: Protocol,
}

impl<P: BytePort, S: SpiDevice<u8>> AnyModule<P, S> {
    /// Creates the default module, before any setting.
    pub const fn new(port: P, spi: S) -> Self {
        Self {
            port,
            spi,
            protocol: Protocol::Pstr(Frames::new()),
        }
    }

    /// Switches to the protocol of `kind`, in its initial state unless it is in use already.
    fn become_(&mut self, kind: ModuleKind) {
        match (&self.protocol, kind) {
            (Protocol::Pstr(_), ModuleKind::Pstr)
            | (Protocol::SiRad(_), ModuleKind::SiRad)
            | (Protocol::Bgt60(_), ModuleKind::Bgt60) => {}
            (_, ModuleKind::Pstr) => self.protocol = Protocol::Pstr(Frames::new()),
            (_, ModuleKind::SiRad) => self.protocol = Protocol::SiRad(SiRad::new()),
            (_, ModuleKind::Bgt60) => self.protocol = Protocol::Bgt60(Bgt60::new()),
        }
    }
}

impl<P: BytePort, S: SpiDevice<u8>> RadarModule for AnyModule<P, S> {
    fn program(&mut self, now: Micros, requested: &RequestedSettings, timeout_us: u32) {
        self.become_(requested.kind);
        let (port, spi) = (&mut self.port, &mut self.spi);
        match &mut self.protocol {
            Protocol::Pstr(frames) => frames.program(port, now, requested, timeout_us),
            Protocol::SiRad(sirad) => sirad.program(port, now, requested, timeout_us),
            Protocol::Bgt60(chip) => chip.program(spi, now, requested, timeout_us),
        }
    }

    fn settings(&mut self, now: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        match &mut self.protocol {
            Protocol::Pstr(frames) => frames.settings(&mut self.port, now),
            Protocol::SiRad(sirad) => sirad.settings(&mut self.port, now),
            Protocol::Bgt60(chip) => chip.settings(&mut self.spi, now),
        }
    }

    fn trigger(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) {
        let (port, spi) = (&mut self.port, &mut self.spi);
        match &mut self.protocol {
            Protocol::Pstr(frames) => frames.trigger(port, now, shaft_angle, timeout_us),
            Protocol::SiRad(sirad) => sirad.trigger(port, now, shaft_angle, timeout_us),
            Protocol::Bgt60(chip) => chip.trigger(spi, now, shaft_angle, timeout_us),
        }
    }

    fn poll(&mut self, now: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        match &mut self.protocol {
            Protocol::Pstr(frames) => frames.poll(&mut self.port, now, samples),
            Protocol::SiRad(sirad) => sirad.poll(&mut self.port, now, samples),
            Protocol::Bgt60(chip) => chip.poll(&mut self.spi, now, samples),
        }
    }

    fn retry(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) {
        match &mut self.protocol {
            Protocol::Pstr(frames) => frames.retry(&mut self.port, now, shaft_angle, timeout_us),
            _ => self.trigger(now, shaft_angle, timeout_us),
        }
    }

    fn sent(&self) -> bool {
        match &self.protocol {
            Protocol::Pstr(frames) => frames.sent(),
            Protocol::SiRad(sirad) => sirad.sent(),
            Protocol::Bgt60(chip) => chip.sent(),
        }
    }

    fn waits(&self) -> bool {
        match &self.protocol {
            Protocol::Pstr(frames) => frames.waits(),
            Protocol::SiRad(_) | Protocol::Bgt60(_) => false,
        }
    }

    fn row_times(&self, samples: u16) -> Option<RowTimes> {
        match &self.protocol {
            Protocol::Pstr(frames) => Some(frames.wire().row_times(samples)),
            Protocol::SiRad(_) => None,
            Protocol::Bgt60(chip) => Some(chip.row_times()),
        }
    }

    fn trigger_ahead(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) -> bool {
        match &mut self.protocol {
            Protocol::Pstr(frames) => {
                frames.trigger_ahead(&mut self.port, now, shaft_angle, timeout_us)
            }
            _ => false,
        }
    }
}
