//! Each refusal has its own answer; a broken transfer goes on; a faulty image is rolled back.

mod common;

use common::{Image, SECTOR, ask, flash, loader, public, send, stands, unsigned};
use ed25519_dalek::SigningKey;
use stairscan::scanner::option_bytes::OptionBytes;
use stairscan_boot::floor::Floor;
use stairscan_boot::frame::{Frame, Kind};
use stairscan_boot::header::Header;
use stairscan_boot::key::PublicKey;
use stairscan_boot::receive::{Effect, Info, Receiver};
use stairscan_boot::refusal::Refusal;
use stairscan_boot::slot::{Slot, TRIES};
use stairscan_boot::start::Asked;
use testbed::{FlashFault, Power};

const LENGTH: usize = 2300;

fn maker() -> SigningKey {
    SigningKey::from_bytes(&[7; 32])
}

/// An image for slot B, changed before it is signed.
fn image(key: &SigningKey, change: impl FnOnce(&mut Header)) -> Image {
    let payload = common::payload(9, LENGTH);
    let base = common::address(Slot::B);
    let mut header = unsigned(&payload, base, 5, public(key).id());
    change(&mut header);
    Image::signed(payload, header, key)
}

/// A scanner with an image of number 5 in slot A.
fn scanner() -> (common::Modelled<PublicKey>, Receiver, Image) {
    let key = maker();
    let mut device = loader(&Power::new(1), public(&key));
    let payload = common::payload(1, LENGTH);
    let header = unsigned(&payload, common::address(Slot::A), 5, public(&key).id());
    let first = Image::signed(payload, header, &key);
    flash(&mut device, Slot::A, &first);
    let start = device.start(Asked::Nothing).unwrap();
    assert_eq!((start.slot, start.trial), (Slot::A, None));
    (device, Receiver::new(30, true), first)
}

#[test]
fn each_refusal_has_its_own_answer_and_leaves_the_flash_alone() {
    let key = maker();
    let other = SigningKey::from_bytes(&[8; 32]);
    let mut flipped = image(&key, |_| ());
    flipped.header[90] ^= 1;
    let mut forged = image(&other, |_| ());
    // The name of the right key over a signature of another one.
    forged.header[40..48].copy_from_slice(&public(&key).id());
    let mut none = image(&key, |_| ());
    none.header[0] = b'X';
    let wrong = [
        (none, Refusal::NoImage),
        (image(&key, |h| h.chip += 1), Refusal::OtherChip),
        (image(&key, |h| h.base = common::BASE), Refusal::OtherSlot),
        (image(&key, |h| h.length = common::SLOT), Refusal::TooLong),
        (image(&key, |h| h.length = 0), Refusal::TooLong),
        (image(&key, |h| h.number = 4), Refusal::Older),
        (image(&other, |_| ()), Refusal::WrongKey),
        (flipped, Refusal::BadSignature),
        (forged, Refusal::BadSignature),
    ];
    for (image, refusal) in wrong {
        let (mut device, mut receiver, _) = scanner();
        let before = device.slots.flash_mut().bytes.clone();
        let got = send(&mut receiver, &mut device, &image, usize::MAX);
        assert_eq!(got, Err(refusal));
        assert_eq!(device.slots.flash_mut().bytes, before, "{refusal:?}");
        assert_eq!(device.start(Asked::Nothing).unwrap().slot, Slot::A);
    }
}

#[test]
fn a_file_that_is_cut_off_or_damaged_is_named_and_never_executed() {
    let (mut device, mut receiver, _) = scanner();
    let good = image(&maker(), |_| ());
    send(&mut receiver, &mut device, &good, 1000).unwrap();
    let finish = ask(&mut receiver, &mut device, Kind::Finish, &[]);
    assert_eq!(finish, (Err(Refusal::CutOff), Effect::None));
    assert_eq!(device.word(Slot::B), "incomplete");
    assert_eq!(device.start(Asked::Nothing).unwrap().slot, Slot::A);
    for byte in [0, 1234, LENGTH - 1] {
        let (mut device, mut receiver, _) = scanner();
        let mut bad = good.clone();
        bad.payload[byte] ^= 0x10;
        send(&mut receiver, &mut device, &bad, usize::MAX).unwrap();
        let finish = ask(&mut receiver, &mut device, Kind::Finish, &[]);
        assert_eq!(finish, (Err(Refusal::Damaged), Effect::None));
        assert_eq!(device.start(Asked::Nothing).unwrap().slot, Slot::A);
        // The same header again is another beginning, not a resumption.
        send(&mut receiver, &mut device, &good, usize::MAX).unwrap();
        let finish = ask(&mut receiver, &mut device, Kind::Finish, &[]);
        assert_eq!(finish, (Ok(0), Effect::Reset));
    }
}

