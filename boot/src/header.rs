//! The signed header of an image, with which its slot begins.
//!
//! | offset | bytes | what (little-endian) |
//! |---|---|---|
//! | 0 | 4 | `STIM` |
//! | 4 | 4 | version of this format, 1 |
//! | 8 | 4 | chip: `F405` |
//! | 12 | 4 | address of the slot that the image is linked for |
//! | 16 | 4 | length of the payload, a multiple of 4 |
//! | 20 | 4 | number, which the anti-rollback counter is compared with |
//! | 24 | 16 | version in words, padded with zeros |
//! | 40 | 8 | first bytes of the public key |
//! | 48 | 32 | SHA-256 of the payload |
//! | 80 | 64 | Ed25519 signature of the 80 bytes before |
//!
//! The marks of the slot follow ([`crate::slot`]), and at [`PAYLOAD`] the payload, which begins with the vector table.

use crate::key::{KEY_ID, SIGNATURE, Signatures};
use crate::layout::CHIP;
use crate::refusal::Refusal;

/// Word that a header begins with.
const MAGIC: [u8; 4] = *b"STIM";
/// Version of the format.
const FORMAT: u32 = 1;
/// Bytes that are signed.
pub const SIGNED: usize = 80;
/// Bytes of a header.
pub const HEADER: usize = SIGNED + SIGNATURE;
/// Offset of the payload within its slot: a vector table of 98 entries begins on a multiple of 512 (PM0214 4.4.4).
pub const PAYLOAD: u32 = 512;
/// Bytes of the version in words.
pub const NAME: usize = 16;
/// Bytes of the payload's hash.
pub const HASH: usize = 32;

/// Contents of a header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// The chip that the image is for.
    pub chip: u32,
    /// Address of the slot that it is linked for.
    pub base: u32,
    /// Bytes of its payload.
    pub length: u32,
    /// Number of the anti-rollback counter.
    pub number: u32,
    /// Version in words.
    pub name: [u8; NAME],
    /// First bytes of the public key.
    pub key_id: [u8; KEY_ID],
    /// SHA-256 of the payload.
    pub hash: [u8; HASH],
}

impl Header {
    /// Returns the bytes that are signed.
    pub fn message(&self) -> [u8; SIGNED] {
        let mut bytes = [0; SIGNED];
        let numbers = [self.chip, self.base, self.length, self.number].map(u32::to_le_bytes);
        let parts: [&[u8]; 6] = [
            &MAGIC,
            &FORMAT.to_le_bytes(),
            numbers.as_flattened(),
            &self.name,
            &self.key_id,
            &self.hash,
        ];
        let all = parts.into_iter().flatten();
        bytes.iter_mut().zip(all).for_each(|(to, from)| *to = *from);
        bytes
    }

    /// Reads a header; nothing of it is checked but that it is one.
    ///
    /// # Errors
    /// [`Refusal::NoImage`].
    pub fn parse(bytes: &[u8; HEADER]) -> Result<Self, Refusal> {
        let word = |at: usize| {
            let found = bytes.get(at..).and_then(|rest| rest.first_chunk());
            found.map_or(0, |word| u32::from_le_bytes(*word))
        };
        if !bytes.starts_with(&MAGIC) || word(4) != FORMAT {
            return Err(Refusal::NoImage);
        }
        Ok(Self {
            chip: word(8),
            base: word(12),
            length: word(16),
            number: word(20),
            name: part(bytes, 24),
            key_id: part(bytes, 40),
            hash: part(bytes, 48),
        })
    }

    /// Reads a header and checks all that can be checked without the payload. The signature comes last, so that an
    /// image for somebody else is named as such.
    ///
    /// # Errors
    /// Why the image would not be executed at `base`, in a slot of `slot` bytes, with the counter at `floor`.
    pub fn check(
        bytes: &[u8; HEADER],
        (base, slot): (u32, u32),
        floor: u32,
        keys: &impl Signatures,
    ) -> Result<Self, Refusal> {
        let header = Self::parse(bytes)?;
        if header.chip != CHIP {
            return Err(Refusal::OtherChip);
        }
        if header.key_id != keys.key_id() {
            return Err(Refusal::WrongKey);
        }
        if !keys.signed(&header.message(), &part(bytes, SIGNED)) {
            return Err(Refusal::BadSignature);
        }
        if header.base != base {
            return Err(Refusal::OtherSlot);
        }
        let room = slot.saturating_sub(PAYLOAD);
        if header.length > room || header.length == 0 || !header.length.is_multiple_of(4) {
            return Err(Refusal::TooLong);
        }
        if header.number < floor {
            return Err(Refusal::Older);
        }
        Ok(header)
    }

    /// Version in words.
    pub fn name(&self) -> &str {
        let end = self.name.iter().position(|&b| b == 0).unwrap_or(NAME);
        let name = self.name.get(..end).unwrap_or_default();
        core::str::from_utf8(name).unwrap_or("?")
    }
}

/// `N` bytes from `at` on; zeros behind the end.
fn part<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    let found = bytes.get(at..).and_then(|rest| rest.first_chunk());
    found.copied().unwrap_or([0; N])
}

/// Returns a header with its signature behind it.
pub fn sealed(message: &[u8; SIGNED], signature: &[u8; SIGNATURE]) -> [u8; HEADER] {
    let mut bytes = [0; HEADER];
    let all = message.iter().chain(signature);
    bytes.iter_mut().zip(all).for_each(|(to, from)| *to = *from);
    bytes
}
