//! Flash that loses power, keys, and images to sign: what the loader's tests are made of.
#![allow(
    dead_code,
    missing_docs,
    reason = "each test takes what it needs of these"
)]

use std::cell::RefCell;
use std::rc::Rc;

use ed25519_dalek::{Signer, SigningKey};
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use sha2::{Digest, Sha256};
use stairscan_boot::floor::Floor;
use stairscan_boot::frame::{Frame, Kind};
use stairscan_boot::header::{HEADER, Header, PAYLOAD, SIGNED, sealed};
use stairscan_boot::key::{KEY_ID, PublicKey, SIGNATURE, Signatures};
use stairscan_boot::layout::CHIP;
use stairscan_boot::receive::{Effect, Receiver};
use stairscan_boot::refusal::Refusal;
use stairscan_boot::slot::{Slot, Slots};
use stairscan_boot::start::Loader;

/// Bytes of a sector of the model.
pub const SECTOR: usize = 1024;
/// Address of slot A in the model.
pub const BASE: u32 = 0x1000;
/// Bytes of a slot of the model: three sectors.
pub const SLOT: u32 = 3 * SECTOR as u32;

/// The supply of all flash of a model.
#[derive(Debug)]
pub struct Power {
    /// Words and sectors that may still be written and erased before it goes.
    pub left: Option<u32>,
    pub operations: u32,
    pub random: Xoshiro128PlusPlus,
}

pub type SharedPower = Rc<RefCell<Power>>;

pub fn power(seed: u64) -> SharedPower {
    Rc::new(RefCell::new(Power {
        left: None,
        operations: 0,
        random: Xoshiro128PlusPlus::seed_from_u64(seed),
    }))
}

/// NOR flash: writing clears bits, erasing sets all of a sector; what is under way when the power goes is done in part.
#[derive(Clone, Debug)]
pub struct Model {
    pub bytes: Vec<u8>,
    pub power: SharedPower,
    /// Writes are taken and do nothing.
    pub deaf: bool,
    /// The supply is too low to write or erase.
    pub low: bool,
}

/// Why an operation failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    PowerLost,
    LowSupply,
}

impl From<Failure> for Refusal {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::PowerLost => Refusal::Flash,
            Failure::LowSupply => Refusal::Supply,
        }
    }
}

impl NorFlashError for Failure {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl Model {
    pub fn new(sectors: usize, power: &SharedPower) -> Self {
        Self {
            bytes: vec![0xff; sectors * SECTOR],
            power: power.clone(),
            deaf: false,
            low: false,
        }
    }

