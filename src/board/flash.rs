//! Driver of the chip's flash controller (RM0090 3.6, 3.9) behind `embedded_storage`'s traits, for image and loader.
//!
//! The registers are behind the trait [`Controller`], so that the tests run the driver on a model of them. A value
//! of FLASH_CR is always made from the one that was read: its reset value has LOCK set, and a write that begins from
//! it locks the controller again.
//!
//! `stm32f4xx-hal` has these traits for its own flash, but waits without bound and panics where the controller stays
//! locked.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

/// Words that unlock the controller when they are written to FLASH_KEYR one after the other (RM0090 3.6.1).
const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];
/// Timeout of writing one word, µs, which takes 100 at most (DS8626, table 42).
const WORD_US: u32 = 1_000;
/// Flags of FLASH_SR that are cleared by writing ones: EOP, OPERR, WRPERR, PGAERR, PGPERR, PGSERR.
const FLAGS: u32 = 0b1111_0011;
/// Flags of FLASH_SR that report an error: all of [`FLAGS`] but EOP.
const ERRORS: u32 = 0b1111_0010;
/// Flag of FLASH_SR: an operation is under way.
const BUSY: u32 = 1 << 16;

/// Bit PG of FLASH_CR: words of the flash may be written.
const PROGRAM: u32 = 1;
/// Bit SER of FLASH_CR: a start erases a sector.
const ERASE: u32 = 1 << 1;
/// Position of the field SNB of FLASH_CR, the number of a sector.
const SECTOR_SHIFT: u32 = 3;
/// Value of the field PSIZE of FLASH_CR: 32 bits at a time, for which the supply must be 2.7 V or more (RM0090
/// 3.6.2).
const WORDWISE: u32 = 0b10 << 8;
/// Fields of FLASH_CR that select an operation: PG, SER, MER, SNB, PSIZE.
const OPERATION: u32 = 0b11 << 8 | 0b1111 << SECTOR_SHIFT | 0b111;
/// Bit STRT of FLASH_CR: starts the erasure.
const START: u32 = 1 << 16;
/// Bit LOCK of FLASH_CR: set by writing one, cleared by the keys alone.
const LOCK: u32 = 1 << 31;

/// Bits ICEN and DCEN of FLASH_ACR: instruction and data cache are enabled.
const CACHES: u32 = 0b11 << 9;
/// Bits ICRST and DCRST of FLASH_ACR, which empty the caches and may be set only while these are disabled (RM0090
/// 3.9.1).
const CACHE_RESETS: u32 = 0b11 << 11;

/// Register of the flash controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Register {
    /// FLASH_ACR: wait states and caches.
    Access,
    /// FLASH_KEYR: takes the keys.
    Key,
    /// FLASH_SR: flags.
    Status,
    /// FLASH_CR: operation and lock.
    Control,
}

/// The flash controller, the flash itself and the voltage detector.
pub trait Controller {
    /// Returns the content of a register.
    fn get(&self, register: Register) -> u32;
    /// Writes a whole register.
    fn set(&mut self, register: Register, value: u32);
    /// Writes a word of flash; `address` is a multiple of four.
    fn write_word(&mut self, address: u32, word: u32);
    /// Fills `bytes` with the content of flash from `address` on.
    fn fetch(&self, address: u32, bytes: &mut [u8]);
    /// Whether the voltage detector, which must have been started, reports a supply above its level.
    fn supplied(&self) -> bool;
    /// Waits until `ended` returns `true`, or for `at_most_us` µs; returns whether it ended.
    fn wait(&self, at_most_us: u32, ended: impl FnMut() -> bool) -> bool;
}

/// Error of a flash operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    /// The range is not within the region, or not of whole words or sectors.
    Place,
    /// The supply is too low to write 32 bits at a time.
    Supply,
    /// The flash controller does not unlock, or its register does not read back as written.
    Controller,
    /// The operation did not end in time, or the controller reports an error.
    Failed,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            FlashError::Place => NorFlashErrorKind::OutOfBounds,
            FlashError::Supply | FlashError::Controller | FlashError::Failed => {
                NorFlashErrorKind::Other
            }
        }
    }
}

/// `COUNT` consecutive sectors of `SECTOR` bytes. The controller is unlocked only during an operation.
#[derive(Debug)]
pub struct Sectors<C, const SECTOR: usize, const COUNT: usize> {
    chip: C,
    base: u32,
    first: u32,
}

impl<C: Controller, const SECTOR: usize, const COUNT: usize> Sectors<C, SECTOR, COUNT> {
    /// Timeout of erasing one sector, µs: with 32 bits at a time one of 16 KB takes 500,000 at most, one of 128 KB
    /// 2,000,000 (DS8626, table 42).
    const SECTOR_US: u32 = if SECTOR > 16 * 1024 {
        4_000_000
    } else {
        1_000_000
    };

    /// Creates access to the region at address `base`, whose first sector has the number `first`.
    pub const fn new(chip: C, base: u32, first: u32) -> Self {
        Self { chip, base, first }
    }

    /// Returns the controller with its registers.
    #[cfg(test)]
    pub fn chip(&mut self) -> &mut C {
        &mut self.chip
    }

    /// Checks that the supply is high enough, that the controller unlocks, and that its register reads back as
    /// written. No content of the flash is changed.
    ///
    /// # Errors
    /// [`FlashError::Supply`], or [`FlashError::Controller`].
    pub fn check(&mut self) -> Result<(), FlashError> {
        self.unlocked(|region| region.select(0))
    }

