//! Radar module with the frames of the link, at the other end of a serial port.
//!
//! In: requests as bytes. Out: answers as frames, in the time of chirp and wire, with faults on command: of all answers,
//! of those to single triggers, or random ones.

use std::collections::BTreeMap;

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use stairscan::config::RadarConfig;
use stairscan::signal::radar::frame::{self, Ability, Decoder, FrameKind, MAX_FRAME, Progress};

use super::port::{DEVICE, Device, FIRST_BAUD, Wires};

/// Bit rates that module and scanner may agree on, baud.
pub const RATES: &[u32] = &[1_000_000, 2_000_000, 3_000_000];
/// Baud in a unit of the frames' bit rates.
const MBAUD: u32 = 1_000_000;
/// Time by which a late answer is delayed, µs.
const LATE_US: u64 = 70_000;
/// Time for which an edge of TRIG waits for its trigger frame, µs.
const EDGE_US: u64 = 1_000;
/// Index of the byte that a damaged answer has wrong.
const WRONG_BYTE: usize = 9;

/// Fault of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnswerFault {
    /// No answer.
    Lost,
    /// Answer with a wrong bit.
    Corrupt,
    /// Answer after the scanner's timeout; only where bytes take time.
    Late,
    /// Error answer.
    Error,
    /// A copy of the chirp before, and then the answer.
    Repeat,
    /// Answer to an older request.
    Stale,
    /// Answer that is too short.
    Short,
    /// Another kind of frame.
    Other,
    /// Other settings with which scanning is possible, and chirps that fit them.
    Changed,
    /// Settings with which scanning is impossible, and chirps that fit them.
    Absurd,
    /// Bytes of the beginnings of frames before the answer.
    Babbling,
}

/// A captured chirp.
#[derive(Clone, Copy, Debug)]
pub struct Captured {
    /// Shaft angle in the trigger, 0.001°.
    pub angle: i32,
    /// Time at which its capture began.
    pub begin: u64,
    /// Time at which its capture ended.
    pub end: u64,
}

/// Simulated radar module. Each sample of a chirp is its trigger's angle: the lower half as I, the upper as Q.
#[derive(Debug)]
pub struct FramedModule {
    /// Settings in its answers.
    pub radar: RadarConfig,
    /// Abilities in its answers.
    pub ability: Ability,
    /// Duration of a chirp, µs.
    pub chirp_us: u64,
    /// Number of chirps that it captures for each row.
    pub chirps: u8,
    /// Fault of every answer.
    pub fault: Option<AnswerFault>,
    /// Faults of the answers to single triggers, by number of the trigger, from 0.
    pub faults: BTreeMap<u32, AnswerFault>,
    /// Reciprocal of the share of the frames that the wire damages, loses or repeats; 0: none.
    pub trouble: u32,
    /// Number, from 0, of the trigger after which the module falls back to its first bit rate; `None`: it never does.
    pub reset_at: Option<u32>,
    /// Number of triggers.
    pub triggers: u32,
    /// Number of chirps whose trigger came without an edge on TRIG.
    pub without_edge: u32,
    /// Captured chirps, in order.
    pub captures: Vec<Captured>,
    /// Kinds of the requests, in order.
    pub asked: Vec<FrameKind>,
    decoder: Decoder,
    /// Last answer without its fault, and last chirp.
    before: Vec<u8>,
    chirp: Vec<u8>,
    random: Xoshiro128PlusPlus,
}

/// Returns a frame as bytes.
pub fn encode(kind: FrameKind, sequence: u16, payload: &[u8]) -> Vec<u8> {
    let mut out = heapless::Vec::<u8, MAX_FRAME>::new();
    frame::encode(kind, sequence, payload, &mut out);
    out.to_vec()
}

impl FramedModule {
    /// Creates a module with the settings `radar`; `seed` selects random faults.
    pub fn new(radar: RadarConfig, ability: Ability, seed: u64) -> Self {
        Self {
            radar,
            ability,
            chirp_us: 1_000,
            chirps: 1,
            fault: None,
            faults: BTreeMap::new(),
            trouble: 0,
            reset_at: None,
            triggers: 0,
            without_edge: 0,
            captures: Vec::new(),
            asked: Vec::new(),
            decoder: Decoder::new(),
            before: Vec::new(),
            chirp: Vec::new(),
            random: Xoshiro128PlusPlus::seed_from_u64(seed),
        }
    }

    fn below(&mut self, end: usize) -> usize {
        self.random.next_u32() as usize % end
    }

    /// Returns the settings of the next answers.
    fn settings(&self) -> RadarConfig {
        match self.fault {
            Some(AnswerFault::Changed) => RadarConfig {
                samples: 2 * self.radar.samples,
                ..self.radar
            },
            Some(AnswerFault::Absurd) => RadarConfig {
                samples: 257,
                bandwidth_khz: 0,
                ..self.radar
            },
            _ => self.radar,
        }
    }

