//! Tests of the log on a flash that loses power during any write or erasure.

use super::*;
use crate::testing::flash::{Flash, FlashFault, Power};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::{format, vec, vec::Vec};

/// Bytes of a sector of the simulated flash: two slots, so that every third save erases.
const SECTOR: usize = 2 * SLOT as usize;

/// The two sectors of settings.
type Model = Flash<SECTOR>;

/// Returns erased flash; `seed` selects what power cuts leave.
fn erased(seed: u64) -> Model {
    Flash::new(2, &Power::new(seed))
}

fn settings(seed: u32) -> Settings {
    let mut settings = Settings::default();
    settings.set("seed", &format!("{seed}")).unwrap();
    let height = format!("{}", 30_000 + seed % 20_000);
    settings.set("mount-height", &height).unwrap();
    settings
}

/// Returns the settings that a scanner loads when it boots on this flash.
fn reboot(store: &mut Store<Model>) -> Option<Settings> {
    let mut flash = store.flash.fork();
    flash.cut_after(None);
    Store::new(flash).load()
}

#[test]
fn what_was_saved_last_is_loaded() {
    let mut store = Store::new(erased(1));
    assert_eq!(store.load(), None);
    for seed in 1..50 {
        store.save(&settings(seed)).unwrap();
        assert_eq!(reboot(&mut store), Some(settings(seed)));
    }
    let erasures: u64 = store.flash.erasures.iter().sum();
    assert!(
        (20..=25).contains(&erasures),
        "a slot is used once: {erasures}"
    );
    let operations = store.flash.operations();
    store.save(&settings(49)).unwrap();
    assert_eq!(
        store.flash.operations(),
        operations,
        "nothing new, nothing written"
    );
}

/// Power fails at every single word written and at every erasure, over saves that fill and change sectors.
#[test]
fn a_power_cut_leaves_the_old_or_the_new() {
    let mut whole = Store::new(erased(2));
    for saved in 1..=6 {
        let before = whole.flash.operations();
        let old = (saved > 1).then(|| settings(saved - 1));
        let mut next = whole.flash.fork();
        next.cut_after(None);
        let mut uncut = Store::new(next);
        uncut.save(&settings(saved)).unwrap();
        let operations = uncut.flash.operations() - before;
        assert!(operations >= RECORD as u32);
        let (mut olds, mut news) = (0, 0);
        for cut in 1..=operations {
            let mut flash = whole.flash.fork();
            flash.cut_after(Some(cut));
            let mut store = Store::new(flash);
            let reported = store.save(&settings(saved));
            let found = reboot(&mut store);
            assert!(
                reported.is_err(),
                "a save that was cut short is not told as done"
            );
            if found == Some(settings(saved)) {
                news += 1;
            } else {
                assert_eq!(found, old, "save {saved}, cut {cut} of {operations}");
                olds += 1;
            }
            // The next save always works.
            store.flash.cut_after(None);
            store.save(&settings(99)).unwrap();
            assert_eq!(reboot(&mut store), Some(settings(99)));
        }
        assert!(olds >= operations - 2 && news <= 2, "{olds} {news}");
        whole = uncut;
    }
}

/// Makes 10^5 saves on one flash, most of them interrupted somewhere, without any loss.
#[test]
fn a_hundred_thousand_random_power_cuts_lose_nothing() {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(3);
    let mut store = Store::new(erased(4));
    store.save(&settings(0)).unwrap();
    let (mut old, mut cuts, mut seed) = (settings(0), 0, 0);
    while cuts < 100_000 {
        seed += 1;
        let new = settings(seed);
        // The power fails at any operation of a save, one for each word and one for an erasure, or not at all.
        let cut = random.next_u32() % (RECORD as u32 + 2) + 1;
        store.flash.cut_after(Some(cut));
        let reported = store.save(&new);
        cuts += u32::from(reported.is_err());
        store.flash.cut_after(None);
        let found = store.load();
        match reported {
            Ok(()) => assert_eq!(found, Some(new)),
            Err(_) => assert!(found == Some(old) || found == Some(new), "cut {cuts}"),
        }
        old = found.unwrap();
    }
}

#[test]
fn a_flash_that_takes_nothing_is_reported_and_harms_nothing() {
    let mut store = Store::new(erased(5));
    for seed in [1, 2] {
        store.save(&settings(seed)).unwrap();
    }
    store.flash.refuses = Some(FlashFault::Controller);
    // The first sector is full.
    assert_eq!(store.save(&settings(3)), Err(StoreError::Erase));
    store.flash.refuses = None;
    store.save(&settings(3)).unwrap();
    store.flash.refuses = Some(FlashFault::Controller);
    assert_eq!(store.save(&settings(4)), Err(StoreError::Write));
    store.flash.refuses = None;
    store.flash.deaf = true;
    assert_eq!(store.save(&settings(4)), Err(StoreError::Write));
    assert_eq!(store.load(), Some(settings(3)));
}

#[test]
fn a_record_with_any_bit_changed_is_none() {
    let mut store = Store::new(erased(6));
    store.save(&settings(1)).unwrap();
    for bit in 0..8 * 4 * RECORD {
        store.flash.bytes[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(store.load(), None, "bit {bit}");
        store.flash.bytes[bit / 8] ^= 1 << (bit % 8);
    }
    // A memory with one value everywhere holds no record, either.
    for pattern in [0, 0x55, 0xff] {
        store.flash.bytes.fill(pattern);
        assert_eq!(store.load(), None);
    }
}

/// Defaults never replace what another firmware saved: no user has requested them.
#[test]
fn what_another_firmware_saved_is_neither_used_nor_replaced_by_older_settings() {
    let mut store = Store::new(erased(7));
    store.save(&settings(1)).unwrap();
    // One more key.
    let mut record = vec![MAGIC, 2, LAYOUT + 1, WORDS as u32 + 1];
    record.extend(settings(2).words());
    record.push(0);
    record.push(crc::of_words(&record));
    let bytes: Vec<u8> = record.iter().flat_map(|word| word.to_le_bytes()).collect();
    store.flash.write(SLOT, &bytes).unwrap();
    assert_eq!(store.load(), None);
    store.save(&settings(3)).unwrap();
    assert_eq!(store.load(), Some(settings(3)));
}
