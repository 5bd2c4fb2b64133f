//! Input of the radar link: arbitrary bytes, complete frames, frames with other numbers, silence.
//!
//! An operation is a byte with its arguments:
//!
//! | byte | arguments | operation |
//! |---|---|---|
//! | 0 | u16 | the scanner requests the settings, with this timeout, ms |
//! | 1 | u16 | the scanner triggers a chirp of 4 samples, with this timeout, ms |
//! | 2 | count, bytes | delivers these bytes |
//! | 3 | i8, kind, count, payload | delivers a frame with a correct CRC; the offset is added to the request's number |
//! | 4 | u16 | advances the time, ms |

use std::task::Poll;

use stairscan::Iq;
use stairscan::scanner::Micros;
use stairscan::signal::radar::FrameLink;
use stairscan::signal::radar::RadarModule;
use stairscan::signal::radar::frame::{self, Decoder, FrameKind, MAX_FRAME, Progress};
use stairscan::signal::radar::module::RequestedSettings;
use stairscan::signal::radar::wire::TRAILER;
use testbed::{Port, Shared};

use crate::input::Input;

/// Number of samples of the requested chirps.
const SAMPLES: usize = 4;
/// All kinds of frames, and one invalid kind.
pub const KINDS: [u8; 9] = [0x81, 0x82, 0xE0, 0x01, 0x02, 0x77, 0x84, 0x03, 0x04];

/// Pending request of the scanner.
#[derive(Clone, Copy, PartialEq)]
enum Waiting {
    Nothing,
    Settings,
    Chirp,
}

/// The link, and the module's view of it.
struct Bench {
    link: FrameLink<Shared<Port>>,
    wire: Shared<Port>,
    now: Micros,
    waiting: Waiting,
    until: Micros,
    /// Number of the last request.
    sequence: u16,
}

/// Returns a frame of any kind with a correct CRC.
fn encode(kind: u8, sequence: u16, payload: &[u8]) -> Vec<u8> {
    let mut out = heapless::Vec::<u8, MAX_FRAME>::new();
    frame::encode(FrameKind::Settings, sequence, payload, &mut out);
    let mut bytes = out.to_vec();
    bytes[3] = kind;
    let body = bytes.len() - TRAILER;
    let crc = stairscan::crc::CRC32.checksum(&bytes[..body]);
    bytes[body..].copy_from_slice(&crc.to_le_bytes());
    bytes
}

impl Bench {
    fn ask(&mut self, what: Waiting, timeout_ms: u16) {
        let timeout = 1000 * u32::from(timeout_ms).max(1);
        self.sequence = self.sequence.wrapping_add(1);
        self.until = self.now.plus(timeout);
        self.waiting = what;
        match what {
            Waiting::Chirp => self.link.trigger(self.now, -20_000, timeout),
            _ => self
                .link
                .program(self.now, &RequestedSettings::DEFAULT, timeout),
        }
        assert!(
            self.wire.get().wires.incoming.is_empty(),
            "an old answer is kept"
        );
    }

    /// Polls until all input is processed. An answer or the timeout ends the request.
    fn poll(&mut self) {
        let ready = match self.waiting {
            Waiting::Nothing => return,
            Waiting::Settings => self.link.settings(self.now).map(|answer| answer.is_ok()),
            Waiting::Chirp => {
                let mut samples = [Iq::default(); SAMPLES];
                self.link
                    .poll(self.now, &mut samples)
                    .map(|answer| answer.is_ok())
            }
        };
        match ready {
            Poll::Ready(_) => self.waiting = Waiting::Nothing,
            Poll::Pending => assert!(!self.now.reached(self.until), "waits for ever"),
        }
    }

    /// Delivers a complete frame. Checks that one with another sequence number than the request's is not
    /// accepted.
    fn answer(&mut self, off: i8, kind: u8, payload: &[u8]) {
        let sequence = self.sequence.wrapping_add_signed(off.into());
        // Earlier bytes may be the beginning of a frame that includes this one.
        let clean = self.wire.get().wires.incoming.is_empty();
        self.wire.get().type_in(encode(kind, sequence, payload));
        let waiting = self.waiting;
        self.poll();
        let wanted = match waiting {
            Waiting::Nothing => return,
            Waiting::Settings => kind == FrameKind::Settings as u8 && payload.len() == 12,
            Waiting::Chirp => kind == FrameKind::Chirp as u8 && payload.len() == 4 * SAMPLES,
        };
        if clean && off != 0 && wanted {
            let taken = self.waiting == Waiting::Nothing;
            assert!(
                !taken || self.now.reached(self.until),
                "another row's chirp is taken"
            );
        }
    }
}

/// Checks that every complete frame in a stream, when encoded, equals the last bytes of the input.
fn decode(bytes: &[u8]) {
    let mut decoder = Decoder::new();
    for (k, &byte) in bytes.iter().enumerate() {
        if decoder.push(byte) == Ok(Progress::Complete) {
            let frame = decoder.frame().expect("a complete frame");
            let again = encode(frame.kind as u8, frame.sequence, frame.payload);
            assert!(bytes[..=k].ends_with(&again));
        }
    }
}

/// Runs the operations.
pub fn run(data: &[u8]) {
    decode(data);
    let wire: Shared<Port> = Shared::default();
    // Requests are sent in pieces.
    wire.get().wires.room = 5;
    let mut bench = Bench {
        link: FrameLink::new(wire.clone()),
        wire,
        now: Micros(u32::MAX - 500_000),
        waiting: Waiting::Nothing,
        until: Micros(0),
        sequence: 0,
    };
    let mut input = Input(data);
    while !input.is_empty() {
        match input.byte() % 5 {
            0 => bench.ask(Waiting::Settings, input.short()),
            1 => bench.ask(Waiting::Chirp, input.short()),
            2 => {
                let bytes = input.counted();
                bench.wire.get().type_in(bytes);
            }
            3 => {
                let (off, kind) = (input.byte() as i8, input.byte());
                let kind = KINDS[usize::from(kind) % KINDS.len()];
                bench.answer(off, kind, input.counted());
            }
            _ => bench.now = bench.now.plus(1000 * u32::from(input.short())),
        }
        bench.poll();
    }
}
