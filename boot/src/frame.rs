//! Frames between host and loader over the report port: 8 data bits, no parity, 1 stop bit, 115,200 baud until another rate
//! has been agreed on. Little-endian.
//!
//! | offset | bytes | what |
//! |---|---|---|
//! | 0 | 2 | `SU`, where a frame begins |
//! | 2 | 1 | kind |
//! | 3 | 1 | sequence number, which the answer repeats |
//! | 4 | 2 | n, length of the payload, at most 1028 |
//! | 6 | n | payload |
//! | 6 + n | 4 | CRC-32 (ISO-HDLC) of everything before it |
//!
//! | kind | request | answer (kind + 0x80) |
//! |---|---|---|
//! | `0x01` hello | none, or the host's version of the protocol, one byte | [`crate::receive::Info`] |
//! | `0x02` rate | u32 baud | code; what follows is at that rate |
//! | `0x03` begin | header, 144 bytes | code, u32: the offset that the payload goes on at |
//! | `0x04` data | u32 offset, up to 1024 bytes | code, u32: the offset that the payload goes on at |
//! | `0x05` finish | none | code; the loader then resets the chip, and the image is on trial |
//! | `0x06` boot | none | code; the loader then resets the chip |
//! | `0x07` back | none | code; the loader then resets the chip, and the image before runs |
//!
//! The code is one byte: 0, or a [`crate::refusal::Refusal`].

use stairscan::crc;

/// Where a frame begins.
const MAGIC: [u8; 2] = *b"SU";
/// Bytes before the payload.
const HEAD: usize = 6;
/// Bytes of a checksum.
const TAIL: usize = 4;
/// Payload bytes of an image in one frame.
pub const CHUNK: usize = 1024;
/// Longest payload: an offset and a chunk.
pub const MAX_PAYLOAD: usize = 4 + CHUNK;
/// Longest frame.
pub const MAX_FRAME: usize = HEAD + MAX_PAYLOAD + TAIL;
/// Bit that distinguishes an answer's kind from its request's.
pub const ANSWER: u8 = 0x80;

/// Kind of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Who is there?
    Hello = 0x01,
    /// Another rate.
    Rate = 0x02,
    /// A new image.
    Begin = 0x03,
    /// A piece of it.
    Data = 0x04,
    /// The image is whole.
    Finish = 0x05,
    /// Leave the loader.
    Boot = 0x06,
    /// Back to the image before.
    Back = 0x07,
}

impl Kind {
    /// Returns the request of this byte.
    pub fn from_byte(byte: u8) -> Option<Self> {
        use Kind::{Back, Begin, Boot, Data, Finish, Hello, Rate};
        [Hello, Rate, Begin, Data, Finish, Boot, Back]
            .into_iter()
            .find(|kind| *kind as u8 == byte)
    }
}

/// A whole frame whose CRC is right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Its kind.
    pub kind: u8,
    /// Its sequence number.
    pub sequence: u8,
    /// Its payload.
    pub payload: &'a [u8],
}

/// Puts a frame together; returns how many bytes of `out` it takes, 0 for a payload that is too long.
pub fn encode(frame: Frame<'_>, out: &mut [u8; MAX_FRAME]) -> usize {
    let length = frame.payload.len();
    if length > MAX_PAYLOAD {
        return 0;
    }
    let [m0, m1] = MAGIC;
    let [l0, l1] = (length as u16).to_le_bytes();
    let head = [m0, m1, frame.kind, frame.sequence, l0, l1];
    let crc = crc::of_parts(&[&head, frame.payload]).to_le_bytes();
    let all = head.iter().chain(frame.payload).chain(&crc);
    out.iter_mut().zip(all).for_each(|(to, from)| *to = *from);
    HEAD + length + TAIL
}

/// Puts frames together from a stream of bytes. What is no frame is skipped up to the next beginning of one.
#[derive(Debug)]
pub struct Decoder {
    bytes: [u8; MAX_FRAME],
    count: usize,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// A decoder that waits for the beginning of a frame.
    pub const fn new() -> Self {
        Self {
            bytes: [0; MAX_FRAME],
            count: 0,
        }
    }

    /// Discards a partial frame.
    pub fn reset(&mut self) {
        self.count = 0;
    }

    /// Takes a byte; returns the frame that it completes.
    pub fn push(&mut self, byte: u8) -> Option<Frame<'_>> {
        let begins = MAGIC.get(self.count).is_none_or(|&magic| byte == magic);
        if !begins {
            self.count = 0;
        }
        if begins || MAGIC.first() == Some(&byte) {
            *self.bytes.get_mut(self.count)? = byte;
            self.count += 1;
        }
        let &[_, _, kind, sequence, l0, l1, ref rest @ ..] = &self.bytes;
        let length = usize::from(u16::from_le_bytes([l0, l1]));
        if self.count < HEAD {
            return None;
        }
        if length > MAX_PAYLOAD {
            self.count = 0;
            return None;
        }
        if self.count < HEAD + length + TAIL {
            return None;
        }
        self.count = 0;
        let (payload, behind) = rest.split_at_checked(length)?;
        let head = self.bytes.get(..HEAD)?;
        let crc = crc::of_parts(&[head, payload]).to_le_bytes();
        behind.starts_with(&crc).then_some(Frame {
            kind,
            sequence,
            payload,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_come_back_from_a_stream_with_noise() {
        let mut out = [0; MAX_FRAME];
        let payload = [7; MAX_PAYLOAD];
        for length in [0, 1, 5, MAX_PAYLOAD] {
            let frame = Frame {
                kind: 4,
                sequence: 9,
                payload: &payload[..length],
            };
            let count = encode(frame, &mut out);
            let mut decoder = Decoder::new();
            let noise = b"$PSTR,LIVE*00000000\r\nSSU\xff\xffS";
            let stream = noise.iter().chain(&out[..count]);
            let mut found = 0;
            for &byte in stream {
                if let Some(got) = decoder.push(byte) {
                    assert_eq!(got, frame);
                    found += 1;
                }
            }
            // `SU` with a length of 0xffff is left at once.
            assert!(found <= 1, "{length}");
            found = 0;
            for &byte in &out[..count] {
                found += usize::from(decoder.push(byte).is_some());
            }
            assert_eq!(found, 1, "{length}");
        }
    }

    #[test]
    fn every_flipped_bit_is_found() {
        let mut out = [0; MAX_FRAME];
        let frame = Frame {
            kind: 3,
            sequence: 1,
            payload: b"header",
        };
        let count = encode(frame, &mut out);
        for bit in 0..8 * count {
            let mut bytes = out;
            bytes[bit / 8] ^= 1 << (bit % 8);
            let mut decoder = Decoder::new();
            let got = bytes[..count].iter().any(|&b| decoder.push(b).is_some());
            assert!(!got, "bit {bit}");
        }
    }
}
