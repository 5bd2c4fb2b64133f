//! The radar link as the sweep sees it, and its implementation over frames.

use core::task::Poll;

use super::board::BytePort;
use super::frame::{self, Decoder, Frame, FrameError, Kind, Progress};
use super::pace;
use super::time::Micros;
use crate::Iq;
use crate::config::RadarConfig;

/// Why an answer is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkError {
    /// No answer in time.
    Timeout,
    /// The answer was damaged on the way, or not a frame of this version.
    Frame(FrameError),
    /// Only answers to other requests came in time: late or repeated ones.
    Sequence,
    /// The answer is of the wrong kind or length.
    Answer,
    /// The module says that it cannot; its code ([`frame`]).
    Module(u8),
}

/// The radar module at the other end: one request at a time, one answer each.
///
/// Narrow on purpose: a module with another protocol needs these four functions and nothing else
/// of the scanner changes. No function waits.
pub trait RadarLink {
    /// Asks what the module is set to.
    fn configure(&mut self, now: Micros, timeout_us: u32);
    /// The answer to [`RadarLink::configure`].
    fn poll_settings(&mut self, now: Micros) -> Poll<Result<RadarConfig, LinkError>>;
    /// Fires one chirp with the mirror's shaft at `shaft_angle` (0.001°).
    fn trigger(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32);
    /// The answer to [`RadarLink::trigger`]: exactly as many samples as `samples` holds.
    fn poll_chirp(&mut self, now: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>>;
    /// How fast the wire is, and whether [`RadarLink::trigger_ahead`] works.
    fn wire(&self) -> pace::Wire {
        pace::Wire::default()
    }
    /// [`RadarLink::trigger`] while the answer to the trigger before is on its way: answers then come one after
    /// the other, the older first. False, and nothing done, where that cannot be.
    fn trigger_ahead(&mut self, _now: Micros, _shaft_angle: i32, _timeout_us: u32) -> bool {
        false
    }
}

/// So that a link too large for the stack can stay where it is.
impl<L: RadarLink + ?Sized> RadarLink for &mut L {
    fn configure(&mut self, now: Micros, timeout_us: u32) {
        (**self).configure(now, timeout_us);
    }

    fn poll_settings(&mut self, now: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        (**self).poll_settings(now)
    }

    fn trigger(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) {
        (**self).trigger(now, shaft_angle, timeout_us);
    }

    fn poll_chirp(&mut self, now: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        (**self).poll_chirp(now, samples)
    }

    fn wire(&self) -> pace::Wire {
        (**self).wire()
    }

    fn trigger_ahead(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) -> bool {
        (**self).trigger_ahead(now, shaft_angle, timeout_us)
    }
}

/// The request that waits for its answer.
#[derive(Clone, Copy, Debug)]
struct Request {
    kind: Kind,
    sequence: u16,
    deadline: Micros,
    strangers: bool,
}

/// Most bytes that are read in one go, so that a module that never falls silent cannot hold the scanner up
/// beyond a deadline: more than a port's queue holds.
const MOST_READ: u32 = 4096;

/// Where in the settings' payload the module says what else it can; older ones say 0.
pub const ABILITIES: usize = 10;
/// That it captures a chirp while it sends the one before.
pub const AHEAD: u8 = 1;

/// The radar link over [`frame`]s on a serial port.
#[derive(Debug)]
pub struct FrameLink<P> {
    port: P,
    decoder: Decoder,
    sequence: u16,
    request: Option<Request>,
    /// The request that was sent while the other one waited.
    ahead: Option<Request>,
    /// The decoder holds a frame that has not been looked at yet: the answer to a later request than the one
    /// that waited.
    held: bool,
    /// The module says that it captures a chirp while it sends another.
    captures_ahead: bool,
    out: heapless::Vec<u8, 32>,
    sent: usize,
}

impl<P: BytePort> FrameLink<P> {
    /// A link over `port`.
    pub const fn new(port: P) -> Self {
        Self {
            port,
            decoder: Decoder::new(),
            sequence: 0,
            request: None,
            ahead: None,
            held: false,
            captures_ahead: false,
            out: heapless::Vec::new(),
            sent: 0,
        }
    }

