//! Binary frames of the radar link.
//!
//! Little-endian throughout, 8 data bits, no parity, 1 stop bit; 1 Mbaud until another rate has been agreed on:
//!
//! | offset | bytes | content |
//! |---|---|---|
//! | 0 | 2 | `0x53 0x52` ("SR"), the beginning of a frame |
//! | 2 | 1 | version of this format, 1 |
//! | 3 | 1 | kind |
//! | 4 | 2 | sequence number |
//! | 6 | 2 | n, length of the payload, at most 1024 |
//! | 8 | n | payload |
//! | 8 + n | 4 | CRC-32 (ISO-HDLC) of everything before it |
//!
//! | kind | from | payload |
//! |---|---|---|
//! | `0x01` configure | scanner | none |
//! | `0x03` program | scanner | swept bandwidth u32 kHz, samples per chirp u16 (0: unchanged), u8: bit 0: chirps begin at the edge of TRIG, chirps per row u8 (0: 1) |
//! | `0x81` settings | module | carrier u32 kHz, swept bandwidth B u32 kHz, samples per chirp Ns u16, fastest rate u8 Mbaud (0: 1), abilities u8 |
//! | `0x04` rate | scanner | u8: 1, 2 or 3 Mbaud |
//! | `0x84` rate set | module | the same; all following bytes are at that rate |
//! | `0x02` trigger | scanner | i32: angle of the mirror's shaft, 0.001° from the horizontal, positive downwards |
//! | `0x82` chirp | module | Ns samples, each I then Q as i16, full scale 32767 |
//! | `0xE0` error | module | u8: 1 not ready, 2 hardware, 3 unknown request |
//!
//! Abilities: bit 0: real samples, two in place of I and Q, Ns such pairs; bit 1: the next chirp is captured
//! while the one before is sent; bit 2: chirps begin at the rising edge of TRIG, and the trigger frame that
//! arrives within 1 ms of it only carries the sequence number; bit 3: several chirps per row, which the module adds
//! ([`super::dwell`]). The answer to program is settings, with the values that are now in force; configure sets
//! the chirps per row back to 1.
//!
//! The module answers each request of the scanner once, with the sequence number of the request. Every request
//! has a new number, also a retry, so that a late or repeated chirp is never assigned to another row. A module
//! sends only on request, and discards a request whose bytes stop for 10 ms. Bytes that are no valid frame are
//! skipped up to the next beginning of a frame.

use super::module::{FrameError, RequestedSettings};
use super::wire::{HEADER, TRAILER};
use crate::Iq;
use crate::config::{MAX_SAMPLES, RadarConfig};
use crate::crc;

/// Version of the frame format, which every frame contains.
pub const VERSION: u8 = 1;
/// Maximum length of a frame's payload, bytes: 256 samples.
pub const MAX_PAYLOAD: usize = 4 * MAX_SAMPLES;
/// Maximum length of a frame, bytes.
pub const MAX_FRAME: usize = HEADER + MAX_PAYLOAD + TRAILER;
const MAGIC: [u8; 2] = *b"SR";

/// Kind of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum FrameKind {
    /// Scanner: requests the settings.
    Configure = 0x01,
    /// Module: its settings.
    Settings = 0x81,
    /// Scanner: requests that the module takes other settings (bandwidth, samples per chirp).
    Program = 0x03,
    /// Scanner: requests another bit rate of the serial wire.
    Rate = 0x04,
    /// Module: confirms the new bit rate, which applies from the next byte on.
    RateSet = 0x84,
    /// Scanner: triggers one chirp.
    Trigger = 0x02,
    /// Module: samples of the chirp.
    Chirp = 0x82,
    /// Module: error code.
    Error = 0xE0,
}

impl FrameKind {
    fn from_byte(byte: u8) -> Option<Self> {
        [
            FrameKind::Configure,
            FrameKind::Settings,
            FrameKind::Program,
            FrameKind::Rate,
            FrameKind::RateSet,
            FrameKind::Trigger,
            FrameKind::Chirp,
            FrameKind::Error,
        ]
        .into_iter()
        .find(|kind| *kind as u8 == byte)
    }
}

/// A complete frame with a correct CRC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Kind of the frame.
    pub kind: FrameKind,
    /// Sequence number, in an answer that of the request.
    pub sequence: u16,
    /// Payload, without header and CRC.
    pub payload: &'a [u8],
}

