//! Radar module with this project's frames: requests, answers, and the rate of the wire.
//!
//! # Rate
//! Both ends begin at 1 Mbaud. If the module supports a faster rate, and the port divides its clock to it
//! exactly (84 MHz: 1, 2 and 3 Mbaud; the internal oscillator is not accurate enough for more than 1), the
//! scanner requests it. Both switch after the module's answer, and the scanner requests the settings once more
//! at the new rate. If that fails, both return to 1 Mbaud.
//!
//! To return, no answer is needed: a zero byte at 1 Mbaud is low for longer than any byte at 2 or 3 Mbaud can
//! be. The module detects this as a break and returns to 1 Mbaud. The scanner returns when a chirp must be
//! triggered again while the mirror stands, and when a request for the settings fails. During a scan with a
//! turning mirror it does not return before the end, because the scan is planned for the rate of its wire. A
//! rate at which more than 3 answers of one scan failed is not requested again for 200 scans.

use core::task::Poll;

use super::frame::{self, Ability, Decoder, Frame, FrameKind, Progress};
use super::module::{LinkError, RequestedSettings};
use super::wire::{LINK_BAUD, Wire};
use crate::Iq;
use crate::config::RadarConfig;
use crate::port::{BytePort, MAX_READ};
use crate::time::Micros;

/// A request whose answer is pending.
#[derive(Clone, Copy, Debug)]
struct Request {
    kind: FrameKind,
    sequence: u16,
    deadline: Micros,
    other_answers: bool,
}

/// Kinds of a request's frame and of its answer's.
#[derive(Clone, Copy, Debug)]
struct Kinds {
    request: FrameKind,
    answer: FrameKind,
}

impl Kinds {
    /// Trigger of a chirp.
    const CHIRP: Self = Self {
        request: FrameKind::Trigger,
        answer: FrameKind::Chirp,
    };
    /// Change of the bit rate.
    const RATE: Self = Self {
        request: FrameKind::Rate,
        answer: FrameKind::RateSet,
    };
}

/// Maximum time in which a module changes its bit rate, microseconds: some 10^4 instructions of a small processor.
const SWITCH_US: u32 = 1_000;
/// Timeout of the first answer at a new bit rate, microseconds: a hundred times its duration, but within the timeout of
/// a module's settings.
const CHECK_US: u32 = 20_000;
/// Maximum number of failed answers in one scan with which the wire's bit rate still counts as usable. At a bit error
/// rate of 10^-7 fewer than one of 281 answers is damaged.
const MAX_FAILURES: u16 = 3;
/// Number of zero bytes that return a module to [`LINK_BAUD`]: it may receive only the end of the first one.
const BREAKS: u8 = 2;
/// Number of scans after which a bit rate that failed is requested again: some minutes.
const RETRY_SCANS: u8 = 200;

/// Answer of the module that [`Frames::settings`] waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SettingsStage {
    /// Settings of the module, requested at the present bit rate.
    Asked,
    /// Confirmation of the requested bit rate, Mbaud.
    Raising(u8),
    /// Settings of the module, requested once more at the new bit rate as a check of it.
    Checking,
}

/// Protocol of a radar module with this project's binary frames. Each call is given the serial port.
#[derive(Debug)]
pub struct Frames {
    decoder: Decoder,
    sequence: u16,
    request: Option<Request>,
    /// Second request, sent while the first one is pending.
    ahead: Option<Request>,
    /// Whether the decoder holds an unprocessed frame: the answer to a later request than the pending one.
    held: bool,
    out: heapless::Vec<u8, 32>,
    sent: usize,
    /// Time before which nothing is sent, because the module changes its bit rate.
    quiet: Option<Micros>,
    /// Number of zero bytes to be sent before the request, at 1 Mbaud.
    breaks: u8,
    /// Whether the module may be at another bit rate than the scanner: one of them was reset.
    unsure: bool,
    stage: SettingsStage,
    /// Deadline of the request for the module's settings.
    until: Micros,
    requested: RequestedSettings,
    /// Settings and abilities of the module.
    radar: RadarConfig,
    ability: Ability,
    /// Present bit rate of the wire, Mbaud.
    rate: u8,
    /// Maximum bit rate that is requested, Mbaud.
    max_rate: u8,
    /// Number of scans until a faster bit rate is requested again.
    retry_scans: u8,
    /// Number of failed answers since the last request for settings.
    failures: u16,
}

