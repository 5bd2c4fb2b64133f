//! Power cuts at every write and erasure of an update: what is executed is signed and whole, and something always is.
//!
//! A scanner's life in the model: the host sends images, some of them forged, damaged or faulty; images boot, confirm
//! themselves, crash, hang; the power goes in the midst of writes and erasures, and again while the loader recovers.

mod common;

use std::collections::BTreeMap;

use common::{Image, Modelled, Quick, ask, flash, loader, send, stands};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use stairscan_boot::frame::Kind;
use stairscan_boot::receive::{Effect, Receiver};
use stairscan_boot::refusal::Refusal;
use stairscan_boot::slot::{Slot, TRIES};
use stairscan_boot::start::{Asked, Start};
use testbed::{Power, SharedPower};

/// Bytes of the images: all of a slot but some words, which ends in the third sector.
const LENGTH: usize = 2300;

/// Behaviour of an image that is executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Nature {
    /// Its self-test passes.
    Good,
    /// It crashes, or hangs until the watchdog resets the chip.
    Faulty,
}

/// A scanner, the host's images, and what has been seen of both.
struct Life {
    device: Modelled<Quick>,
    power: SharedPower,
    random: Xoshiro128PlusPlus,
    /// Every image that was ever signed, by its slot.
    signed: Vec<(Slot, Image, Nature)>,
    /// Executions on trial by place and header.
    tried: BTreeMap<(bool, Vec<u8>), u32>,
    /// Largest number that has run as confirmed.
    highest: u32,
    asked: Asked,
    cuts: u32,
    boots: u32,
    confirmed: u32,
    rolled_back: u32,
}

impl Life {
    fn new(seed: u64) -> Self {
        let power = Power::new(seed);
        let mut device = loader(&power, Quick);
        let first = Image::quick(1, LENGTH, Slot::A, 1);
        flash(&mut device, Slot::A, &first);
        Self {
            device,
            power,
            random: Xoshiro128PlusPlus::seed_from_u64(seed ^ 0x5eed),
            signed: vec![(Slot::A, first, Nature::Good)],
            tried: BTreeMap::new(),
            highest: 1,
            asked: Asked::Nothing,
            cuts: 0,
            boots: 0,
            confirmed: 0,
            rolled_back: 0,
        }
    }

    /// One in `n`.
    fn chance(&mut self, n: u32) -> bool {
        self.random.next_u32().is_multiple_of(n)
    }

    fn is_off(&self) -> bool {
        self.power.borrow().left == Some(0)
    }

    /// The power goes after so many operations; 0 for never.
    fn fuse(&mut self, operations: u32) {
        self.power.borrow_mut().left = (operations > 0).then_some(operations);
    }

    /// Resets or powers up until a boot is not cut, with the recovery cut again now and then, and executes what the loader
    /// says.
    fn boot(&mut self) -> Start {
        loop {
            if self.is_off() {
                self.cuts += 1;
                // What RAM held is lost.
                self.asked = Asked::Nothing;
                let again = if self.chance(3) {
                    1 + self.random.next_u32() % 4
                } else {
                    0
                };
                self.fuse(again);
            }
            let asked = std::mem::replace(&mut self.asked, Asked::Nothing);
            let start = self.device.start(asked);
            if self.is_off() {
                continue;
            }
            self.fuse(0);
            self.boots += 1;
            let start = start.expect("a brick");
            self.execute(start);
            return start;
        }
    }

    /// Checks what is executed against all that was signed.
    fn execute(&mut self, start: Start) {
        let slot = start.slot;
        let device = &mut self.device;
        let found =
            (self.signed.iter()).find(|(of, image, _)| *of == slot && stands(device, slot, image));
        let (_, image, nature) = found.expect("an image that nobody signed is executed");
        let (nature, number) = (*nature, image.number);
        assert!(number >= self.highest, "an older image is executed");
        match start.trial {
            Some(_) => {
                let key = (slot == Slot::B, image.header.to_vec());
                let count = self.tried.entry(key).or_default();
                *count += 1;
                // A write of the mark that is cut may leave it blank.
                assert!(*count <= TRIES + 3, "a trial that does not end");
                if nature == Nature::Good && !self.random.next_u32().is_multiple_of(8) {
                    self.asked = Asked::Confirm;
                }
            }
            None => {
                if number > self.highest {
                    self.highest = number;
                }
                assert_eq!(nature, Nature::Good, "a faulty image was confirmed");
            }
        }
    }

