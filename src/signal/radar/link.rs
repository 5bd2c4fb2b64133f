//! A module that speaks this project's frames: requests, answers, and the rate of the wire.
//!
//! # Rate
//! Both ends begin at 1 Mbaud. When the module says that it knows a faster rate, and the port divides its clock to
//! it exactly (84 MHz: 1, 2 and 3 Mbaud; the internal oscillator is not good enough for more than 1), the scanner
//! asks for it, both switch behind the module's answer, and the scanner asks for the settings once more at
//! the new rate. If that fails both go back.
//!
//! Going back needs no agreement: bytes of 0 at 1 Mbaud are longer low than any byte at 2 or 3 Mbaud may be, a
//! break, at which a module goes back to 1 Mbaud. The scanner goes back when a chirp has to be triggered
//! again from a mirror that stands, when a question for the settings fails, and, since a sweep in passing is
//! planned for its wire, not in the midst of one but behind it. A rate at which more than 3
//! answers of one scan failed is not asked for again for 200 scans.

use core::task::Poll;

use super::frame::{self, Ability, Decoder, Frame, FrameKind, Progress};
use super::module::{LinkError, Wish};
use super::wire::{LINK_BAUD, Wire};
use crate::Iq;
use crate::config::RadarConfig;
use crate::port::{BytePort, MOST_READ};
use crate::time::Micros;

/// The request that waits for its answer.
#[derive(Clone, Copy, Debug)]
struct Request {
    kind: FrameKind,
    sequence: u16,
    deadline: Micros,
    strangers: bool,
}

/// A module has so long to change its rate, microseconds: some 10^4 instructions of a small processor.
const SWITCH_US: u32 = 1_000;
/// For the first answer at a new rate, microseconds: a hundred times what it takes, but within the time that a
/// scanner waits for a module's settings.
const CHECK_US: u32 = 20_000;
/// More failures than this in one scan are no accident: of 281 answers at a bit error rate of 10^-7, fewer than
/// one is damaged.
const MOST_FAILURES: u16 = 3;
/// Bytes of 0 that take a module back to [`LINK_BAUD`]: of the first it may have heard only the end.
const BREAKS: u8 = 2;
/// After so many scans a rate that failed is tried again: some minutes.
const PENANCE: u8 = 200;

/// What [`Frames::settings`] waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SettingsStage {
    /// The module's settings.
    Asked,
    /// Its consent to another rate, in Mbaud.
    Raising(u8),
    /// Its settings at the new rate.
    Checking,
}

/// The protocol without its port.
#[derive(Debug)]
pub struct Frames {
    decoder: Decoder,
    sequence: u16,
    request: Option<Request>,
    /// The request that was sent while the other one waited.
    ahead: Option<Request>,
    /// The decoder holds a frame that has not been looked at yet: the answer to a later request than the one
    /// that waited.
    held: bool,
    out: heapless::Vec<u8, 32>,
    sent: usize,
    /// Until then nothing is sent: the module changes its rate.
    quiet: Option<Micros>,
    /// Bytes of 0 that go before the request, at 1 Mbaud.
    breaks: u8,
    /// Whether the module may be at another rate than the scanner thinks: one of them was reset.
    unsure: bool,
    stage: SettingsStage,
    /// By when the settings must have come.
    until: Micros,
    wish: Wish,
    /// What the module says of itself.
    radar: RadarConfig,
    ability: Ability,
    /// The wire's present rate, Mbaud, ...
    rate: u8,
    /// ... and the fastest that is still asked for.
    ceiling: u8,
    /// Scans to go until a faster one is tried again.
    penance: u8,
    /// Answers that failed since the settings were asked for.
    failures: u16,
}