/// Assembles a frame in `out`, which is cleared first. A payload that does not fit is left out; the receiver
/// then detects an error.
pub fn encode<const N: usize>(
    kind: FrameKind,
    sequence: u16,
    payload: &[u8],
    out: &mut heapless::Vec<u8, N>,
) {
    out.clear();
    let length = payload.len() as u16;
    let [s0, s1] = sequence.to_le_bytes();
    let [l0, l1] = length.to_le_bytes();
    let header = [MAGIC[0], MAGIC[1], VERSION, kind as u8, s0, s1, l0, l1];
    let _ = out.extend_from_slice(&header);
    let _ = out.extend_from_slice(payload);
    let crc = crc::of_parts(&[out]);
    let _ = out.extend_from_slice(&crc.to_le_bytes());
}

/// Optional abilities of a module.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ability {
    /// Maximum bit rate of the serial wire that the module supports, Mbaud.
    pub fastest: u8,
    /// Whether the module can capture a chirp while it sends the one before.
    pub ahead: bool,
    /// Whether the module's chirps can begin at the edge of the TRIG pin.
    pub pin: bool,
    /// Whether the module can add several chirps per row.
    pub adds: bool,
}

/// Bits of the abilities, the last byte of a settings frame: real samples (`REAL`), a chirp can be captured
/// while the one before is sent (`AHEAD`), chirps begin at the edge of TRIG (`PIN`), chirps can be added (`ADDS`).
const REAL: u8 = 1;
const AHEAD: u8 = 2;
const PIN: u8 = 4;
const ADDS: u8 = 8;

impl Ability {
    /// Abilities of a module without any option: 1 Mbaud, no chirp ahead, no TRIG pin, one chirp per row.
    pub const NONE: Self = Self {
        fastest: 1,
        ahead: false,
        pin: false,
        adds: false,
    };
}

/// Returns the payload of a settings frame.
pub fn settings_payload(radar: &RadarConfig, ability: Ability) -> [u8; 12] {
    let [c0, c1, c2, c3] = radar.carrier_khz.to_le_bytes();
    let [b0, b1, b2, b3] = radar.bandwidth_khz.to_le_bytes();
    let [n0, n1] = radar.samples.to_le_bytes();
    let bit = |set: bool, bit: u8| if set { bit } else { 0 };
    let abilities = bit(radar.real, REAL)
        | bit(ability.ahead, AHEAD)
        | bit(ability.pin, PIN)
        | bit(ability.adds, ADDS);
    let fastest = ability.fastest;
    [c0, c1, c2, c3, b0, b1, b2, b3, n0, n1, fastest, abilities]
}

/// Parses the payload of a settings frame; `None` if its length is wrong.
pub fn parse_settings(payload: &[u8]) -> Option<(RadarConfig, Ability)> {
    let &[c0, c1, c2, c3, b0, b1, b2, b3, n0, n1, fastest, abilities] = payload else {
        return None;
    };
    let radar = RadarConfig {
        carrier_khz: u32::from_le_bytes([c0, c1, c2, c3]),
        bandwidth_khz: u32::from_le_bytes([b0, b1, b2, b3]),
        samples: u16::from_le_bytes([n0, n1]),
        real: abilities & REAL != 0,
    };
    let ability = Ability {
        fastest: fastest.max(1),
        ahead: abilities & AHEAD != 0,
        pin: abilities & PIN != 0,
        adds: abilities & ADDS != 0,
    };
    Some((radar, ability))
}

/// Returns the payload of a program frame.
pub fn requested_payload(requested: &RequestedSettings) -> [u8; 8] {
    let [b0, b1, b2, b3] = requested.bandwidth_khz.to_le_bytes();
    let [n0, n1] = requested.samples.to_le_bytes();
    // A module that does not know chirps per row expects a 0.
    let chirps = match requested.chirps {
        1 => 0,
        chirps => chirps,
    };
    [b0, b1, b2, b3, n0, n1, u8::from(requested.pin), chirps]
}

/// Returns the chirps per row that a program frame requests; `None` for another payload.
pub fn requested_chirps(payload: &[u8]) -> Option<u8> {
    let &[_, _, _, _, _, _, _, chirps] = payload else {
        return None;
    };
    Some(chirps.max(1))
}

/// Parses a chirp's payload into `samples`; false if the number of samples differs.
pub fn parse_chirp(payload: &[u8], samples: &mut [Iq]) -> bool {
    let (chunks, rest) = payload.as_chunks::<4>();
    if !rest.is_empty() || chunks.len() != samples.len() {
        return false;
    }
    for (sample, &[i0, i1, q0, q1]) in samples.iter_mut().zip(chunks) {
        *sample = Iq::new(i16::from_le_bytes([i0, i1]), i16::from_le_bytes([q0, q1]));
    }
    true
}