#[test]
fn an_image_that_rots_is_not_executed_and_the_other_one_is() {
    for byte in (0..LENGTH + 144).step_by(37) {
        let (mut device, mut receiver, first) = scanner();
        let second = image(&maker(), |_| ());
        send(&mut receiver, &mut device, &second, usize::MAX).unwrap();
        ask(&mut receiver, &mut device, Kind::Finish, &[])
            .0
            .unwrap();
        assert_eq!(device.start(Asked::Nothing).unwrap().trial, Some(1));
        let start = device.start(Asked::Confirm).unwrap();
        assert_eq!((start.slot, start.trial), (Slot::B, None));
        let at = common::SLOT as usize + if byte < 144 { byte } else { 512 + byte - 144 };
        device.slots.flash_mut().bytes[at] ^= 4;
        let start = device.start(Asked::Nothing).unwrap();
        assert_eq!(start.slot, Slot::A, "byte {byte}");
        assert!(stands(&mut device, Slot::A, &first));
        device.slots.flash_mut().bytes[at - common::SLOT as usize] ^= 4;
        assert_eq!(device.start(Asked::Nothing), None, "byte {byte} of both");
        assert_ne!(device.word(Slot::B), "confirmed");
    }
}

/// Crash loop, watchdog, loss of power: all the loader sees of them is another boot without a confirmation.
#[test]
fn an_image_that_is_never_confirmed_is_rolled_back() {
    let (mut device, mut receiver, _) = scanner();
    let second = image(&maker(), |h| h.number = 6);
    send(&mut receiver, &mut device, &second, usize::MAX).unwrap();
    ask(&mut receiver, &mut device, Kind::Finish, &[])
        .0
        .unwrap();
    for tried in 1..=TRIES {
        let start = device.start(Asked::Nothing).unwrap();
        assert_eq!((start.slot, start.trial), (Slot::B, Some(tried)));
        assert_eq!(
            device.word(Slot::B),
            if tried < TRIES { "trial" } else { "failed" }
        );
    }
    let start = device.start(Asked::Nothing).unwrap();
    assert_eq!((start.slot, start.trial), (Slot::A, None));
    // Its number was never confirmed: images of the old one are still taken.
    assert_eq!(device.floor.get(), 5);
    let third = image(&maker(), |_| ());
    send(&mut receiver, &mut device, &third, usize::MAX).unwrap();
}

#[test]
fn a_confirmed_image_raises_the_counter_and_there_is_a_way_back_among_equals_only() {
    for (number, back) in [(5, Ok(0)), (6, Err(Refusal::NoWayBack))] {
        let (mut device, mut receiver, _) = scanner();
        let got = ask(&mut receiver, &mut device, Kind::Back, &[]).0;
        assert_eq!(got, Err(Refusal::NoWayBack));
        let second = image(&maker(), |h| h.number = number);
        send(&mut receiver, &mut device, &second, usize::MAX).unwrap();
        ask(&mut receiver, &mut device, Kind::Finish, &[])
            .0
            .unwrap();
        device.start(Asked::Nothing).unwrap();
        let start = device.start(Asked::Confirm).unwrap();
        assert_eq!((start.slot, start.trial), (Slot::B, None));
        assert_eq!(device.floor.get(), number);
        let got = ask(&mut receiver, &mut device, Kind::Back, &[]).0;
        assert_eq!(got, back);
        let slot = if back.is_ok() { Slot::A } else { Slot::B };
        assert_eq!(device.start(Asked::Nothing).unwrap().slot, slot);
    }
}

#[test]
fn a_transfer_goes_on_where_it_broke_and_after_a_loss_of_power_at_a_sector() {
    let (mut device, mut receiver, _) = scanner();
    let new = image(&maker(), |_| ());
    send(&mut receiver, &mut device, &new, 1500).unwrap();
    // Only the cable came off.
    let next = ask(&mut receiver, &mut device, Kind::Begin, &new.header).0;
    assert_eq!(next, Ok(1536));
    // The power went: the loader knows flash only.
    let mut receiver = Receiver::new(30, true);
    let next = ask(&mut receiver, &mut device, Kind::Begin, &new.header).0;
    assert_eq!(next, Ok(SECTOR as u32 - 512));
    // Data of elsewhere are not written.
    let stray = [&0_u32.to_le_bytes()[..], &new.payload[..128]].concat();
    let next = ask(&mut receiver, &mut device, Kind::Data, &stray).0;
    assert_eq!(next, Ok(SECTOR as u32 - 512));
    send(&mut receiver, &mut device, &new, usize::MAX).unwrap();
    ask(&mut receiver, &mut device, Kind::Finish, &[])
        .0
        .unwrap();
    assert!(stands(&mut device, Slot::B, &new));
    // Another image begins anew.
    let other = image(&maker(), |h| h.name[0] = b'9');
    let next = ask(&mut receiver, &mut device, Kind::Begin, &other.header).0;
    assert_eq!(next, Ok(0));
}

