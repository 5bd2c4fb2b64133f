//! Sectors of the chip's flash behind `embedded_storage`'s traits.
//!
//! The chip does nothing else while it erases, since its code lies in the same bank: 2 s for a sector of 128 KB (DS8626, table
//! 42, 32 bits at a time), during which bytes of the report port are lost. The host waits for each answer, so none come; and the
//! watchdog waits longer.

use core::ptr;

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use stm32f4xx_hal::pac;

/// FLASH_KEYR (RM0090 3.9.3): these two, one after the other, unlock the controller.
const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];
/// Polls of the busy flag until the controller is given up: each takes some clocks, and none pass while the chip stands still
/// in an erasure.
const POLLS: u32 = 100_000_000;
/// Flags of FLASH_SR that a one clears: EOP, OPERR, WRPERR, PGAERR, PGPERR, PGSERR.
const FLAGS: u32 = 0b1111_0011;
/// Those of them that are errors.
const ERRORS: u32 = 0b1111_0010;
/// 32 bits at a time, which 2.7 V and more allow.
const WORDWISE: u8 = 0b10;

/// `COUNT` sectors of `SECTOR` bytes, one behind the other.
#[derive(Debug)]
pub struct Region<const SECTOR: usize, const COUNT: usize> {
    base: u32,
    first: u8,
}

/// Why the flash did not do what it should.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    /// Outside the region, or not on whole words or sectors.
    Place,
    /// The controller does not unlock, or does not take what is written to it.
    Controller,
    /// It did not come to its end, or says that it failed.
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

fn regs() -> &'static pac::flash::RegisterBlock {
    // SAFETY: a device's registers, always there; nothing interrupts the loader.
    unsafe { &*pac::FLASH::ptr() }
}

fn unlock() -> Result<(), FlashError> {
    for key in KEYS {
        regs().keyr().write(|w| w.key().set(key));
    }
    regs().cr().write(|w| w.psize().set(WORDWISE));
    let control = regs().cr().read();
    if control.lock().bit_is_set() || control.psize().bits() != WORDWISE {
        return Err(FlashError::Controller);
    }
    // SAFETY: ones clear these flags, zeros leave the others.
    regs().sr().write(|w| unsafe { w.bits(FLAGS) });
    Ok(())
}

/// Locks the controller, and empties both caches, which may hold what stood there before.
fn lock() {
    regs().cr().write(|w| w.lock().set_bit());
    let before = regs().acr().read();
    let (data, code) = (before.dcen().bit_is_set(), before.icen().bit_is_set());
    regs()
        .acr()
        .modify(|_, w| w.dcen().clear_bit().icen().clear_bit());
    regs()
        .acr()
        .modify(|_, w| w.dcrst().set_bit().icrst().set_bit());
    regs()
        .acr()
        .modify(|_, w| w.dcrst().clear_bit().icrst().clear_bit());
    regs()
        .acr()
        .modify(|_, w| w.dcen().bit(data).icen().bit(code));
    // What was read before is not what stands there now, for the compiler neither.
    cortex_m::asm::dsb();
}

fn wait() -> Result<(), FlashError> {
    let ended = (0..POLLS).any(|_| regs().sr().read().bsy().bit_is_clear());
    match ended && regs().sr().read().bits() & ERRORS == 0 {
        true => Ok(()),
        false => Err(FlashError::Failed),
    }
}

impl<const SECTOR: usize, const COUNT: usize> Region<SECTOR, COUNT> {
    /// The region at address `base`, whose first sector has this number.
    pub const fn new(base: u32, first: u8) -> Self {
        Self { base, first }
    }

    /// `offset` where `length` bytes from there lie within the region and begin and end on whole `unit`s.
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

    fn write_words(&self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        regs()
            .cr()
            .write(|w| w.psize().set(WORDWISE).pg().set_bit());
        let (words, _) = bytes.as_chunks::<4>();
        for (k, &word) in (0_u32..).zip(words) {
            let place = (self.base + offset + 4 * k) as *mut u32;
            // SAFETY: within the region, on a word's bounds (`checked`); nothing of the loader lies there.
            unsafe { ptr::write_volatile(place, u32::from_le_bytes(word)) };
            wait()?;
        }
        Ok(())
    }
}

impl<const SECTOR: usize, const COUNT: usize> ErrorType for Region<SECTOR, COUNT> {
    type Error = FlashError;
}

impl<const SECTOR: usize, const COUNT: usize> ReadNorFlash for Region<SECTOR, COUNT> {
    const READ_SIZE: usize = 1;

    /// Bytes behind the region's end read as blank.
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        let end = SECTOR * COUNT;
        let from = (offset as usize).min(end);
        let (within, behind) = bytes.split_at_mut(bytes.len().min(end - from));
        let place = (self.base as usize + from) as *const u8;
        // SAFETY: within the region, which is always mapped; nobody writes there meanwhile.
        within.copy_from_slice(unsafe { core::slice::from_raw_parts(place, within.len()) });
        behind.fill(0xff);
        Ok(())
    }

    fn capacity(&self) -> usize {
        SECTOR * COUNT
    }
}

impl<const SECTOR: usize, const COUNT: usize> NorFlash for Region<SECTOR, COUNT> {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let length = to.checked_sub(from).ok_or(FlashError::Place)? as usize;
        let first = Self::checked(from, length, SECTOR)? as usize / SECTOR;
        let erase = |sector: usize| {
            regs().cr().write(|w| {
                let w = w.psize().set(WORDWISE).ser().set_bit();
                // SAFETY: a sector's number, within the region, in a field of four bits.
                unsafe { w.snb().bits(self.first + sector as u8) }
            });
            regs().cr().modify(|_, w| w.strt().set_bit());
            wait()
        };
        let erased = unlock().and_then(|()| (first..first + length / SECTOR).try_for_each(erase));
        lock();
        erased
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        let from = Self::checked(offset, bytes.len(), Self::WRITE_SIZE)?;
        let written = unlock().and_then(|()| self.write_words(from, bytes));
        lock();
        written
    }
}
