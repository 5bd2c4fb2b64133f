//! Requests and results that boot loader and image exchange over a reset: three words at the top of SRAM.
//!
//! They stand outside of everything that either of them initialises (`memory.x`). After a loss of power they are
//! no message, as the checksum says.

use crate::crc;

/// Words of a message.
pub const WORDS: usize = 3;
/// Word that a message begins with.
const MAGIC: u32 = u32::from_le_bytes(*b"STHO");

/// A message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Handover {
    /// Image to loader: take a new image.
    Update = 1,
    /// Image to loader: the self-test has passed on trial.
    Confirm = 2,
    /// Loader to image: it is on trial.
    Trial = 3,
}

impl Handover {
    /// The words of the message.
    pub fn words(self) -> [u32; WORDS] {
        let kind = self as u32;
        [MAGIC, kind, crc::of_words(&[MAGIC, kind])]
    }

    /// The message of these words, if they are one.
    pub fn from_words(words: [u32; WORDS]) -> Option<Self> {
        [Self::Update, Self::Confirm, Self::Trial]
            .into_iter()
            .find(|message| message.words() == words)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_comes_back_and_one_bit_makes_it_none() {
        for message in [Handover::Update, Handover::Confirm, Handover::Trial] {
            let words = message.words();
            assert_eq!(Handover::from_words(words), Some(message));
            for bit in 0..32 * WORDS {
                let mut bad = words;
                bad[bit / 32] ^= 1 << (bit % 32);
                assert_eq!(Handover::from_words(bad), None, "bit {bit}");
            }
        }
        for blank in [0, u32::MAX] {
            assert_eq!(Handover::from_words([blank; WORDS]), None);
        }
    }
}
