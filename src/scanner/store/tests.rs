//! Tests of the log on a flash that loses power during any write or erasure.

use super::*;
use embedded_storage::nor_flash::{ErrorType, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::{format, vec, vec::Vec};

/// Bytes of a sector of the simulated flash: two slots, so that every third save erases.
const SECTOR: usize = 2 * SLOT as usize;

/// Simulated NOR flash of two sectors: writing clears bits, erasing sets all of a sector.
#[derive(Clone, Debug)]
struct Model {
    bytes: Vec<u8>,
    /// Number of operations (words written, sectors erased) that remain until the power fails; `None`: it does not.
    left: Option<u32>,
    random: Xoshiro128PlusPlus,
    /// Whether the controller refuses every operation.
    dead: bool,
    /// Whether writes have no effect.
    deaf: bool,
    operations: u32,
    erasures: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct PowerLost;

impl NorFlashError for PowerLost {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl Model {
    fn new(seed: u64) -> Self {
        Self {
            bytes: vec![0xff; 2 * SECTOR],
            left: None,
            random: Xoshiro128PlusPlus::seed_from_u64(seed),
            dead: false,
            deaf: false,
            operations: 0,
            erasures: 0,
        }
    }

    /// Counts an operation that begins now; returns whether the power fails during it, or an error if it has
    /// failed before.
    fn cut(&mut self) -> Result<bool, PowerLost> {
        self.operations += 1;
        match &mut self.left {
            _ if self.dead => Err(PowerLost),
            None => Ok(false),
            Some(0) => Err(PowerLost),
            Some(left) => {
                *left -= 1;
                Ok(*left == 0)
            }
        }
    }
}

impl ErrorType for Model {
    type Error = PowerLost;
}

impl ReadNorFlash for Model {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), PowerLost> {
        let from = offset as usize;
        bytes.copy_from_slice(&self.bytes[from..from + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Model {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), PowerLost> {
        assert!((from as usize).is_multiple_of(SECTOR) && to - from == SECTOR as u32);
        self.erasures += 1;
        let short = self.cut()?;
        // State after an interrupted erasure: some bits of each byte are set, few of them, or all.
        let depth = self.random.next_u32() % 3;
        for byte in &mut self.bytes[from as usize..to as usize] {
            *byte |= match (short, depth) {
                (false, _) | (true, 2) => 0xff,
                (true, 1) => self.random.next_u32() as u8,
                (true, _) => (self.random.next_u32() & self.random.next_u32()) as u8 & 0x11,
            };
        }
        if short { Err(PowerLost) } else { Ok(()) }
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), PowerLost> {
        assert!(offset.is_multiple_of(4) && bytes.len().is_multiple_of(4));
        for (k, word) in bytes.chunks(4).enumerate() {
            let short = self.cut()?;
            let at = offset as usize + 4 * k;
            for (place, &byte) in self.bytes[at..at + 4].iter_mut().zip(word) {
                assert!(
                    self.deaf || *place == 0xff,
                    "written twice without an erasure"
                );
                let kept = if short {
                    self.random.next_u32() as u8
                } else {
                    0
                };
                *place &= byte | kept | if self.deaf { 0xff } else { 0 };
            }
            if short {
                return Err(PowerLost);
            }
        }
        Ok(())
    }
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
    let mut flash = store.flash.clone();
    flash.left = None;
    Store::new(flash).load()
}

#[test]
fn what_was_saved_last_is_loaded() {
    let mut store = Store::new(Model::new(1));
    assert_eq!(store.load(), None);
    for seed in 1..50 {
        store.save(&settings(seed)).unwrap();
        assert_eq!(reboot(&mut store), Some(settings(seed)));
    }
    let erasures = store.flash.erasures;
    assert!(
        (20..=25).contains(&erasures),
        "a slot is used once: {erasures}"
    );
    let operations = store.flash.operations;
    store.save(&settings(49)).unwrap();
    assert_eq!(
        store.flash.operations, operations,
        "nothing new, nothing written"
    );
}

/// Power fails at every single word written and at every erasure, over saves that fill and change sectors.
#[test]
fn a_power_cut_leaves_the_old_or_the_new() {
    let mut whole = Store::new(Model::new(2));
    for saved in 1..=6 {
        let before = whole.flash.operations;
        let old = (saved > 1).then(|| settings(saved - 1));
        let mut next = whole.flash.clone();
        next.left = None;
        let mut uncut = Store::new(next);
        uncut.save(&settings(saved)).unwrap();
        let operations = uncut.flash.operations - before;
        assert!(operations >= RECORD as u32);
        let (mut olds, mut news) = (0, 0);
        for cut in 1..=operations {
            let mut flash = whole.flash.clone();
            flash.left = Some(cut);
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
            store.flash.left = None;
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
    let mut store = Store::new(Model::new(4));
    store.save(&settings(0)).unwrap();
    let (mut old, mut cuts, mut seed) = (settings(0), 0, 0);
    while cuts < 100_000 {
        seed += 1;
        let new = settings(seed);
        // The power fails at any operation of a save, one for each word and one for an erasure, or not at all.
        store.flash.left = Some(random.next_u32() % (RECORD as u32 + 2) + 1);
        let reported = store.save(&new);
        cuts += u32::from(reported.is_err());
        store.flash.left = None;
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
    let mut store = Store::new(Model::new(5));
    for seed in [1, 2] {
        store.save(&settings(seed)).unwrap();
    }
    store.flash.dead = true;
    // The first sector is full.
    assert_eq!(store.save(&settings(3)), Err(StoreError::Erase));
    store.flash.dead = false;
    store.save(&settings(3)).unwrap();
    store.flash.dead = true;
    assert_eq!(store.save(&settings(4)), Err(StoreError::Write));
    store.flash.dead = false;
    store.flash.deaf = true;
    assert_eq!(store.save(&settings(4)), Err(StoreError::Write));
    assert_eq!(store.load(), Some(settings(3)));
}

#[test]
fn a_record_with_any_bit_changed_is_none() {
    let mut store = Store::new(Model::new(6));
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
    let mut store = Store::new(Model::new(7));
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
