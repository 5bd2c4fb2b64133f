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

/// Bytes of a sector.
const SECTOR: usize = 16 * 1024;
/// Number of the first sector.
const FIRST: u8 = 1;
/// Where it lies.
const BASE: usize = 0x0800_4000;
/// FLASH_KEYR (RM0090 3.9.3): these two, one after the other, unlock the controller.
const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];
/// For one word, µs: 100 at most (DS8626, table 42).
const WORD_US: u32 = 1_000;
/// For one sector, µs: 500,000 at most with 32 bits at a time (DS8626, table 42).
const SECTOR_US: u32 = 1_000_000;
/// Flags of FLASH_SR that a one clears: EOP, OPERR, WRPERR, PGAERR, PGPERR, PGSERR.
const FLAGS: u32 = 0b1111_0011;
/// Those of them that are errors.
const ERRORS: u32 = 0b1111_0010;
/// 32 bits at a time, which 2.7 V and more allow.
const WORDWISE: u8 = 0b10;

/// The sectors of settings.
#[derive(Debug)]
pub struct ChipFlash {
    regs: pac::FLASH,
}

/// Why the flash did not do what it should.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    /// Outside the two sectors, or not on whole words or sectors.
    Place,
    /// The controller does not unlock, or does not take what is written to it.
    Controller,
    /// It did not come to its end in time, or says that it failed.
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
    /// Over the controller, which stays locked but for writing and erasing.
    pub fn new(regs: pac::FLASH) -> Self {
        Self { regs }
    }

    /// Whether the controller answers: what is written to it reads back. Nothing is changed.
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

    /// Locks the controller, and empties the data cache, which may hold what stood there before.
    fn lock(&mut self) {
        self.regs.cr().write(|w| w.lock().set_bit());
        let cached = self.regs.acr().read().dcen().bit_is_set();
        self.regs.acr().modify(|_, w| w.dcen().clear_bit());
        self.regs.acr().modify(|_, w| w.dcrst().set_bit());
        self.regs.acr().modify(|_, w| w.dcrst().clear_bit());
        self.regs.acr().modify(|_, w| w.dcen().bit(cached));
    }

    /// Waits for the end of what has begun.
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

/// `offset` where `length` bytes from there lie within the sectors and begin and end on whole `unit`s.
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