impl Frames {
    /// At 1 Mbaud, with nothing known of the module.
    pub const fn new() -> Self {
        Self {
            decoder: Decoder::new(),
            sequence: 0,
            request: None,
            ahead: None,
            held: false,
            out: heapless::Vec::new(),
            sent: 0,
            quiet: None,
            breaks: 0,
            unsure: true,
            stage: SettingsStage::Asked,
            until: Micros(0),
            wish: Wish::DEFAULT,
            radar: RadarConfig::DEFAULT,
            ability: Ability::NONE,
            rate: 1,
            ceiling: u8::MAX,
            penance: 0,
            failures: 0,
        }
    }

    fn send(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
        kinds: (FrameKind, FrameKind),
        payload: &[u8],
        timeout_us: u32,
    ) {
        self.decoder.reset();
        (self.ahead, self.held) = (None, false);
        port.drain();
        self.request = Some(self.begin(port, now, kinds, payload, timeout_us));
    }

    /// Begins to send a request with a number of its own.
    fn begin(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
        (kind, answer): (FrameKind, FrameKind),
        payload: &[u8],
        timeout_us: u32,
    ) -> Request {
        self.sequence = self.sequence.wrapping_add(1);
        frame::encode(kind, self.sequence, payload, &mut self.out);
        self.sent = 0;
        self.pump(port, now);
        Request {
            kind: answer,
            sequence: self.sequence,
            deadline: now.plus(timeout_us),
            strangers: false,
        }
    }

    /// The request that waited does so no more; the next one waits.
    fn finish(&mut self, result: Result<(), LinkError>) -> Poll<Result<(), LinkError>> {
        self.failures = self.failures.saturating_add(u16::from(result.is_err()));
        self.request = self.ahead.take();
        Poll::Ready(result)
    }

    /// Hands over what the port takes of the request.
    fn pump(&mut self, port: &mut impl BytePort, now: Micros) {
        while self.breaks > 0 {
            if port.write(&[0]) == 0 {
                return;
            }
            self.breaks -= 1;
            self.quiet = Some(now.plus(SWITCH_US));
        }
        if self.quiet.is_some_and(|until| !now.reached(until)) {
            return;
        }
        self.quiet = None;
        let rest = self.out.get(self.sent..).unwrap_or(&[]);
        if !rest.is_empty() {
            self.sent += port.write(rest);
        }
    }

    /// Reads on until there is an answer, an error, nothing more to read, or [`MOST_READ`] bytes.
    fn answer(&mut self, port: &mut impl BytePort, now: Micros) -> Poll<Result<(), LinkError>> {
        self.pump(port, now);
        let Some(request) = self.request else {
            return Poll::Ready(Err(LinkError::Timeout));
        };
        // A request goes out whole, whatever comes in meanwhile: of two that were cut short the module would make
        // one that waits for hundreds of bytes.
        if !self.handed_over() && !now.reached(request.deadline) {
            return Poll::Pending;
        }
        if core::mem::take(&mut self.held)
            && let Some(result) = self.judge(&request)
        {
            return self.finish(result);
        }
        for _ in 0..MOST_READ {
            let Some(byte) = port.read() else { break };
            let result = match self.decoder.push(byte) {
                Ok(Progress::Partial) => continue,
                Ok(Progress::Complete) => self.judge(&request),
                Err(error) => Some(Err(LinkError::Frame(error))),
            };
            if let Some(result) = result {
                return self.finish(result);
            }
            // Answers come in the order of their requests: this one's is lost.
            if let Some(ahead) = self.ahead
                && self.judge(&ahead).is_some()
            {
                self.held = true;
                return self.finish(Err(LinkError::Sequence));
            }
            if let Some(request) = &mut self.request {
                request.strangers = true;
            }
        }
        if !now.reached(request.deadline) {
            return Poll::Pending;
        }
        let strangers = self.request.is_some_and(|r| r.strangers);
        self.finish(Err(if strangers {
            LinkError::Sequence
        } else {
            LinkError::Timeout
        }))
    }