    /// Whether the operation that begins now is cut short; an error once the power is gone.
    fn cut(&mut self) -> Result<bool, Failure> {
        if self.low {
            return Err(Failure::LowSupply);
        }
        let mut power = self.power.borrow_mut();
        power.operations += 1;
        match &mut power.left {
            None => Ok(false),
            Some(0) => Err(Failure::PowerLost),
            Some(left) => {
                *left -= 1;
                Ok(*left == 0)
            }
        }
    }
}

impl ErrorType for Model {
    type Error = Failure;
}

impl ReadNorFlash for Model {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failure> {
        let from = (offset as usize).min(self.bytes.len());
        let count = bytes.len().min(self.bytes.len() - from);
        bytes.fill(0xff);
        bytes[..count].copy_from_slice(&self.bytes[from..from + count]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Model {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Failure> {
        assert!((from as usize).is_multiple_of(SECTOR) && to - from == SECTOR as u32);
        let short = self.cut()?;
        let mut power = self.power.borrow_mut();
        // What an erasure that is cut short leaves: of each byte some bits, none, or all are set.
        let depth = power.random.next_u32() % 3;
        for byte in &mut self.bytes[from as usize..to as usize] {
            *byte |= match (short, depth) {
                (false, _) | (true, 2) => 0xff,
                (true, 1) => power.random.next_u32() as u8,
                (true, _) => (power.random.next_u32() & power.random.next_u32()) as u8 & 0x11,
            };
        }
        if short {
            Err(Failure::PowerLost)
        } else {
            Ok(())
        }
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failure> {
        assert!(offset.is_multiple_of(4) && bytes.len().is_multiple_of(4));
        for (k, word) in bytes.chunks(4).enumerate() {
            let short = self.cut()?;
            if self.deaf {
                continue;
            }
            let at = offset as usize + 4 * k;
            let places = &mut self.bytes[at..at + 4];
            assert!(
                places.iter().all(|&byte| byte == 0xff),
                "written twice without an erasure: 0x{at:x}"
            );
            let mut power = self.power.borrow_mut();
            for (place, &byte) in places.iter_mut().zip(word) {
                let kept = if short {
                    power.random.next_u32() as u8
                } else {
                    0
                };
                *place &= byte | kept;
            }
            if short {
                return Err(Failure::PowerLost);
            }
        }
        Ok(())
    }
}

/// A signature that costs next to nothing: SHA-256 behind a secret. For the many boots of the power cuts.
#[derive(Clone, Copy, Debug)]
pub struct Quick;

pub fn quick(message: &[u8]) -> [u8; SIGNATURE] {
    let mut signature = [0; SIGNATURE];
    let hash = Sha256::new()
        .chain_update(b"secret")
        .chain_update(message)
        .finalize();
    signature[..32].copy_from_slice(&hash);
    signature
}

impl Signatures for Quick {
    fn key_id(&self) -> [u8; KEY_ID] {
        *b"quickkey"
    }

    fn signed(&self, message: &[u8], signature: &[u8; SIGNATURE]) -> bool {
        quick(message) == *signature
    }
}

/// An image: its header's fields and its payload.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    pub header: [u8; HEADER],
    pub payload: Vec<u8>,
    pub number: u32,
}

/// Returns the header of an image with this payload, without its signature.
pub fn unsigned(payload: &[u8], base: u32, number: u32, key_id: [u8; KEY_ID]) -> Header {
    Header {
        chip: CHIP,
        base,
        length: payload.len() as u32,
        number,
        name: *b"0.1.0 test\0\0\0\0\0\0",
        key_id,
        hash: Sha256::digest(payload).into(),
    }
}

/// Bytes that nobody would take for another image's.
pub fn payload(seed: u32, length: usize) -> Vec<u8> {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(seed.into());
    (0..length).map(|_| random.next_u32() as u8).collect()
}

impl Image {
    pub fn quick(seed: u32, length: usize, slot: Slot, number: u32) -> Self {
        let payload = payload(seed, length);
        let header = unsigned(&payload, address(slot), number, Quick.key_id());
        let message = header.message();
        Self {
            header: sealed(&message, &quick(&message)),
            payload,
            number,
        }
    }

    pub fn signed(payload: Vec<u8>, header: Header, key: &SigningKey) -> Self {
        let message: [u8; SIGNED] = header.message();
        Self {
            header: sealed(&message, &key.sign(&message).to_bytes()),
            payload,
            number: header.number,
        }
    }
}

pub fn address(slot: Slot) -> u32 {
    match slot {
        Slot::A => BASE,
        Slot::B => BASE + SLOT,
    }
}

pub fn public(key: &SigningKey) -> PublicKey {
    PublicKey(key.verifying_key().to_bytes())
}

/// A loader over two models that share a supply.
pub type Modelled<K> = Loader<Model, Model, K>;

pub fn loader<K>(power: &SharedPower, keys: K) -> Modelled<K> {
    Loader {
        slots: Slots::new(Model::new(6, power), BASE),
        floor: Floor::new(Model::new(1, power)),
        keys,
    }
}

/// Puts an image into a slot as a debug probe does, confirmed.
pub fn flash<K: Signatures>(loader: &mut Modelled<K>, slot: Slot, image: &Image) {
    loader.slots.begin(slot, &image.header).unwrap();
    loader.slots.write(slot, 0, &image.payload).unwrap();
    loader.slots.complete(slot).unwrap();
    loader.slots.confirm(slot).unwrap();
}

/// Sends one request; the code and the offset of the answer.
pub fn ask<K: Signatures>(
    receiver: &mut Receiver,
    loader: &mut Modelled<K>,
    kind: Kind,
    payload: &[u8],
) -> (Result<u32, Refusal>, Effect) {
    let frame = Frame {
        kind: kind as u8,
        sequence: 0,
        payload,
    };
    let (answer, effect) = receiver.handle(frame, loader).expect("an answer");
    let (&code, rest) = answer.bytes().split_first().expect("a code");
    let next = rest.first_chunk().map_or(0, |b| u32::from_le_bytes(*b));
    let refused = Refusal::from_code(code);
    assert_eq!(code == 0, refused.is_none());
    (refused.map_or(Ok(next), Err), effect)
}

/// Sends an image, from where the loader wants it on; `most` bytes at most.
pub fn send<K: Signatures>(
    receiver: &mut Receiver,
    loader: &mut Modelled<K>,
    image: &Image,
    most: usize,
) -> Result<usize, Refusal> {
    let mut next = ask(receiver, loader, Kind::Begin, &image.header).0?;
    let mut sent = 0;
    while (next as usize) < image.payload.len() && sent < most {
        let rest = &image.payload[next as usize..];
        let piece = &rest[..rest.len().min(128)];
        let data = [&next.to_le_bytes(), piece].concat();
        let answer = ask(receiver, loader, Kind::Data, &data).0?;
        assert_eq!(answer as usize, next as usize + piece.len());
        next = answer;
        sent += piece.len();
    }
    Ok(sent)
}

/// Returns whether a slot holds this image.
pub fn stands<K>(loader: &mut Modelled<K>, slot: Slot, image: &Image) -> bool {
    let at = (address(slot) - BASE) as usize;
    let bytes = &loader.slots.flash_mut().bytes;
    let from = at + PAYLOAD as usize;
    bytes[at..].starts_with(&image.header) && bytes[from..].starts_with(&image.payload)
}