    /// Unlocks the controller, performs `operation`, locks it, and empties the caches, which may hold content from
    /// before.
    fn unlocked(
        &mut self,
        operation: impl FnOnce(&mut Self) -> Result<(), FlashError>,
    ) -> Result<(), FlashError> {
        if !self.chip.supplied() {
            return Err(FlashError::Supply);
        }
        // A key that is written to an unlocked controller locks it until the next reset.
        if self.chip.get(Register::Control) & LOCK != 0 {
            KEYS.into_iter()
                .for_each(|key| self.chip.set(Register::Key, key));
        }
        if self.chip.get(Register::Control) & LOCK != 0 {
            return Err(FlashError::Controller);
        }
        let done = operation(self);
        self.lock();
        self.empty_caches();
        done
    }

    /// Selects an operation, by its bits of FLASH_CR, after clearing the flags of the one before.
    fn select(&mut self, operation: u32) -> Result<(), FlashError> {
        if !self.chip.supplied() {
            return Err(FlashError::Supply);
        }
        self.wait(WORD_US)?;
        self.chip.set(Register::Status, FLAGS);
        let selected = WORDWISE | operation;
        let others = self.chip.get(Register::Control) & !OPERATION;
        self.chip.set(Register::Control, others | selected);
        match self.chip.get(Register::Control) & (LOCK | OPERATION) == selected {
            true => Ok(()),
            false => Err(FlashError::Controller),
        }
    }

    fn lock(&mut self) {
        let control = self.chip.get(Register::Control);
        // Unless an error has locked it.
        if control & LOCK == 0 {
            self.chip.set(Register::Control, control & !OPERATION);
            self.chip
                .set(Register::Control, control & !OPERATION | LOCK);
        }
    }

    fn empty_caches(&mut self) {
        let before = self.chip.get(Register::Access) & !CACHE_RESETS;
        let disabled = before & !CACHES;
        for value in [disabled, disabled | CACHE_RESETS, disabled, before] {
            self.chip.set(Register::Access, value);
        }
    }

    /// Waits until no operation is under way, for `at_most_us` µs.
    fn wait(&self, at_most_us: u32) -> Result<(), FlashError> {
        let idle = || self.chip.get(Register::Status) & BUSY == 0;
        match self.chip.wait(at_most_us, idle) {
            true => Ok(()),
            false => Err(FlashError::Failed),
        }
    }

    /// Waits for the end of an operation, and returns whether it succeeded.
    fn finish(&self, at_most_us: u32) -> Result<(), FlashError> {
        self.wait(at_most_us)?;
        match self.chip.get(Register::Status) & ERRORS {
            0 => Ok(()),
            _ => Err(FlashError::Failed),
        }
    }

    /// Erases a sector, by its number within the region.
    fn erase_sector(&mut self, sector: u32) -> Result<(), FlashError> {
        self.select(ERASE | (self.first + sector) << SECTOR_SHIFT)?;
        let selected = self.chip.get(Register::Control);
        self.chip.set(Register::Control, selected | START);
        self.finish(Self::SECTOR_US)
    }

    fn write_words(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        self.select(PROGRAM)?;
        let (words, _) = bytes.as_chunks::<4>();
        for (k, &word) in (0..).zip(words) {
            let address = self.base + offset + 4 * k;
            self.chip.write_word(address, u32::from_le_bytes(word));
            self.finish(WORD_US)?;
        }
        Ok(())
    }

    /// Returns `offset`, bytes from the region's beginning, if the `length` bytes from there are within the region
    /// and begin and end on a multiple of `unit`.
    fn checked(offset: u32, length: usize, unit: usize) -> Result<u32, FlashError> {
        let from = offset as usize;
        let end = from.checked_add(length).ok_or(FlashError::Place)?;
        let whole = from.is_multiple_of(unit) && length.is_multiple_of(unit);
        if whole && end <= SECTOR * COUNT {
            Ok(offset)
        } else {
            Err(FlashError::Place)
        }
    }
}

impl<C, const SECTOR: usize, const COUNT: usize> ErrorType for Sectors<C, SECTOR, COUNT> {
    type Error = FlashError;
}

impl<C: Controller, const SECTOR: usize, const COUNT: usize> ReadNorFlash
    for Sectors<C, SECTOR, COUNT>
{
    const READ_SIZE: usize = 1;

    /// Bytes behind the region's end read as blank.
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        let end = SECTOR * COUNT;
        let from = (offset as usize).min(end);
        let (within, behind) = bytes.split_at_mut(bytes.len().min(end - from));
        self.chip.fetch(self.base + from as u32, within);
        behind.fill(0xff);
        Ok(())
    }

    fn capacity(&self) -> usize {
        SECTOR * COUNT
    }
}

impl<C: Controller, const SECTOR: usize, const COUNT: usize> NorFlash
    for Sectors<C, SECTOR, COUNT>
{
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let length = to.checked_sub(from).ok_or(FlashError::Place)? as usize;
        let first = Self::checked(from, length, SECTOR)? / SECTOR as u32;
        let mut sectors = first..first + (length / SECTOR) as u32;
        self.unlocked(|region| sectors.try_for_each(|sector| region.erase_sector(sector)))
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        let from = Self::checked(offset, bytes.len(), Self::WRITE_SIZE)?;
        self.unlocked(|region| region.write_words(from, bytes))
    }
}

#[cfg(test)]
#[path = "flash/tests.rs"]
mod tests;