    fn send(&mut self, now: Micros, kind: Kind, answer: Kind, payload: &[u8], timeout_us: u32) {
        self.decoder.reset();
        (self.ahead, self.held) = (None, false);
        // What is still in the port answers an earlier request. A module that babbles fills it again.
        for _ in 0..MOST_READ {
            if self.port.read().is_none() {
                break;
            }
        }
        self.request = Some(self.begin(now, (kind, answer), payload, timeout_us));
    }

    /// Begins to send a request with a number of its own.
    fn begin(
        &mut self,
        now: Micros,
        (kind, answer): (Kind, Kind),
        payload: &[u8],
        timeout_us: u32,
    ) -> Request {
        self.sequence = self.sequence.wrapping_add(1);
        frame::encode(kind, self.sequence, payload, &mut self.out);
        self.sent = 0;
        self.pump();
        Request {
            kind: answer,
            sequence: self.sequence,
            deadline: now.plus(timeout_us),
            strangers: false,
        }
    }

    /// The request that waited does so no more; the next one waits.
    fn finish(&mut self, result: Result<(), LinkError>) -> Poll<Result<(), LinkError>> {
        self.request = self.ahead.take();
        Poll::Ready(result)
    }

    /// Hands over what the port takes of the request.
    fn pump(&mut self) {
        let rest = self.out.get(self.sent..).unwrap_or(&[]);
        if !rest.is_empty() {
            self.sent += self.port.write(rest);
        }
    }

    /// Reads on until there is an answer, an error, nothing more to read, or [`MOST_READ`] bytes.
    fn poll(&mut self, now: Micros) -> Poll<Result<(), LinkError>> {
        self.pump();
        let Some(request) = self.request else {
            return Poll::Ready(Err(LinkError::Timeout));
        };
        if core::mem::take(&mut self.held)
            && let Some(result) = self.judge(&request)
        {
            return self.finish(result);
        }
        for _ in 0..MOST_READ {
            let Some(byte) = self.port.read() else { break };
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
            Kind::Error => Err(LinkError::Module(payload.first().copied().unwrap_or(0))),
            _ if kind == request.kind => Ok(()),
            _ => Err(LinkError::Answer),
        })
    }
}

impl<P: BytePort> RadarLink for FrameLink<P> {
    fn configure(&mut self, now: Micros, timeout_us: u32) {
        self.send(now, Kind::Configure, Kind::Settings, &[], timeout_us);
    }

    fn poll_settings(&mut self, now: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        self.poll(now).map(|result| {
            result?;
            let payload = self.decoder.frame().map_or(&[][..], |frame| frame.payload);
            let radar = frame::parse_settings(payload).ok_or(LinkError::Answer)?;
            self.captures_ahead = payload.get(ABILITIES).is_some_and(|byte| byte & AHEAD != 0);
            Ok(radar)
        })
    }

    fn trigger(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) {
        let payload = shaft_angle.to_le_bytes();
        self.send(now, Kind::Trigger, Kind::Chirp, &payload, timeout_us);
    }

    fn poll_chirp(&mut self, now: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        self.poll(now).map(|result| {
            result?;
            let payload = self.decoder.frame().map_or(&[][..], |frame| frame.payload);
            if frame::parse_chirp(payload, samples) {
                Ok(())
            } else {
                Err(LinkError::Answer)
            }
        })
    }

    fn wire(&self) -> pace::Wire {
        pace::Wire {
            ahead: self.captures_ahead,
            ..pace::Wire::default()
        }
    }