/// State of a [`Decoder`] after a byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// The frame is not complete.
    Partial,
    /// The frame is complete: [`Decoder::frame`] returns it.
    Complete,
}

/// Decoder of frames in a stream of bytes.
#[derive(Debug)]
pub struct Decoder {
    bytes: heapless::Vec<u8, MAX_FRAME>,
    total: usize,
}

impl Decoder {
    /// Creates a decoder that waits for the beginning of a frame.
    pub const fn new() -> Self {
        Self {
            bytes: heapless::Vec::new(),
            total: 0,
        }
    }

    /// Discards the bytes received so far.
    pub fn reset(&mut self) {
        self.bytes.clear();
        self.total = 0;
    }

    /// Takes one byte, and returns whether it completes a frame. After an error the decoder waits for the next
    /// beginning of a frame.
    pub fn push(&mut self, byte: u8) -> Result<Progress, FrameError> {
        if self.total != 0 && self.bytes.len() >= self.total {
            self.reset();
        }
        match (self.bytes.len(), byte) {
            // "SSR" contains a beginning: the second "S" may be the first byte.
            (0 | 1, 0x53) => {
                self.reset();
                let _ = self.bytes.push(byte);
                return Ok(Progress::Partial);
            }
            (1, 0x52) => {}
            (0 | 1, _) => {
                self.reset();
                return Ok(Progress::Partial);
            }
            _ => {}
        }
        let _ = self.bytes.push(byte);
        if self.bytes.len() == HEADER {
            self.begin_payload().inspect_err(|_| self.reset())?;
        }
        if self.total != 0 && self.bytes.len() == self.total {
            return self
                .check_crc()
                .map(|()| Progress::Complete)
                .inspect_err(|_| self.reset());
        }
        Ok(Progress::Partial)
    }

    fn begin_payload(&mut self) -> Result<(), FrameError> {
        let &[_, _, version, kind, _, _, l0, l1] = self.bytes.as_slice() else {
            return Err(FrameError::Length);
        };
        if version != VERSION {
            return Err(FrameError::Version);
        }
        if FrameKind::from_byte(kind).is_none() {
            return Err(FrameError::Kind);
        }
        let length = usize::from(u16::from_le_bytes([l0, l1]));
        if length > MAX_PAYLOAD {
            return Err(FrameError::Length);
        }
        self.total = HEADER + length + TRAILER;
        Ok(())
    }

    fn check_crc(&self) -> Result<(), FrameError> {
        let body = self.bytes.len().saturating_sub(TRAILER);
        let (body, trailer) = self
            .bytes
            .split_at_checked(body)
            .ok_or(FrameError::Length)?;
        if trailer == crc::of_parts(&[body]).to_le_bytes() {
            Ok(())
        } else {
            Err(FrameError::Crc)
        }
    }