    /// What a whole frame means for `request`; `None` when it answers another one.
    fn judge(&self, request: &Request) -> Option<Result<(), LinkError>> {
        let Frame {
            kind,
            sequence,
            payload,
        } = self.decoder.frame()?;
        if sequence != request.sequence {
            return None;
        }
        Some(match kind {
            FrameKind::Error => Err(LinkError::Module(payload.first().copied().unwrap_or(0))),
            _ if kind == request.kind => Ok(()),
            _ => Err(LinkError::Answer),
        })
    }

    /// The fastest rate that port, module and wish have in common and that has not failed, Mbaud.
    fn best_rate(&self, port: &impl BytePort) -> u8 {
        let most = self.ability.fastest.min(self.ceiling);
        let wished = |rate: u8| u32::from(rate) * LINK_BAUD <= self.wish.baud;
        let rates = [3, 2].into_iter();
        let mut fit = rates.filter(|&rate| rate <= most && wished(rate));
        fit.find(|&rate| port.has_rate(u32::from(rate) * LINK_BAUD))
            .unwrap_or(1)
    }

    fn set_rate(&mut self, port: &mut impl BytePort, rate: u8) {
        port.set_rate(u32::from(rate) * LINK_BAUD);
        self.rate = rate;
    }

    /// Takes both ends back to 1 Mbaud, whatever the module's is.
    #[inline(never)]
    fn fall_back(&mut self, port: &mut impl BytePort) {
        self.set_rate(port, 1);
        self.breaks = BREAKS;
    }

    /// The same because this rate failed: for a while no such is asked for.
    fn give_up(&mut self, port: &mut impl BytePort, rate: u8) {
        self.ceiling = rate.max(2) - 1;
        self.penance = PENANCE;
        self.fall_back(port);
    }

    /// Asks for the settings, and for others where something is wished.
    fn ask(&mut self, port: &mut impl BytePort, now: Micros, timeout_us: u32) {
        let wish = frame::wish_payload(&self.wish);
        let (kind, payload) = match self.wish.is_of_module() {
            true => (FrameKind::Program, &wish[..]),
            false => (FrameKind::Configure, &[][..]),
        };
        self.send(port, now, (kind, FrameKind::Settings), payload, timeout_us);
    }

    /// [`super::RadarModule::program`].
    // Out of line: it would lie beneath the estimator on the stack.
    #[inline(never)]
    pub fn program(&mut self, port: &mut impl BytePort, now: Micros, wish: &Wish, timeout_us: u32) {
        self.wish = *wish;
        self.penance = self.penance.saturating_sub(1);
        if self.penance == 0 {
            self.ceiling = u8::MAX;
        }
        if core::mem::take(&mut self.failures) > MOST_FAILURES && self.rate > 1 {
            self.give_up(port, self.rate);
        } else if self.unsure {
            self.fall_back(port);
        }
        self.stage = SettingsStage::Asked;
        self.until = now.plus(timeout_us);
        self.ask(port, now, timeout_us);
    }

    /// [`super::RadarModule::settings`].
    #[inline(never)]
    pub fn settings(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
    ) -> Poll<Result<RadarConfig, LinkError>> {
        let Poll::Ready(result) = self.answer(port, now) else {
            return Poll::Pending;
        };
        match self.stage {
            SettingsStage::Asked => self.told(port, now, result),
            SettingsStage::Raising(rate) => self.consented(port, now, rate, result),
            SettingsStage::Checking => {
                if result.and_then(|()| self.read_settings()).is_err() {
                    self.give_up(port, self.rate);
                }
                Poll::Ready(Ok(self.radar))
            }
        }
    }

    fn read_settings(&self) -> Result<(RadarConfig, Ability), LinkError> {
        let payload = self.decoder.frame().map_or(&[][..], |frame| frame.payload);
        frame::parse_settings(payload).ok_or(LinkError::Answer)
    }

