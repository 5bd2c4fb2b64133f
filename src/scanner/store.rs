//! Non-volatile settings: a log in two sectors of flash, behind `embedded-storage`'s traits.
//!
//! Each sector is divided into slots of [`SLOT`] bytes. A slot holds one record, which is written once and
//! stays until its sector is erased:
//!
//! | word | content (32 bits, little-endian) |
//! |---|---|
//! | 0 | `STC1`: a record of settings, version 1 of this format |
//! | 1 | sequence number: the record with the highest one is valid |
//! | 2 | hash of the keys in their order ([`LAYOUT`]): another firmware may have other keys |
//! | 3 | n, number of values |
//! | 4 ... | the values, in the order of the keys, encoded as in [`Settings::hash`], none left out |
//! | 4 + n | CRC-32 (ISO-HDLC) of everything before it |
//!
//! A new record goes to the slot after the last one that is not blank. When the sector is full, the other one,
//! which holds only older records, is erased and written. So the record in force stays untouched until the next
//! one is complete: after a power failure at any time, either the old or the new record is read. A sector is
//! always erased before its first slot is written, even when it reads as blank: an interrupted erasure may
//! leave bits that read as blank but are not stable.

use embedded_storage::nor_flash::NorFlash;

use super::record::{LAYOUT, WORDS};
use super::settings::Settings;
use crate::crc;

/// Size of a slot, the place of one record in flash, bytes.
pub const SLOT: u32 = 1024;
/// Number of words of a record before its values.
const HEAD: usize = 4;
/// First word of a record: identifies the format.
const MAGIC: u32 = u32::from_le_bytes(*b"STC1");
/// Number of words of a slot.
const MAX_WORDS: usize = SLOT as usize / 4;
/// Number of words of a record: those before the values, the values, and the CRC.
const RECORD: usize = HEAD + WORDS + 1;
const _: () = assert!(RECORD <= MAX_WORDS, "a slot holds a record");

/// Cause of a failed save. The previous record is still in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoreError {
    /// The supply is too low to write flash.
    Supply,
    /// The flash cannot be written, or its controller does not answer.
    Controller,
    /// A sector could not be erased.
    Erase,
    /// A record could not be written, or does not read back as it was written.
    Write,
}

impl StoreError {
    /// Returns the condition that the flash did not meet, for the field `expected` of the sentence `FAIL`.
    pub const fn expected(self) -> &'static str {
        match self {
            StoreError::Supply => "a supply that flash can be written with",
            StoreError::Controller => "a responding flash controller",
            StoreError::Erase => "a sector that can be erased",
            StoreError::Write => "a record that verifies",
        }
    }
}

/// The stored records of settings in a flash of two sectors.
#[derive(Debug)]
pub struct Store<F> {
    flash: F,
}

/// A complete record in flash, whose CRC is right.
#[derive(Clone, Copy, Debug)]
struct ValidRecord {
    slot: u32,
    number: u32,
    /// Values of the record, one for each setting; `None` if another firmware with other keys wrote it.
    values: Option<[u32; WORDS]>,
}

impl<F: NorFlash> Store<F> {
    const SECTOR: u32 = F::ERASE_SIZE as u32;
    /// Number of slots of a sector.
    const SLOTS: u32 = Self::SECTOR / SLOT;

    /// Creates the store in `flash`, whose capacity is two sectors of [`NorFlash::ERASE_SIZE`] bytes.
    pub fn new(flash: F) -> Self {
        const {
            assert!(F::ERASE_SIZE.is_multiple_of(SLOT as usize));
            assert!(4 % F::WRITE_SIZE == 0 && F::READ_SIZE == 1);
        }
        Self { flash }
    }

    /// Returns the flash.
    pub fn flash_mut(&mut self) -> &mut F {
        &mut self.flash
    }

    /// Returns the settings that were saved last; `None` if there are none, or another firmware saved them.
    pub fn load(&mut self) -> Option<Settings> {
        Settings::from_words(&self.newest()?.values?)
    }

