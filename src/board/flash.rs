//! The two sectors of the chip's flash that hold settings.
//!
//! Sectors 1 and 2, of 16 KB, among those of the boot loader (`boot/src/layout.rs`): the chip does
//! nothing else while it erases one, since its code lies in the same bank, and the 0.5 s that a small
//! sector takes at most are within the watchdog's timeout, where the 2 s of a large one are not.
//!
//! `stm32f4xx-hal` has these traits for its own flash, but waits without bound and panics where the
//! controller stays locked.

use core::ptr;

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use stm32f4xx_hal::pac;

use super::time::Time;

/// Size of a flash sector, bytes.
const SECTOR: usize = 16 * 1024;
/// Number of the first of the two sectors of settings.
const FIRST: u8 = 1;
/// Address of the first of the two sectors.
const BASE: usize = 0x0800_4000;
/// Words that unlock the controller when they are written to FLASH_KEYR one after the other (RM0090 3.9.3).
const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];
/// Timeout of writing one word, µs, which takes 100 at most (DS8626, table 42).
const WORD_US: u32 = 1_000;
/// Timeout of erasing one sector, µs, which takes 500,000 at most with 32 bits at a time (DS8626, table 42).
const SECTOR_US: u32 = 1_000_000;
/// Flags of FLASH_SR that are cleared by writing ones: EOP, OPERR, WRPERR, PGAERR, PGPERR, PGSERR.
const FLAGS: u32 = 0b1111_0011;
/// Flags of FLASH_SR that report an error: all of [`FLAGS`] but EOP.
const ERRORS: u32 = 0b1111_0010;
/// Value of PSIZE in FLASH_CR: 32 bits are written at a time, for which the supply must be 2.7 V or more.
const WORDWISE: u8 = 0b10;

/// The two flash sectors that hold the settings.
#[derive(Debug)]
pub struct ChipFlash {
    regs: pac::FLASH,
}

/// Error of a flash operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    /// The range is not within the two sectors, or not of whole words or sectors.
    Place,
    /// The flash controller does not unlock, or its register does not read back as written.
    Controller,
    /// The operation did not end in time, or the controller reports an error.
    Failed,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            FlashError::Place => NorFlashErrorKind::OutOfBounds,
            FlashError::Controller | FlashError::Failed => NorFlashErrorKind::Other,
        }
    }
}

impl ChipFlash {
    /// Creates access to the two sectors by the controller's registers; the controller is unlocked only while it
    /// writes or erases.
    pub fn new(regs: pac::FLASH) -> Self {
        Self { regs }
    }

    /// Whether the flash controller responds: it unlocks, and its register reads back as written. No content of
    /// the flash is changed.
    pub fn answers(&mut self) -> bool {
        let answers = self.unlock().is_ok();
        self.lock();
        answers
    }

    fn unlock(&mut self) -> Result<(), FlashError> {
        for key in KEYS {
            self.regs.keyr().write(|w| w.key().set(key));
        }
        self.regs.cr().write(|w| w.psize().set(WORDWISE));
        let control = self.regs.cr().read();
        if control.lock().bit_is_set() || control.psize().bits() != WORDWISE {
            return Err(FlashError::Controller);
        }
        // SAFETY: ones clear these flags, zeros leave the others.
        self.regs.sr().write(|w| unsafe { w.bits(FLAGS) });
        Ok(())
    }

    /// Locks the controller, and empties the data cache, which may hold the content from before a write or
    /// erasure.
    fn lock(&mut self) {
        self.regs.cr().write(|w| w.lock().set_bit());
        let cached = self.regs.acr().read().dcen().bit_is_set();
        self.regs.acr().modify(|_, w| w.dcen().clear_bit());
        self.regs.acr().modify(|_, w| w.dcrst().set_bit());
        self.regs.acr().modify(|_, w| w.dcrst().clear_bit());
        self.regs.acr().modify(|_, w| w.dcen().bit(cached));
    }

    /// Waits for the end of the current operation, `at_most_us` µs at most.
    fn wait(&self, at_most_us: u32) -> Result<(), FlashError> {
        let begun = Time::now_anywhere();
        while self.regs.sr().read().bsy().bit_is_set() {
            if Time::now_anywhere().since(begun) > at_most_us {
                return Err(FlashError::Failed);
            }
        }
        match self.regs.sr().read().bits() & ERRORS {
            0 => Ok(()),
            _ => Err(FlashError::Failed),
        }
    }

    fn erase_sector(&mut self, sector: u8) -> Result<(), FlashError> {
        self.regs.cr().write(|w| {
            let w = w.psize().set(WORDWISE).ser().set_bit();
            // SAFETY: a sector's number, checked by the caller, in a field of four bits.
            unsafe { w.snb().bits(sector) }
        });
        self.regs.cr().modify(|_, w| w.strt().set_bit());
        self.wait(SECTOR_US)
    }

    fn write_words(&mut self, offset: usize, bytes: &[u8]) -> Result<(), FlashError> {
        self.regs
            .cr()
            .write(|w| w.psize().set(WORDWISE).pg().set_bit());
        let (words, _) = bytes.as_chunks::<4>();
        for (k, &word) in words.iter().enumerate() {
            let place = (BASE + offset + 4 * k) as *mut u32;
            // SAFETY: within the two sectors, on a word's bounds (`checked`); no code and no variable
            // lies there.
            unsafe { ptr::write_volatile(place, u32::from_le_bytes(word)) };
            self.wait(WORD_US)?;
        }
        Ok(())
    }
}

/// Returns `offset`, bytes from the first sector's beginning, if the `length` bytes from there are within the two
/// sectors and begin and end on a multiple of `unit`.
fn checked(offset: u32, length: usize, unit: usize) -> Result<usize, FlashError> {
    let from = offset as usize;
    let end = from.checked_add(length).ok_or(FlashError::Place)?;
    let whole = from.is_multiple_of(unit) && length.is_multiple_of(unit);
    if whole && end <= 2 * SECTOR {
        Ok(from)
    } else {
        Err(FlashError::Place)
    }
}

impl ErrorType for ChipFlash {
    type Error = FlashError;
}

impl ReadNorFlash for ChipFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        let from = checked(offset, bytes.len(), 1)?;
        for (k, byte) in bytes.iter_mut().enumerate() {
            let place = (BASE + from + k) as *const u8;
            // SAFETY: within the two sectors, which are always mapped; any bits are a byte.
            *byte = unsafe { ptr::read_volatile(place) };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        2 * SECTOR
    }
}

impl NorFlash for ChipFlash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let length = to.checked_sub(from).ok_or(FlashError::Place)? as usize;
        let first = checked(from, length, SECTOR)? / SECTOR;
        let erased = self.unlock().and_then(|()| {
            (first..first + length / SECTOR)
                .try_for_each(|sector| self.erase_sector(FIRST + sector as u8))
        });
        self.lock();
        erased
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        let from = checked(offset, bytes.len(), Self::WRITE_SIZE)?;
        let written = self.unlock().and_then(|()| self.write_words(from, bytes));
        self.lock();
        written
    }
}