    /// The host makes a new image for the spare slot and signs it.
    fn next_image(&mut self) -> (Slot, Image, Nature) {
        let slot = self.device.spare();
        let number = self.highest + u32::from(self.chance(3));
        let nature = if self.chance(4) {
            Nature::Faulty
        } else {
            Nature::Good
        };
        let seed = self.random.next_u32();
        let image = Image::quick(seed, LENGTH, slot, number);
        self.signed.push((slot, image.clone(), nature));
        // The older ones have been overwritten.
        if self.signed.len() > 8 {
            let running: Vec<bool> = (self.signed.iter())
                .map(|(slot, image, _)| stands(&mut self.device, *slot, image))
                .collect();
            let mut keep = running.iter();
            let mut left = self.signed.len();
            self.signed.retain(|_| {
                left -= 1;
                *keep.next().unwrap_or(&true) || left < 4
            });
        }
        (slot, image, nature)
    }

    /// Sends what is no image of the maker: never taken, and nothing of it executed.
    fn attack(&mut self) {
        let mut receiver = Receiver::new(0, true);
        let slot = self.device.spare();
        let mut image = Image::quick(self.random.next_u32(), LENGTH, slot, self.highest);
        match self.random.next_u32() % 3 {
            0 => image.header[100] ^= 1,
            1 => image.header[48] ^= 1,
            _ => {
                // A signed header with another payload.
                image.payload[77] ^= 0x40;
                let sent = send(&mut receiver, &mut self.device, &image, usize::MAX);
                if sent.is_ok() {
                    let answer = ask(&mut receiver, &mut self.device, Kind::Finish, &[]).0;
                    assert!(answer.is_err());
                }
                return;
            }
        }
        let refused = send(&mut receiver, &mut self.device, &image, usize::MAX);
        assert_eq!(refused, Err(Refusal::BadSignature));
    }

    /// Sends an image until it is complete, through cuts and broken transfers; false where the power went.
    fn transfer(&mut self, image: &Image) -> bool {
        let mut receiver = Receiver::new(0, true);
        loop {
            // The host's cable comes off now and then.
            let most = if self.chance(4) { 700 } else { usize::MAX };
            let sent = send(&mut receiver, &mut self.device, image, most);
            if self.is_off() {
                return false;
            }
            if sent.expect("a signed image") < most {
                break;
            }
        }
        let (done, effect) = ask(&mut receiver, &mut self.device, Kind::Finish, &[]);
        if self.is_off() {
            return false;
        }
        assert_eq!((done, effect), (Ok(0), Effect::Reset));
        true
    }

    /// A whole update with the power going after `operations`; and on from there until the new image has been confirmed
    /// or the old one runs again.
    fn update(&mut self, operations: u32, later: impl Fn(&mut Self) -> u32) {
        let (slot, image, nature) = self.next_image();
        self.fuse(operations);
        while !self.transfer(&image) {
            self.boot();
            if stands(&mut self.device, slot, &image)
                && self.device.slots.mark(slot) != stairscan_boot::slot::Mark::Incomplete
            {
                break;
            }
            let again = later(self);
            self.fuse(again);
        }
        for _ in 0..4 * TRIES {
            let start = self.boot();
            if start.trial.is_none() {
                let took = start.slot == slot;
                self.confirmed += u32::from(took);
                self.rolled_back += u32::from(!took);
                assert!(!took || nature == Nature::Good);
                return;
            }
            let again = later(self);
            self.fuse(again);
        }
        panic!("a trial that does not end");
    }
}

#[test]
fn every_write_and_erasure_of_an_update_may_be_cut() {
    let mut cuts = 0;
    for seed in 0..4 {
        for operations in 1.. {
            let mut life = Life::new(seed * 100_000 + u64::from(operations));
            life.update(operations, |_| 0);
            cuts += life.cuts;
            if life.cuts == 0 {
                break;
            }
        }
    }
    assert!(cuts > 4 * 600, "{cuts}");
}

#[test]
fn a_hundred_thousand_cuts_never_brick_and_never_execute_what_nobody_signed() {
    let (mut cuts, mut boots, mut confirmed, mut rolled_back) = (0, 0, 0, 0);
    let mut seed = 0;
    while cuts < 100_000 {
        seed += 1;
        let mut life = Life::new(seed);
        for _ in 0..20 {
            if life.chance(3) {
                life.attack();
            }
            if life.chance(5) {
                let mut receiver = Receiver::new(0, true);
                let highest = life.highest;
                let back = ask(&mut receiver, &mut life.device, Kind::Back, &[]).0;
                assert!(back.is_ok() || back == Err(Refusal::NoWayBack));
                life.boot();
                assert_eq!(highest, life.highest);
            }
            let first = 1 + life.random.next_u32() % 700;
            life.update(first, |life| match life.random.next_u32() % 4 {
                0 => 0,
                1 => 1 + life.random.next_u32() % 6,
                _ => 1 + life.random.next_u32() % 500,
            });
        }
        cuts += life.cuts;
        boots += life.boots;
        confirmed += life.confirmed;
        rolled_back += life.rolled_back;
    }
    println!(
        "{cuts} cuts, {boots} boots, {confirmed} updates confirmed, {rolled_back} rolled back"
    );
    assert!(confirmed > 1_000 && rolled_back > 1_000);
}