impl Frames {
    /// Creates the protocol's state at 1 Mbaud, with an unknown module.
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
            requested: RequestedSettings::DEFAULT,
            radar: RadarConfig::DEFAULT,
            ability: Ability::NONE,
            rate: 1,
            max_rate: u8::MAX,
            retry_scans: 0,
            failures: 0,
        }
    }

    fn send(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
        kinds: Kinds,
        payload: &[u8],
        timeout_us: u32,
    ) {
        self.decoder.reset();
        (self.ahead, self.held) = (None, false);
        port.drain();
        self.request = Some(self.begin(port, now, kinds, payload, timeout_us));
    }

    /// Begins to send a request with a new sequence number. Returns it as one whose answer is pending.
    fn begin(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
        kinds: Kinds,
        payload: &[u8],
        timeout_us: u32,
    ) -> Request {
        self.sequence = self.sequence.wrapping_add(1);
        frame::encode(kinds.request, self.sequence, payload, &mut self.out);
        self.sent = 0;
        self.pump(port, now);
        Request {
            kind: kinds.answer,
            sequence: self.sequence,
            deadline: now.plus(timeout_us),
            other_answers: false,
        }
    }

    /// Ends the pending request with `result`, which it returns; the request sent ahead, if any, becomes
    /// pending.
    fn finish(&mut self, result: Result<(), LinkError>) -> Poll<Result<(), LinkError>> {
        self.failures = self.failures.saturating_add(u16::from(result.is_err()));
        self.request = self.ahead.take();
        Poll::Ready(result)
    }

    /// Passes to the port as much of the request as the port takes.
    fn pump(&mut self, port: &mut impl BytePort, now: Micros) {
        while self.breaks > 0 {
            if port.write(&[0]) == 0 {
                return;
            }
            self.breaks -= 1;
            self.quiet = Some(now.plus(SWITCH_US));
        }
        // After `stop` nothing may be sent for hours: only a time shortly after `now` is still to come.
        let waits = |until: Micros| until != now && until.since(now) <= SWITCH_US;
        if self.quiet.is_some_and(waits) {
            return;
        }
        self.quiet = None;
        let rest = self.out.get(self.sent..).unwrap_or(&[]);
        if !rest.is_empty() {
            self.sent += port.write(rest);
        }
    }

    /// Reads bytes until there is an answer, an error or no byte left, or [`MAX_READ`] bytes have been read.
    fn answer(&mut self, port: &mut impl BytePort, now: Micros) -> Poll<Result<(), LinkError>> {
        self.pump(port, now);
        let Some(request) = self.request else {
            return Poll::Ready(Err(LinkError::Timeout));
        };
        // A request is sent completely, whatever is received meanwhile: the module would take two truncated
        // ones for one request with hundreds of bytes.
        if !self.handed_over() && !now.reached(request.deadline) {
            return Poll::Pending;
        }
        if core::mem::take(&mut self.held)
            && let Some(result) = self.judge(&request)
        {
            return self.finish(result);
        }
        for _ in 0..MAX_READ {
            let Some(byte) = port.read() else { break };
            let result = match self.decoder.push(byte) {
                Ok(Progress::Partial) => continue,
                Ok(Progress::Complete) => self.judge(&request),
                Err(error) => Some(Err(LinkError::Frame(error))),
            };
            if let Some(result) = result {
                return self.finish(result);
            }
            // Answers arrive in the order of their requests: the answer to this one is lost.
            if let Some(ahead) = self.ahead
                && self.judge(&ahead).is_some()
            {
                self.held = true;
                return self.finish(Err(LinkError::Sequence));
            }
            if let Some(request) = &mut self.request {
                request.other_answers = true;
            }
        }
        if !now.reached(request.deadline) {
            return Poll::Pending;
        }
        let strangers = self.request.is_some_and(|r| r.other_answers);
        self.finish(Err(if strangers {
            LinkError::Sequence
        } else {
            LinkError::Timeout
        }))
    }

    /// Returns the result that the frame just decoded gives for `request`; `None` if the frame answers another request.
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

    /// Returns the maximum bit rate that port, module and settings allow and that has not failed, Mbaud.
    fn best_rate(&self, port: &impl BytePort) -> u8 {
        let most = self.ability.fastest.min(self.max_rate);
        let wished = |rate: u8| u32::from(rate) * LINK_BAUD <= self.requested.baud;
        let rates = [3, 2].into_iter();
        let mut fit = rates.filter(|&rate| rate <= most && wished(rate));
        fit.find(|&rate| port.has_rate(u32::from(rate) * LINK_BAUD))
            .unwrap_or(1)
    }

    fn set_rate(&mut self, port: &mut impl BytePort, rate: u8) {
        port.set_rate(u32::from(rate) * LINK_BAUD);
        self.rate = rate;
    }

    /// Sets both ends of the wire back to 1 Mbaud, whatever the module's bit rate is.
    #[inline(never)]
    fn fall_back(&mut self, port: &mut impl BytePort) {
        self.set_rate(port, 1);
        self.breaks = BREAKS;
    }

    /// Sets both ends of the wire back to 1 Mbaud after a failure at `rate` Mbaud: for some time only lower
    /// rates are requested.
    fn give_up(&mut self, port: &mut impl BytePort, rate: u8) {
        self.max_rate = rate.max(2) - 1;
        self.retry_scans = RETRY_SCANS;
        self.fall_back(port);
    }

    /// Requests the module's settings, and sets it to other values first if any are configured.
    fn ask(&mut self, port: &mut impl BytePort, now: Micros, timeout_us: u32) {
        let payload = frame::requested_payload(&self.requested);
        let (request, payload) = match self.requested.is_of_module() {
            true => (FrameKind::Program, &payload[..]),
            false => (FrameKind::Configure, &[][..]),
        };
        let kinds = Kinds {
            request,
            answer: FrameKind::Settings,
        };
        self.send(port, now, kinds, payload, timeout_us);
    }

    /// Implements [`super::RadarModule::program`].
    // Not inlined: it would lie beneath the estimator on the stack.
    #[inline(never)]
    pub fn program(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
        requested: &RequestedSettings,
        timeout_us: u32,
    ) {
        self.requested = *requested;
        self.retry_scans = self.retry_scans.saturating_sub(1);
        if self.retry_scans == 0 {
            self.max_rate = u8::MAX;
        }
        if core::mem::take(&mut self.failures) > MAX_FAILURES && self.rate > 1 {
            self.give_up(port, self.rate);
        } else if self.unsure {
            self.fall_back(port);
        }
        self.stage = SettingsStage::Asked;
        self.until = now.plus(timeout_us);
        self.ask(port, now, timeout_us);
    }

    /// Implements [`super::RadarModule::settings`].
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
            SettingsStage::Asked => self.on_settings(port, now, result),
            SettingsStage::Raising(rate) => self.on_rate_set(port, now, rate, result),
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

    /// Processes the answer with the module's settings.
    fn on_settings(
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
        if self.requested.chirps > 1 && !self.ability.adds {
            return Poll::Ready(Err(LinkError::Unable));
        }
        let rate = self.best_rate(port);
        if rate == self.rate {
            return Poll::Ready(Ok(self.radar));
        }
        self.stage = SettingsStage::Raising(rate);
        let left = self.until.since(now).min(CHECK_US);
        self.send(port, now, Kinds::RATE, &[rate], left);
        Poll::Pending
    }

    /// Processes the module's confirmation of the bit rate `rate`, Mbaud.
    fn on_rate_set(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
        rate: u8,
        result: Result<(), LinkError>,
    ) -> Poll<Result<RadarConfig, LinkError>> {
        if result.is_err() {
            // It may have changed the rate nevertheless.
            self.give_up(port, rate.max(self.rate));
            return Poll::Ready(Ok(self.radar));
        }
        self.set_rate(port, rate);
        self.quiet = Some(now.plus(SWITCH_US));
        self.stage = SettingsStage::Checking;
        self.ask(port, now, SWITCH_US + CHECK_US);
        Poll::Pending
    }

    /// Implements [`super::RadarModule::trigger`]: pulses the port's pin first if that starts the chirp.
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
        self.send(port, now, Kinds::CHIRP, &payload, timeout_us);
    }

    /// Implements [`super::RadarModule::retry`].
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

    /// Implements [`super::RadarModule::poll`].
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

    /// Returns whether chirps begin at an edge of the TRIG pin.
    fn by_pin(&self) -> bool {
        self.requested.pin && self.ability.pin
    }

    /// Returns whether the port has taken the whole request.
    fn handed_over(&self) -> bool {
        self.sent >= self.out.len()
    }

    /// Implements [`super::RadarModule::sent`].
    pub fn sent(&self) -> bool {
        self.by_pin() || self.handed_over()
    }

    /// Implements [`super::RadarModule::waits`].
    pub fn waits(&self) -> bool {
        let to_send = self.breaks > 0 || self.quiet.is_some() || !self.handed_over();
        self.request.is_some() && !to_send && !self.held
    }

    /// Returns bit rate and abilities of the serial wire with the present module and settings.
    pub fn wire(&self) -> Wire {
        Wire {
            baud: u32::from(self.rate) * LINK_BAUD,
            ahead: self.ability.ahead,
            pin: self.by_pin(),
        }
    }

    /// Implements [`super::RadarModule::trigger_ahead`].
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
        self.ahead = Some(self.begin(port, now, Kinds::CHIRP, &payload, timeout_us));
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