    /// Returns the frame that the last byte completed; `None` if it completed none.
    pub fn frame(&self) -> Option<Frame<'_>> {
        if self.total == 0 || self.bytes.len() != self.total {
            return None;
        }
        let &[_, _, _, kind, s0, s1, _, _] = self.bytes.get(..HEADER)? else {
            return None;
        };
        Some(Frame {
            kind: FrameKind::from_byte(kind)?,
            sequence: u16::from_le_bytes([s0, s1]),
            payload: self.bytes.get(HEADER..self.total - TRAILER)?,
        })
    }
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn frame(kind: FrameKind, sequence: u16, payload: &[u8]) -> Vec<u8> {
        let mut out = heapless::Vec::<u8, MAX_FRAME>::new();
        encode(kind, sequence, payload, &mut out);
        out.to_vec()
    }

    type Found = Result<(FrameKind, u16, Vec<u8>), FrameError>;

    /// Returns all frames and errors in a stream of bytes.
    fn decode(bytes: &[u8]) -> Vec<Found> {
        let mut decoder = Decoder::new();
        let mut found = Vec::new();
        for &byte in bytes {
            match decoder.push(byte) {
                Ok(Progress::Partial) => {}
                Ok(Progress::Complete) => {
                    let frame = decoder.frame().unwrap();
                    found.push(Ok((frame.kind, frame.sequence, frame.payload.to_vec())));
                }
                Err(error) => found.push(Err(error)),
            }
        }
        found
    }

    #[test]
    fn layout_is_as_documented() {
        let bytes = frame(FrameKind::Trigger, 0x0201, &(-20_000_i32).to_le_bytes());
        assert_eq!(
            bytes[..12],
            [0x53, 0x52, 1, 2, 1, 2, 4, 0, 0xE0, 0xB1, 0xFF, 0xFF]
        );
        // The check value of the CRC fixes polynomial, reflection and final inversion.
        assert_eq!(crc::of_parts(&[b"123456789"]), 0xCBF4_3926);
        assert_eq!(bytes[12..], crc::of_parts(&[&bytes[..12]]).to_le_bytes());
    }

    #[test]
    fn wrong_headers_are_named_and_skipped() {
        let good = frame(FrameKind::Error, 7, &[2]);
        for (offset, value, error) in [
            (2, 9, FrameError::Version),
            (3, 0x77, FrameError::Kind),
            (7, 0x40, FrameError::Length),
            (9, 0x40, FrameError::Crc),
        ] {
            let mut bad = good.clone();
            bad[offset] = value;
            bad.extend(&good);
            let found = decode(&bad);
            assert_eq!(found[0], Err(error));
            assert_eq!(*found.last().unwrap(), Ok((FrameKind::Error, 7, vec![2])));
        }
    }

    #[test]
    fn settings_round_trip() {
        for (fastest, ahead, pin, real) in [(1, false, true, true), (3, true, false, false)] {
            let radar = RadarConfig {
                real,
                ..RadarConfig::default()
            };
            let ability = Ability {
                fastest,
                ahead,
                pin,
                adds: ahead,
            };
            let payload = settings_payload(&radar, ability);
            assert_eq!(parse_settings(&payload), Some((radar, ability)));
        }
        assert_eq!(parse_settings(&[0; 11]), None);
    }

    #[test]
    fn a_request_for_one_chirp_per_row_is_the_frame_of_earlier_firmware() {
        let mut requested = RequestedSettings {
            samples: 128,
            ..RequestedSettings::DEFAULT
        };
        let payload = requested_payload(&requested);
        assert_eq!(payload, [0, 0, 0, 0, 128, 0, 0, 0]);
        assert_eq!(requested_chirps(&payload), Some(1));
        requested.chirps = 16;
        assert_eq!(requested_payload(&requested)[7], 16);
        assert_eq!(requested_chirps(&requested_payload(&requested)), Some(16));
        assert_eq!(requested_chirps(&[16; 7]), None);
    }

    proptest! {
        #[test]
        fn frames_survive_garbage_between_them(
            sequence: u16,
            payload in proptest::collection::vec(any::<u8>(), 0..MAX_PAYLOAD),
            garbage in proptest::collection::vec(0_u8..0x53, 0..40),
        ) {
            let mut bytes = garbage.clone();
            bytes.extend([0x53]);
            bytes.extend(frame(FrameKind::Chirp, sequence, &payload));
            bytes.extend(&garbage);
            bytes.extend(frame(FrameKind::Settings, 1, &[]));
            let found = decode(&bytes);
            prop_assert_eq!(found.len(), 2);
            prop_assert_eq!(&found[0], &Ok((FrameKind::Chirp, sequence, payload)));
        }

        #[test]
        fn any_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..4000)) {
            decode(&bytes);
        }

        #[test]
        fn a_flipped_bit_is_noticed(bit in 0_usize..(8 * 20)) {
            let mut bytes = frame(FrameKind::Chirp, 3, &[1, 2, 3, 4, 5, 6, 7, 8]);
            bytes[bit / 8] ^= 1 << (bit % 8);
            prop_assert!(!decode(&bytes).iter().any(Result::is_ok));
        }

        #[test]
        fn chirps_round_trip(parts in proptest::collection::vec(any::<(i16, i16)>(), 0..=256)) {
            let samples: Vec<Iq> = parts.iter().map(|&(i, q)| Iq::new(i, q)).collect();
            let payload: Vec<u8> =
                parts.iter().flat_map(|(i, q)| [i.to_le_bytes(), q.to_le_bytes()].concat()).collect();
            let mut read = vec![Iq::default(); samples.len()];
            prop_assert!(parse_chirp(&payload, &mut read));
            prop_assert_eq!(&read, &samples);
            let mut longer = vec![Iq::default(); samples.len() + 1];
            prop_assert!(!parse_chirp(&payload, &mut longer));
        }
    }
}