    fn trigger_ahead(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) -> bool {
        let under_way = self.sent < self.out.len();
        let full = self.ahead.is_some() || under_way;
        if !self.captures_ahead || self.request.is_none() || full {
            return false;
        }
        let payload = shaft_angle.to_le_bytes();
        let kinds = (Kind::Trigger, Kind::Chirp);
        self.ahead = Some(self.begin(now, kinds, &payload, timeout_us));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::VecDeque;
    use std::vec::Vec;

    #[derive(Default)]
    struct Wire {
        incoming: VecDeque<u8>,
        outgoing: Vec<u8>,
        room: usize,
    }

    impl BytePort for Wire {
        fn read(&mut self) -> Option<u8> {
            self.incoming.pop_front()
        }
        fn write(&mut self, bytes: &[u8]) -> usize {
            let n = bytes.len().min(self.room);
            self.outgoing.extend(&bytes[..n]);
            n
        }
    }

    fn link() -> FrameLink<Wire> {
        FrameLink::new(Wire {
            room: 5,
            ..Wire::default()
        })
    }

    fn answer(link: &mut FrameLink<Wire>, kind: Kind, sequence: u16, payload: &[u8]) {
        let mut out = heapless::Vec::<u8, { frame::MAX_FRAME }>::new();
        frame::encode(kind, sequence, payload, &mut out);
        link.port.incoming.extend(out);
    }

    const NOW: Micros = Micros(u32::MAX - 5);

    #[test]
    fn request_goes_out_in_pieces_and_settings_come_back() {
        let mut link = link();
        link.configure(NOW, 1000);
        for _ in 0..4 {
            assert!(link.poll_settings(NOW).is_pending());
        }
        let mut decoder = Decoder::new();
        let last = link.port.outgoing.iter().map(|&b| decoder.push(b)).last();
        assert_eq!(last, Some(Ok(Progress::Complete)));
        assert_eq!(decoder.frame().unwrap().kind, Kind::Configure);
        let radar = RadarConfig::default();
        let payload = frame::settings_payload(&radar);
        answer(&mut link, Kind::Settings, 1, &payload);
        assert_eq!(link.poll_settings(NOW), Poll::Ready(Ok(radar)));
    }

    #[test]
    fn late_and_repeated_chirps_are_not_taken() {
        let mut link = link();
        let mut samples = [Iq::default(); 2];
        link.trigger(NOW, 0, 1000);
        link.trigger(NOW, 250, 1000);
        answer(&mut link, Kind::Chirp, 1, &[9; 8]);
        assert!(link.poll_chirp(NOW, &mut samples).is_pending());
        assert_eq!(
            link.poll_chirp(NOW.plus(1000), &mut samples),
            Poll::Ready(Err(LinkError::Sequence))
        );
        link.trigger(NOW, 500, 1000);
        answer(&mut link, Kind::Chirp, 2, &[9; 8]);
        answer(&mut link, Kind::Chirp, 3, &[1, 0, 2, 0, 3, 0, 4, 0]);
        assert_eq!(link.poll_chirp(NOW, &mut samples), Poll::Ready(Ok(())));
        assert_eq!(samples, [Iq::new(1, 2), Iq::new(3, 4)]);
    }

    fn two_under_way() -> FrameLink<Wire> {
        let mut link = link();
        link.port.room = 100;
        link.trigger(NOW, 0, 1000);
        assert!(!link.trigger_ahead(NOW, 0, 1000), "it never said it could");
        link.configure(NOW, 1000);
        let mut payload = frame::settings_payload(&RadarConfig::default());
        payload[ABILITIES] = AHEAD;
        answer(&mut link, Kind::Settings, 2, &payload);
        assert!(link.poll_settings(NOW).is_ready() && link.wire().ahead);
        link.sequence = 0;
        assert!(
            !link.trigger_ahead(NOW, 0, 1000),
            "there is nothing to be ahead of"
        );
        link.trigger(NOW, 0, 1000);
        assert!(link.trigger_ahead(NOW, 250, 2000));
        assert!(!link.trigger_ahead(NOW, 500, 2000), "two are enough");
        link
    }

    const ONE: [u8; 4] = [1, 0, 2, 0];
    const TWO: [u8; 4] = [3, 0, 4, 0];

    #[test]
    fn two_chirps_under_way_come_one_after_the_other() {
        let mut link = two_under_way();
        let mut samples = [Iq::default()];
        answer(&mut link, Kind::Chirp, 1, &ONE);
        answer(&mut link, Kind::Chirp, 2, &TWO);
        assert_eq!(link.poll_chirp(NOW, &mut samples), Poll::Ready(Ok(())));
        assert_eq!(samples, [Iq::new(1, 2)]);
        assert!(link.trigger_ahead(NOW, 500, 3000));
        assert_eq!(link.poll_chirp(NOW, &mut samples), Poll::Ready(Ok(())));
        assert_eq!(samples, [Iq::new(3, 4)]);
        let late = link.poll_chirp(NOW.plus(3000), &mut samples);
        assert_eq!(late, Poll::Ready(Err(LinkError::Timeout)));
    }

    /// A chirp that is lost costs its own row and no time: the next one shows that it will not come.
    #[test]
    fn a_lost_chirp_costs_its_own_row_alone() {
        let mut samples = [Iq::default()];
        let mut link = two_under_way();
        answer(&mut link, Kind::Chirp, 2, &TWO);
        let lost = Poll::Ready(Err(LinkError::Sequence));
        assert_eq!(link.poll_chirp(NOW, &mut samples), lost);
        assert_eq!(samples, [Iq::default()], "not the other row's samples");
        assert_eq!(link.poll_chirp(NOW, &mut samples), Poll::Ready(Ok(())));
        assert_eq!(samples, [Iq::new(3, 4)]);

        let mut link = two_under_way();
        answer(&mut link, Kind::Chirp, 1, &ONE);
        link.port.incoming[9] ^= 1;
        answer(&mut link, Kind::Chirp, 2, &TWO);
        let damaged = Poll::Ready(Err(LinkError::Frame(FrameError::Crc)));
        assert_eq!(link.poll_chirp(NOW, &mut samples), damaged);
        assert_eq!(link.poll_chirp(NOW, &mut samples), Poll::Ready(Ok(())));
        assert_eq!(samples, [Iq::new(3, 4)]);

        // Each has its own deadline, and late answers are nobody's.
        let mut link = two_under_way();
        let timeout = Poll::Ready(Err(LinkError::Timeout));
        assert_eq!(link.poll_chirp(NOW.plus(1000), &mut samples), timeout);
        answer(&mut link, Kind::Chirp, 1, &ONE);
        assert!(link.poll_chirp(NOW.plus(1001), &mut samples).is_pending());
        answer(&mut link, Kind::Chirp, 2, &TWO);
        let two = link.poll_chirp(NOW.plus(1002), &mut samples);
        assert_eq!((two, samples), (Poll::Ready(Ok(())), [Iq::new(3, 4)]));

        // A new scan asks for settings: what is under way is forgotten.
        let mut link = two_under_way();
        answer(&mut link, Kind::Chirp, 2, &TWO);
        assert_eq!(link.poll_chirp(NOW, &mut samples), lost);
        link.configure(NOW, 1000);
        assert!(link.poll_settings(NOW).is_pending());
    }

    /// A port that always has another byte.
    struct Babble(u64);

    impl BytePort for Babble {
        fn read(&mut self) -> Option<u8> {
            self.0 += 1;
            Some(0)
        }
        fn write(&mut self, bytes: &[u8]) -> usize {
            bytes.len()
        }
    }

    #[test]
    fn a_module_that_never_falls_silent_is_a_timeout() {
        let mut link = FrameLink::new(Babble(0));
        let mut samples = [Iq::default(); 2];
        link.trigger(NOW, 0, 1000);
        assert!(link.port.0 <= u64::from(MOST_READ));
        while link.poll_chirp(NOW.plus(999), &mut samples).is_pending() && link.port.0 < 1 << 20 {}
        let late = link.poll_chirp(NOW.plus(1000), &mut samples);
        assert!(matches!(late, Poll::Ready(Err(_))), "{late:?}");
        assert!(link.port.0 <= (1 << 20) + u64::from(2 * MOST_READ));
    }

    #[test]
    fn every_error_has_its_type() {
        let mut samples = [Iq::default(); 2];
        let mut link = link();
        let mut poll = |link: &mut FrameLink<Wire>, now| link.poll_chirp(now, &mut samples);
        link.trigger(NOW, 0, 1000);
        assert!(poll(&mut link, NOW.plus(999)).is_pending());
        let timeout = Poll::Ready(Err(LinkError::Timeout));
        assert_eq!(poll(&mut link, NOW.plus(1000)), timeout);
        link.trigger(NOW, 0, 1000);
        answer(&mut link, Kind::Chirp, 2, &[0; 8]);
        link.port.incoming[12] ^= 1;
        let crc = Poll::Ready(Err(LinkError::Frame(FrameError::Crc)));
        assert_eq!(poll(&mut link, NOW), crc);
        link.trigger(NOW, 0, 1000);
        answer(&mut link, Kind::Error, 3, &[2]);
        let module = Poll::Ready(Err(LinkError::Module(2)));
        assert_eq!(poll(&mut link, NOW), module);
        for (sequence, kind, length) in [(4, Kind::Settings, 8), (5, Kind::Chirp, 7)] {
            link.trigger(NOW, 0, 1000);
            answer(&mut link, kind, sequence, &[0; 8][..length]);
            let wrong = Poll::Ready(Err(LinkError::Answer));
            assert_eq!(poll(&mut link, NOW), wrong);
        }
    }
}