    /// Saves `settings`, unless they equal the record in force.
    ///
    /// # Errors
    /// Names the flash operation that failed; the previous record stays in force.
    pub fn save(&mut self, settings: &Settings) -> Result<(), StoreError> {
        let values = settings.words();
        let newest = self.newest();
        if newest.and_then(|found| found.values) == Some(values) {
            return Ok(());
        }
        let (slot, number) = match newest {
            Some(ValidRecord { slot, number, .. }) => match self.free_behind(slot) {
                Some(slot) => (slot, number.saturating_add(1)),
                None => (
                    self.erase(1 - (slot / Self::SLOTS).min(1))?,
                    number.saturating_add(1),
                ),
            },
            None => (self.erase(0)?, 1),
        };
        self.write(slot, number, &values)
    }

    /// Erases `sector` (0 or 1) and returns the index of its first slot.
    fn erase(&mut self, sector: u32) -> Result<u32, StoreError> {
        let (from, to) = (sector * Self::SECTOR, (sector + 1) * Self::SECTOR);
        self.flash.erase(from, to).map_err(|_| StoreError::Erase)?;
        let first = sector * Self::SLOTS;
        let mut slots = first..first + Self::SLOTS;
        if slots.all(|slot| self.is_blank(slot)) {
            Ok(first)
        } else {
            Err(StoreError::Erase)
        }
    }

    fn write(&mut self, slot: u32, number: u32, values: &[u32; WORDS]) -> Result<(), StoreError> {
        let mut record = [0; RECORD];
        for (place, word) in record
            .iter_mut()
            .zip([MAGIC, number, LAYOUT, WORDS as u32].iter().chain(values))
        {
            *place = *word;
        }
        let (crc, before) = record.split_last_mut().ok_or(StoreError::Write)?;
        *crc = crc::of_words(before);
        let mut bytes = [[0; 4]; RECORD];
        for (place, word) in bytes.iter_mut().zip(record) {
            *place = word.to_le_bytes();
        }
        let written = self.flash.write(slot * SLOT, bytes.as_flattened());
        let back = self.record(slot).and_then(|found| found.values);
        if written.is_ok() && back.as_ref() == Some(values) {
            Ok(())
        } else {
            Err(StoreError::Write)
        }
    }

    /// Returns the first slot after `slot` in its sector from which on all slots are blank; `None` if there is
    /// none.
    fn free_behind(&mut self, slot: u32) -> Option<u32> {
        let end = (slot / Self::SLOTS + 1) * Self::SLOTS;
        let blank = (slot + 1..end).rev().take_while(|&k| self.is_blank(k));
        blank.last()
    }

    /// Returns word `k` of slot `slot`, from 0; 0 if the flash cannot be read.
    fn word(&mut self, slot: u32, k: usize) -> u32 {
        let mut bytes = [0; 4];
        match self.flash.read(slot * SLOT + 4 * k as u32, &mut bytes) {
            Ok(()) => u32::from_le_bytes(bytes),
            Err(_) => 0,
        }
    }

    fn is_blank(&mut self, slot: u32) -> bool {
        (0..MAX_WORDS).all(|k| self.word(slot, k) == u32::MAX)
    }

    /// Returns the valid record with the highest sequence number; `None` if no slot has a valid one.
    fn newest(&mut self) -> Option<ValidRecord> {
        let mut newest: Option<ValidRecord> = None;
        for slot in 0..2 * Self::SLOTS {
            if let Some(found) = self.record(slot)
                && newest.is_none_or(|newest| found.number > newest.number)
            {
                newest = Some(found);
            }
        }
        newest
    }

    /// Returns the record in slot `slot`; `None` if it is not complete or its CRC is wrong.
    fn record(&mut self, slot: u32) -> Option<ValidRecord> {
        if self.word(slot, 0) != MAGIC {
            return None;
        }
        let mut words = [0; MAX_WORDS];
        for (k, word) in words.iter_mut().enumerate() {
            *word = self.word(slot, k);
        }
        let [_, number, layout, count, rest @ ..] = words;
        let (before, behind) = words.split_at_checked(HEAD + count.min(SLOT) as usize)?;
        if behind.first() != Some(&crc::of_words(before)) {
            return None;
        }
        let values = rest.first_chunk().copied();
        let ours = layout == LAYOUT && count == WORDS as u32;
        Some(ValidRecord {
            slot,
            number,
            values: values.filter(|_| ours),
        })
    }
}

#[cfg(test)]
mod tests;
