//! The file that `update` sends: the image for slot A, followed by the same image for slot B, each
//! with its signed header.

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
    /// Header of the image, with the signature.
    pub header: [u8; HEADER],
    /// Payload of the image, which follows the header in the slot.
    pub payload: Vec<u8>,
}

/// A signed image for slot A, then for slot B.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Package(pub [Signed; 2]);

impl Signed {
    /// Returns the slot's bytes as a debug probe or the emulator writes them: header and payload,
    /// already confirmed, with the number `order`, by which confirmations are ordered.
    pub fn slot(&self, order: u32) -> Vec<u8> {
        [&factory(&self.header, order)[..], &self.payload].concat()
    }
}

impl Package {
    /// Converts an ELF file to images for both slots, with the image number `number`, and signs
    /// them.
    ///
    /// # Errors
    /// Names the file that contains no image.
    pub fn sign(elf: &Path, number: u32, key: &SigningKey) -> Result<Self> {
        let both = slots::read(elf)?;
        Ok(Self::of(key, |slot| {
            let [Payload(a), Payload(b)] = &both;
            let payload = if slot == Slot::A { a } else { b };
            (Self::header(payload, slot, number, key), payload.clone())
        }))
    }

    /// Signs both images; `image` returns the unsigned header and the payload for a slot.
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

    /// Returns the content of the file: header and payload for slot A, then for slot B.
    pub fn bytes(&self) -> Vec<u8> {
        let parts = self.0.iter();
        parts
            .flat_map(|s| s.header.iter().chain(&s.payload))
            .copied()
            .collect()
    }

    /// Reads and checks a file, without its signature, which is the loader's to check.
    ///
    /// # Errors
    /// Names the file, which contains no package, is cut off or damaged.
    pub fn read(path: &Path) -> Result<Self> {
        regular(path)?;
        let name = || path.display().to_string();
        let bytes = fs::read(path).with_context(name)?;
        Self::parse(&bytes).with_context(name)
    }

    /// Whether a file begins as [`Package::bytes`] does, also if it is cut off.
    pub fn begins(bytes: &[u8]) -> bool {
        let mut header = [0; HEADER];
        (header.iter_mut().zip(bytes)).for_each(|(to, from)| *to = *from);
        Header::parse(&header).is_ok()
    }

    /// Parses and checks the content of a file.
    ///
    /// # Errors
    /// Describes the difference from a package: no header, cut off, damaged, too long.
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        let mut rest = bytes;
        // Bytes of the image for slot B, if its header is missing: those of the same image for slot A.
        let mut expected = None;
        let mut next = |slot: Slot| -> Result<Signed> {
            let name = slot.as_str();
            let Some((header, behind)) = rest.split_first_chunk::<HEADER>() else {
                let missing = expected.map_or_else(String::new, |length: usize| {
                    format!("; {} bytes are missing", HEADER + length - rest.len())
                });
                bail!(
                    "cut off: {} of {HEADER} bytes of the header for slot {name}{missing}",
                    rest.len()
                );
            };
            let Ok(reported) = Header::parse(header) else {
                bail!("no signed image: expected what `cargo sim keys sign` writes");
            };
            let length = reported.length as usize;
            let Some((payload, behind)) = behind.split_at_checked(length) else {
                let held = behind.len();
                let missing = match slot {
                    Slot::A => length - held + HEADER + length,
                    Slot::B => length - held,
                };
                bail!(
                    "cut off: {held} of {length} bytes of the image for slot {name}; {missing} bytes are missing"
                );
            };
            expected = Some(length);
            rest = behind;
            ensure!(
                Sha256::digest(payload)[..] == reported.hash,
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

    /// Returns the identifier of the signing key (its first bytes) from the header for slot A;
    /// zeros if the header is damaged.
    pub fn key_id(&self) -> [u8; KEY_ID] {
        let header = Header::parse(&self.image(Slot::A).header);
        header.map_or([0; KEY_ID], |header| header.key_id)
    }

    /// Returns the signed image for a slot.
    pub fn image(&self, slot: Slot) -> &Signed {
        let [a, b] = &self.0;
        match slot {
            Slot::A => a,
            Slot::B => b,
        }
    }
}
