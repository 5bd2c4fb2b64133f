//! Flash that loses power, keys, and images to sign: what the loader's tests are made of.
#![allow(
    dead_code,
    missing_docs,
    reason = "each test takes what it needs of these"
)]

use ed25519_dalek::{Signer, SigningKey};
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
use testbed::{Flash, SharedPower};

/// Bytes of a sector of the model.
pub const SECTOR: usize = 1024;
/// Address of slot A in the model.
pub const BASE: u32 = 0x1000;
/// Bytes of a slot of the model: three sectors.
pub const SLOT: u32 = 3 * SECTOR as u32;

/// Flash of the model.
pub type Model = Flash<SECTOR>;

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
