//! Input of the boot loader over the report port: any bytes, whole frames, resets.
//!
//! An operation is a byte, and what it needs after it:
//!
//! | byte | then | what |
//! |---|---|---|
//! | 0 | count, bytes | these come in as they are |
//! | 1 | kind, count, bytes | a whole frame of this kind with this payload |
//! | 2 | offset, count, bytes | data at this offset, in words of four bytes |
//! | 3 | 0, 1 | the chip is reset; with 1 the image asks to be confirmed |
//!
//! An image of another payload, or of another key, is never executed, and the first one always can be.

use host_sim::update::keys;
use host_sim::update::package::Package;
use stairscan_boot::floor::Floor;
use stairscan_boot::frame::{Decoder, Frame, Kind, MAX_FRAME, encode};
use stairscan_boot::header::NAME;
use stairscan_boot::key::PublicKey;
use stairscan_boot::layout::SLOTS;
use stairscan_boot::receive::{Effect, Receiver};
use stairscan_boot::slot::{Slot, Slots};
use stairscan_boot::start::{Asked, Loader};
use testbed::{Flash, Power};

use crate::input::Input;

/// Bytes of a sector of the model.
const SECTOR: usize = 1024;

type Model = Loader<Flash<SECTOR>, Flash<SECTOR>, PublicKey>;

/// The image that stands in slot A.
fn first() -> Package {
    let key = keys::development().expect("the repository's key");
    let payload: Vec<u8> = (0..600_u32).map(|k| (k * 7) as u8).collect();
    Package::of(&key, |slot| {
        let mut header = Package::header(&payload, slot, 0, &key);
        // The same bytes from every revision, as the corpus has them.
        header.name = [0; NAME];
        (header, payload.clone())
    })
}

fn scanner() -> Model {
    let mut flash = vec![0xff; 6 * SECTOR];
    let slot = first().image(Slot::A).slot(1);
    flash[..slot.len()].copy_from_slice(&slot);
    let key = keys::development().expect("the repository's key");
    let power = Power::new(0);
    Loader {
        slots: Slots::new(Flash::with(flash, &power), SLOTS),
        floor: Floor::new(Flash::new(1, &power)),
        keys: PublicKey(key.verifying_key().to_bytes()),
    }
}

/// Takes bytes as the chip does; answers are short, and what would reset the chip does.
fn hear(bytes: &[u8], decoder: &mut Decoder, receiver: &mut Receiver, loader: &mut Model) {
    for &byte in bytes {
        let Some(frame) = decoder.push(byte) else {
            continue;
        };
        let Some((answer, effect)) = receiver.handle(frame, loader) else {
            continue;
        };
        assert!(!answer.bytes().is_empty());
        if effect == Effect::Reset {
            *receiver = Receiver::new(30, true);
            boot(Asked::Nothing, loader);
        }
    }
}

/// Checks that signed images are executed, and no others.
fn boot(asked: Asked, loader: &mut Model) {
    let start = loader.start(asked).expect("a brick");
    assert_eq!((start.slot, start.trial), (Slot::A, None));
}

/// Sends the input's operations to a loader.
pub fn run(data: &[u8]) {
    let mut input = Input(data);
    let mut loader = scanner();
    let (mut decoder, mut receiver) = (Decoder::new(), Receiver::new(30, true));
    while !input.is_empty() {
        let mut out = [0; MAX_FRAME];
        let (kind, payload) = match input.byte() % 4 {
            0 => {
                hear(input.counted(), &mut decoder, &mut receiver, &mut loader);
                continue;
            }
            1 => (input.byte(), input.counted().to_vec()),
            2 => {
                let offset = u32::from(input.short());
                let bytes = [&offset.to_le_bytes(), input.counted()].concat();
                (Kind::Data as u8, bytes)
            }
            _ => {
                receiver = Receiver::new(30, true);
                let asked = match input.byte() % 2 {
                    0 => Asked::Nothing,
                    _ => Asked::Confirm,
                };
                boot(asked, &mut loader);
                continue;
            }
        };
        let frame = Frame {
            kind,
            sequence: 0,
            payload: &payload,
        };
        let count = encode(frame, &mut out);
        hear(&out[..count], &mut decoder, &mut receiver, &mut loader);
    }
    boot(Asked::Confirm, &mut loader);
}

/// A header that the loader takes, of an image that it has not got.
pub fn offered() -> Vec<u8> {
    first().image(Slot::B).header.to_vec()
}