    /// Handles a complete request, received at time `at`.
    fn request(&mut self, at: u64, wires: &mut Wires) {
        let Some(frame) = self.decoder.frame() else {
            return;
        };
        let (kind, sequence, payload) = (frame.kind, frame.sequence, frame.payload.to_vec());
        self.asked.push(kind);
        match kind {
            FrameKind::Configure | FrameKind::Program => {
                let chirps = frame::requested_chirps(&payload).filter(|_| self.ability.adds);
                self.chirps = chirps.unwrap_or(1);
                let settings = frame::settings_payload(&self.settings(), self.ability);
                let answer = (FrameKind::Settings, sequence, &settings[..]);
                self.answer(at, answer, self.fault, wires);
            }
            FrameKind::Rate => {
                let answer = (FrameKind::RateSet, sequence, &payload[..]);
                self.answer(at, answer, self.fault, wires);
                wires.rates[DEVICE] = u32::from(payload[0]) * MBAUD;
            }
            _ => self.trigger(at, sequence, &payload, wires),
        }
    }

    fn trigger(&mut self, at: u64, sequence: u16, angle: &[u8], wires: &mut Wires) {
        let edge = wires.edge.take().filter(|_| self.ability.pin);
        let edge = edge.filter(|edge| at - edge <= wires.us(EDGE_US));
        self.without_edge += u32::from(self.ability.pin && edge.is_none());
        let begin = edge.unwrap_or(at);
        let end = begin + wires.us(self.chirp_us * u64::from(self.chirps));
        self.captures.push(Captured {
            angle: angle.try_into().map_or(0, i32::from_le_bytes),
            begin,
            end,
        });
        if self.reset_at == Some(self.triggers) {
            wires.rates[DEVICE] = FIRST_BAUD;
        }
        let own = self.faults.get(&self.triggers).copied();
        self.triggers += 1;
        // As many samples as fit a frame.
        let samples = usize::from(self.settings().samples).min(frame::MAX_PAYLOAD / 4);
        let payload = angle.repeat(samples);
        let answer = (FrameKind::Chirp, sequence, &payload[..]);
        self.answer(end, answer, own.or(self.fault), wires);
        self.chirp = encode(FrameKind::Chirp, sequence, &payload);
    }

    /// Sends an answer from time `from` on, with its fault.
    fn answer(
        &mut self,
        from: u64,
        (kind, sequence, payload): (FrameKind, u16, &[u8]),
        fault: Option<AnswerFault>,
        wires: &mut Wires,
    ) {
        let mut bytes = encode(kind, sequence, payload);
        let mut from = from;
        match fault {
            None | Some(AnswerFault::Changed | AnswerFault::Absurd) => {}
            Some(AnswerFault::Lost) => return,
            Some(AnswerFault::Corrupt) => bytes[WRONG_BYTE] ^= 4,
            Some(AnswerFault::Late) => from += wires.us(LATE_US),
            Some(AnswerFault::Error) => bytes = encode(FrameKind::Error, sequence, &[2]),
            Some(AnswerFault::Repeat) => drop(bytes.splice(0..0, self.chirp.clone())),
            Some(AnswerFault::Stale) => bytes = encode(kind, sequence.wrapping_sub(1), payload),
            Some(AnswerFault::Short) => {
                bytes = encode(kind, sequence, &payload[..payload.len() / 2]);
            }
            Some(AnswerFault::Other) => bytes = encode(FrameKind::Configure, sequence, payload),
            Some(AnswerFault::Babbling) => {
                let noise = [0x53, 0x52, 9, 0x53, 0, 0x53, 0x52, 1, 1];
                drop(bytes.splice(0..0, noise));
            }
        }
        let clean = bytes.clone();
        if self.trouble > 0 && self.random.next_u32().is_multiple_of(self.trouble) {
            self.damage(&mut bytes);
        }
        self.before = clean;
        wires.send(from, &bytes);
    }

    /// Gives an answer a wrong bit, cuts it short, loses it, or puts noise or a copy of the frame before ahead of it.
    fn damage(&mut self, bytes: &mut Vec<u8>) {
        match self.below(5) {
            0 => {
                let (at, bit) = (self.below(bytes.len()), self.below(8));
                bytes[at] ^= 1 << bit;
            }
            1 => bytes.truncate(self.below(bytes.len())),
            2 => bytes.clear(),
            3 => drop(bytes.splice(0..0, self.before.clone())),
            _ => {
                let noise: Vec<u8> = (0..20).map(|_| self.random.next_u32() as u8).collect();
                drop(bytes.splice(0..0, noise));
            }
        }
    }
}

impl Device for FramedModule {
    fn receive(&mut self, byte: u8, at: u64, wires: &mut Wires) {
        if self.decoder.push(byte) == Ok(Progress::Complete) {
            self.request(at, wires);
        }
    }

    fn receive_break(&mut self, wires: &mut Wires) {
        wires.rates[DEVICE] = FIRST_BAUD;
        self.decoder.reset();
    }
}
