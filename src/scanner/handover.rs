//! Requests and results that boot loader and image exchange over a reset: three words at the top of SRAM.
//!
//! They stand outside of everything that either of them initialises (`memory.x`). After a loss of power they are
//! no message, as the checksum says.

use crate::crc;

/// Number of 32-bit words of a message.
pub const WORDS: usize = 3;
/// First word of a message, which identifies it as one.
const MAGIC: u32 = u32::from_le_bytes(*b"STHO");

/// Message that boot loader and image leave for each other over a reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Handover {
    /// Image to boot loader: take a new image.
    Update = 1,
    /// Image to boot loader: the self-test of the image on trial has passed, so confirm this image.
    Confirm = 2,
    /// Boot loader to image: the image is on trial until it is confirmed.
    Trial = 3,
    /// Boot loader to itself: execute an image, whatever forces the loader to wait.
    Execute = 4,
}

impl Handover {
    /// Returns the words of the message: identification, number of the message, and CRC-32 of both.
    pub fn words(self) -> [u32; WORDS] {
        let kind = self as u32;
        [MAGIC, kind, crc::of_words(&[MAGIC, kind])]
    }

    /// Returns the message that `words` contain; `None` if they are no message.
    pub fn from_words(words: [u32; WORDS]) -> Option<Self> {
        [Self::Update, Self::Confirm, Self::Trial, Self::Execute]
            .into_iter()
            .find(|message| message.words() == words)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_comes_back_and_one_bit_makes_it_none() {
        for message in [
            Handover::Update,
            Handover::Confirm,
            Handover::Trial,
            Handover::Execute,
        ] {
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