#[test]
fn requests_that_do_not_belong_are_refused() {
    let (mut device, mut receiver, _) = scanner();
    let mut asks = |kind, payload: &[u8]| ask(&mut receiver, &mut device, kind, payload);
    for (kind, payload) in [
        (Kind::Data, &[0; 8][..]),
        (Kind::Finish, &[]),
        (Kind::Rate, &[1]),
        (Kind::Rate, &4_000_000_u32.to_le_bytes()),
        (Kind::Rate, &0_u32.to_le_bytes()),
        (Kind::Rate, &9_600_u32.to_le_bytes()),
    ] {
        assert_eq!(asks(kind, payload), (Err(Refusal::Request), Effect::None));
    }
    let rate = asks(Kind::Rate, &3_000_000_u32.to_le_bytes());
    assert_eq!(rate, (Ok(0), Effect::Rate(3_000_000)));
    assert_eq!(asks(Kind::Boot, &[]), (Ok(0), Effect::Reset));
}

#[test]
fn a_flash_that_takes_nothing_is_named() {
    let (mut device, mut receiver, _) = scanner();
    let new = image(&maker(), |_| ());
    device.slots.flash_mut().deaf = true;
    let got = send(&mut receiver, &mut device, &new, usize::MAX);
    assert_eq!(got, Err(Refusal::Flash));
    assert_eq!(device.start(Asked::Nothing).unwrap().slot, Slot::A);
}

/// An image on trial is not executed, and no try is spent on it, until the supply allows to note the execution.
#[test]
fn a_supply_too_low_to_write_is_named_and_costs_nothing() {
    let (mut device, mut receiver, _) = scanner();
    let new = image(&maker(), |_| ());
    device.slots.flash_mut().refuses = Some(FlashFault::LowSupply);
    let got = send(&mut receiver, &mut device, &new, usize::MAX);
    assert_eq!(got, Err(Refusal::Supply));
    device.slots.flash_mut().refuses = None;
    send(&mut receiver, &mut device, &new, usize::MAX).unwrap();
    assert_eq!(ask(&mut receiver, &mut device, Kind::Finish, &[]).0, Ok(0));
    device.slots.flash_mut().refuses = Some(FlashFault::LowSupply);
    assert_eq!(device.start(Asked::Nothing).unwrap().slot, Slot::A);
    device.slots.flash_mut().refuses = None;
    let start = device.start(Asked::Nothing).unwrap();
    assert_eq!((start.slot, start.trial), (Slot::B, Some(1)));
}

/// A host of version 1 gets the answer that it knows; a newer one the option bytes, too.
#[test]
fn the_greeting_is_answered_in_the_version_of_the_older_side() {
    let (mut device, mut receiver, _) = scanner();
    receiver.option_bytes = OptionBytes::of_register(0x0fff_aaed);
    let mut hello = |payload: &[u8]| {
        let frame = Frame {
            kind: Kind::Hello as u8,
            sequence: 0,
            payload,
        };
        let (answer, _) = receiver.handle(frame, &mut device).unwrap();
        (answer.bytes().len(), Info::parse(answer.bytes()).unwrap())
    };
    let (length, old) = hello(&[]);
    // The length that a host of version 1 expects.
    assert_eq!((length, old.protocol, old.option_bytes), (96, 1, None));
    for version in [2, 3, 255] {
        let (length, new) = hello(&[version]);
        let option_bytes = new.option_bytes.map(OptionBytes::bits);
        assert_eq!((length, new.protocol), (100, 2));
        assert_eq!(option_bytes, Some(0x0fff_aaec));
        assert_eq!(new.slots, old.slots);
    }
}

/// A number is never lost that the image in force bears: it enters it again at its next boot.
#[test]
fn the_counter_survives_a_full_log_and_cuts_in_it() {
    for seed in 0..200 {
        let power = Power::new(seed);
        let mut floor = Floor::new(common::Model::new(1, &power));
        for number in 1..300 {
            power.borrow_mut().left = Some(1 + (seed as u32 + number) % 7);
            let before = floor.get();
            floor.raise(number);
            let cut = power.borrow().left == Some(0);
            power.borrow_mut().left = None;
            let got = floor.get();
            // An erasure that is cut short may leave any of the records.
            assert!(got == number || (cut && got <= before), "{got}");
            floor.raise(number);
            assert_eq!(floor.get(), number);
        }
    }
}
