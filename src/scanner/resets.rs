//! Number of resets that followed one another, which boot loader and image exchange: three words at the top of SRAM.
//!
//! The loader counts each reset, the image sets the count to 0 once it has run for a minute. After a loss of power the
//! words are no count, as their checksum says.

use crate::crc;

/// Number of 32-bit words of a count.
pub const WORDS: usize = 3;
/// First word of a count, which identifies it as one.
const MAGIC: u32 = u32::from_le_bytes(*b"STRC");

/// Time of operation, µs, after which a reset no longer follows the one before: 60 s.
pub const SURVIVED_US: u32 = 60_000_000;

/// Number of resets, each less than a minute of operation after the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resets(pub u32);

impl Resets {
    /// Returns the words of the count: identification, count, and CRC-32 of both.
    pub fn words(self) -> [u32; WORDS] {
        let Self(count) = self;
        [MAGIC, count, crc::of_words(&[MAGIC, count])]
    }

    /// Returns the count that `words` contain; `None` if they are none.
    pub fn from_words(words: [u32; WORDS]) -> Option<Self> {
        let [_, count, _] = words;
        Some(Self(count)).filter(|resets| resets.words() == words)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_count_comes_back_and_one_bit_makes_it_none() {
        for count in [0, 1, 2, 3, u32::MAX] {
            let words = Resets(count).words();
            assert_eq!(Resets::from_words(words), Some(Resets(count)));
            for bit in 0..32 * WORDS {
                let mut bad = words;
                bad[bit / 32] ^= 1 << (bit % 32);
                assert_eq!(Resets::from_words(bad), None, "bit {bit}");
            }
        }
        for blank in [0, u32::MAX] {
            assert_eq!(Resets::from_words([blank; WORDS]), None);
        }
    }
}