    /// The module has told its settings, or not.
    fn told(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
        result: Result<(), LinkError>,
    ) -> Poll<Result<RadarConfig, LinkError>> {
        match result.and_then(|()| self.read_settings()) {
            Ok((radar, ability)) => {
                (self.radar, self.ability) = (radar, ability);
                self.unsure = false;
            }
            Err(error) => {
                self.unsure = true;
                self.fall_back(port);
                return Poll::Ready(Err(error));
            }
        }
        let rate = self.best_rate(port);
        if rate == self.rate {
            return Poll::Ready(Ok(self.radar));
        }
        self.stage = SettingsStage::Raising(rate);
        let kinds = (FrameKind::Rate, FrameKind::RateSet);
        let left = self.until.since(now).min(CHECK_US);
        self.send(port, now, kinds, &[rate], left);
        Poll::Pending
    }

    /// The module has consented to another rate, or not.
    fn consented(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
        rate: u8,
        result: Result<(), LinkError>,
    ) -> Poll<Result<RadarConfig, LinkError>> {
        if result.is_err() {
            // It may have switched all the same.
            self.give_up(port, rate.max(self.rate));
            return Poll::Ready(Ok(self.radar));
        }
        self.set_rate(port, rate);
        self.quiet = Some(now.plus(SWITCH_US));
        self.stage = SettingsStage::Checking;
        self.ask(port, now, SWITCH_US + CHECK_US);
        Poll::Pending
    }

    /// [`super::RadarModule::trigger`]: the port's pin first, if that is what starts a chirp.
    pub fn trigger(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
        shaft_angle: i32,
        timeout_us: u32,
    ) {
        if self.by_pin() {
            port.pulse();
        }
        let payload = shaft_angle.to_le_bytes();
        let kinds = (FrameKind::Trigger, FrameKind::Chirp);
        self.send(port, now, kinds, &payload, timeout_us);
    }

    /// [`super::RadarModule::retry`].
    pub fn retry(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
        shaft_angle: i32,
        timeout_us: u32,
    ) {
        if self.rate > 1 {
            self.fall_back(port);
        }
        let timeout_us = timeout_us.saturating_add(SWITCH_US);
        self.trigger(port, now, shaft_angle, timeout_us);
    }

    /// [`super::RadarModule::poll`].
    pub fn poll(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
        samples: &mut [Iq],
    ) -> Poll<Result<(), LinkError>> {
        self.answer(port, now).map(|result| {
            result?;
            let payload = self.decoder.frame().map_or(&[][..], |frame| frame.payload);
            if frame::parse_chirp(payload, samples) {
                Ok(())
            } else {
                Err(LinkError::Answer)
            }
        })
    }

    /// Whether chirps begin at an edge of the TRIG pin.
    fn by_pin(&self) -> bool {
        self.wish.pin && self.ability.pin
    }

    /// Whether the port has all of the request.
    fn handed_over(&self) -> bool {
        self.sent >= self.out.len()
    }

    /// [`super::RadarModule::sent`].
    pub fn sent(&self) -> bool {
        self.by_pin() || self.handed_over()
    }

    /// The wire as module and settings have it now.
    pub fn wire(&self) -> Wire {
        Wire {
            baud: u32::from(self.rate) * LINK_BAUD,
            ahead: self.ability.ahead,
            pin: self.by_pin(),
        }
    }

    /// [`super::RadarModule::trigger_ahead`].
    pub fn trigger_ahead(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
        shaft_angle: i32,
        timeout_us: u32,
    ) -> bool {
        let full = self.ahead.is_some() || !self.handed_over();
        if !self.ability.ahead || self.request.is_none() || full {
            return false;
        }
        if self.by_pin() {
            port.pulse();
        }
        let payload = shaft_angle.to_le_bytes();
        let kinds = (FrameKind::Trigger, FrameKind::Chirp);
        self.ahead = Some(self.begin(port, now, kinds, &payload, timeout_us));
        true
    }
}

impl Default for Frames {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;
