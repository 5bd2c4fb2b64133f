//! Common parts of all sentences: frame, CRC and lengths.

use crate::crc;

/// Maximum length of a sentence with its line end, bytes.
pub const MAX_SENTENCE: usize = 224;

/// Text of one sentence, CR LF included.
pub type Line = heapless::String<MAX_SENTENCE>;

/// Beginning of every sentence of the scanner.
pub const PREFIX: &str = "$PSTR,";

/// Returns the CRC-32 (ISO-HDLC) of a sentence's body, between `$` and `*`.
pub fn crc32(body: &str) -> u32 {
    crc::of_parts(&[body.as_bytes()])
}

/// A length in units of 0.1 mm, as the sentences have it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Tenths(pub i32);

impl Tenths {
    /// Maximum magnitude of a length from metres, 0.1 mm: 100 m.
    const LIMIT: i32 = 1_000_000;

    /// Rounds metres to a tenth of a millimetre, half away from zero; saturates at ±100 m, NaN becomes 0.
    pub fn from_metres(metres: f32) -> Self {
        let scaled = metres * 10_000.0;
        let rounded = scaled + if scaled < 0.0 { -0.5 } else { 0.5 };
        Self((rounded as i32).clamp(-Self::LIMIT, Self::LIMIT))
    }

    /// Returns the length in metres.
    pub fn metres(self) -> f32 {
        self.0 as f32 / 10_000.0
    }
}
