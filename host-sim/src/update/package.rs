//! The file that `update` sends: the image for slot A and behind it the one for slot B, each with its signed header.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use ed25519_dalek::SigningKey;
use sha2::{Digest, Sha256};
use stairscan_boot::header::{HEADER, Header, NAME};
use stairscan_boot::key::{KEY_ID, PublicKey};
use stairscan_boot::layout::CHIP;
use stairscan_boot::slot::{Slot, factory};

use super::keys;
use super::slots::{self, Payload};
use crate::recording::regular;

/// A signed image for one slot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Signed {
    /// Its header, with the signature.
    pub header: [u8; HEADER],
    /// Payload behind the header.
    pub payload: Vec<u8>,
}

/// A signed image for each slot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Package(pub [Signed; 2]);

impl Signed {
    /// Returns the slot as a debug probe or the emulator writes it: confirmed, with a number that orders confirmations.
    pub fn slot(&self, order: u32) -> Vec<u8> {
        [&factory(&self.header, order)[..], &self.payload].concat()
    }
}

impl Package {
    /// Signs the image in an ELF file for both slots.
    ///
    /// # Errors
    /// Names the file that is no image.
    pub fn sign(elf: &Path, number: u32, key: &SigningKey) -> Result<Self> {
        let both = slots::read(elf)?;
        Ok(Self::of(key, |slot| {
            let [Payload(a), Payload(b)] = &both;
            let payload = if slot == Slot::A { a } else { b };
            (Self::header(payload, slot, number, key), payload.clone())
        }))
    }

    /// Signs what `image` gives for each slot.
    pub fn of(key: &SigningKey, image: impl Fn(Slot) -> (Header, Vec<u8>)) -> Self {
        Self(Slot::BOTH.map(|slot| {
            let (header, payload) = image(slot);
            let header = keys::sign(key, &header);
            Signed { header, payload }
        }))
    }

    /// Returns the header of a payload in a slot, without its signature.
    pub fn header(payload: &[u8], slot: Slot, number: u32, key: &SigningKey) -> Header {
        let mut name = [0; NAME];
        let words = format!("{} {}", env!("CARGO_PKG_VERSION"), stairscan::REVISION);
        let letters = words.bytes();
        name.iter_mut()
            .zip(letters)
            .for_each(|(to, from)| *to = from);
        Header {
            chip: CHIP,
            base: slots::address(slot),
            length: payload.len() as u32,
            number,
            name,
            key_id: PublicKey(key.verifying_key().to_bytes()).id(),
            hash: Sha256::digest(payload).into(),
        }
    }

    /// Its bytes.
    pub fn bytes(&self) -> Vec<u8> {
        let parts = self.0.iter();
        parts
            .flat_map(|s| s.header.iter().chain(&s.payload))
            .copied()
            .collect()
    }

    /// Reads a file.
    ///
    /// # Errors
    /// Names the file: none of these, cut off, damaged. Whose key signed it is the loader's to say.
    pub fn read(path: &Path) -> Result<Self> {
        regular(path)?;
        let name = || path.display().to_string();
        let bytes = fs::read(path).with_context(name)?;
        Self::parse(&bytes).with_context(name)
    }

    /// Reads its bytes.
    ///
    /// # Errors
    /// Says what is wrong with them.
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        let mut rest = bytes;
        let mut next = |slot: Slot| -> Result<Signed> {
            let Some((header, behind)) = rest.split_first_chunk::<HEADER>() else {
                bail!("cut off: ends within the header for slot {}", slot.as_str());
            };
            let Ok(told) = Header::parse(header) else {
                bail!("no signed image: expected what `cargo sim keys sign` writes");
            };
            let length = told.length as usize;
            let Some((payload, behind)) = behind.split_at_checked(length) else {
                bail!(
                    "cut off: {} of {length} bytes of the image for slot {}",
                    behind.len(),
                    slot.as_str()
                );
            };
            rest = behind;
            ensure!(
                Sha256::digest(payload)[..] == told.hash,
                "damaged: the image for slot {} is not the one that was signed",
                slot.as_str()
            );
            Ok(Signed {
                header: *header,
                payload: payload.to_vec(),
            })
        };
        let both = [next(Slot::A)?, next(Slot::B)?];
        ensure!(rest.is_empty(), "{} bytes too many", rest.len());
        Ok(Self(both))
    }

    /// First bytes of the key that it says it is signed with.
    pub fn key_id(&self) -> [u8; KEY_ID] {
        let header = Header::parse(&self.image(Slot::A).header);
        header.map_or([0; KEY_ID], |header| header.key_id)
    }

    /// The image for a slot.
    pub fn image(&self, slot: Slot) -> &Signed {
        let [a, b] = &self.0;
        match slot {
            Slot::A => a,
            Slot::B => b,
        }
    }
}
