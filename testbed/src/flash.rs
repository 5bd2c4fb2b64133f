//! NOR flash in memory: a write clears bits, an erasure sets all bits of a sector.
//!
//! In: reads, writes and erasures by the traits of `embedded-storage`, and faults on command. Out: content, wear, and what
//! a power cut in the middle of an operation leaves.

use std::cell::RefCell;
use std::rc::Rc;

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Unit of writing, bytes.
pub const WORD: usize = 4;

/// Supply of one or more flash memories, which may fail.
#[derive(Clone, Debug)]
pub struct Power {
    /// Number of operations (words written, sectors erased) until the supply fails, the last one incomplete; `None`: it
    /// does not fail.
    pub left: Option<u32>,
    /// Number of operations begun, those without a supply included.
    pub operations: u32,
    random: Xoshiro128PlusPlus,
}

/// Supply that several flash memories share.
pub type SharedPower = Rc<RefCell<Power>>;

impl Power {
    /// Returns a supply that does not fail; `seed` selects what later cuts leave of an operation.
    pub fn new(seed: u64) -> SharedPower {
        Rc::new(RefCell::new(Self {
            left: None,
            operations: 0,
            random: Xoshiro128PlusPlus::seed_from_u64(seed),
        }))
    }
}

/// Error of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashFault {
    /// The supply failed during the operation or before it.
    PowerLost,
    /// The supply is too low to write or erase.
    LowSupply,
    /// The controller does not accept the operation.
    Controller,
    /// The operation is not allowed: a word that is not erased, or a place that is no word or no sector.
    Misuse,
}

impl NorFlashError for FlashFault {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Misuse => NorFlashErrorKind::NotAligned,
            Self::PowerLost | Self::LowSupply | Self::Controller => NorFlashErrorKind::Other,
        }
    }
}

/// NOR flash with sectors of `SECTOR` bytes. Copies share the supply.
#[derive(Clone, Debug)]
pub struct Flash<const SECTOR: usize> {
    /// Content.
    pub bytes: Vec<u8>,
    /// Supply, which other memories may share.
    pub power: SharedPower,
    /// Error of every write and erasure; `None`: they are accepted.
    pub refuses: Option<FlashFault>,
    /// Whether writes are accepted and have no effect.
    pub deaf: bool,
    /// Whether an operation that is not allowed returns an error and is counted; else it panics.
    pub counts_misuse: bool,
    /// Number of operations that were not allowed.
    pub misused: u64,
    /// Number of erasures of each sector.
    pub erasures: Vec<u64>,
    /// Number of words written.
    pub words: u64,
}

impl<const SECTOR: usize> Flash<SECTOR> {
    /// Returns erased flash of `sectors` sectors.
    pub fn new(sectors: usize, power: &SharedPower) -> Self {
        Self::with(vec![0xff; sectors * SECTOR], power)
    }

    /// Returns flash with the content `bytes`, whole sectors.
    pub fn with(bytes: Vec<u8>, power: &SharedPower) -> Self {
        assert!(bytes.len().is_multiple_of(SECTOR), "no whole sectors");
        Self {
            erasures: vec![0; bytes.len() / SECTOR],
            bytes,
            power: power.clone(),
            refuses: None,
            deaf: false,
            counts_misuse: false,
            misused: 0,
            words: 0,
        }
    }

    /// Returns a copy with a supply of its own, in the state of this one's.
    pub fn fork(&self) -> Self {
        Self {
            power: Rc::new(RefCell::new(self.power.borrow().clone())),
            ..self.clone()
        }
    }

    /// Erases the content without counting it: a fault.
    pub fn lose(&mut self) {
        self.bytes.fill(0xff);
    }

    /// Lets the supply fail after `operations` more operations; `None`: it does not fail.
    pub fn cut_after(&mut self, operations: Option<u32>) {
        self.power.borrow_mut().left = operations;
    }

    /// Returns the number of operations that were begun with this supply.
    pub fn operations(&self) -> u32 {
        self.power.borrow().operations
    }

    /// Counts an operation that begins now; returns whether the supply fails during it, or an error if it has failed
    /// before.
    fn begin(&mut self) -> Result<bool, FlashFault> {
        let mut power = self.power.borrow_mut();
        power.operations += 1;
        if let Some(fault) = self.refuses {
            return Err(fault);
        }
        match &mut power.left {
            None => Ok(false),
            Some(0) => Err(FlashFault::PowerLost),
            Some(left) => {
                *left -= 1;
                Ok(*left == 0)
            }
        }
    }

    /// Returns the error of an operation that is not `allowed`.
    fn check(&mut self, allowed: bool, what: &str, at: u32) -> Result<(), FlashFault> {
        if allowed {
            return Ok(());
        }
        assert!(self.counts_misuse, "{what}: 0x{at:x}");
        self.misused += 1;
        Err(FlashFault::Misuse)
    }
}

impl<const SECTOR: usize> ErrorType for Flash<SECTOR> {
    type Error = FlashFault;
}

impl<const SECTOR: usize> ReadNorFlash for Flash<SECTOR> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashFault> {
        let from = offset as usize;
        let inside = from + bytes.len() <= self.bytes.len();
        self.check(inside, "read beyond the flash", offset)?;
        bytes.copy_from_slice(&self.bytes[from..from + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const SECTOR: usize> NorFlash for Flash<SECTOR> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    /// Erases one sector.
    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashFault> {
        let sector = from as usize / SECTOR;
        let whole = from as usize == sector * SECTOR && to as usize == (sector + 1) * SECTOR;
        let allowed = whole && to as usize <= self.bytes.len();
        self.check(allowed, "erasure of what is no sector", from)?;
        let short = self.begin()?;
        self.erasures[sector] += 1;
        let random = &mut self.power.borrow_mut().random;
        // State after an interrupted erasure: some bits of each byte are set, few of them, or all.
        let depth = random.next_u32() % 3;
        for byte in &mut self.bytes[from as usize..to as usize] {
            *byte |= match (short, depth) {
                (false, _) | (true, 2) => 0xff,
                (true, 1) => random.next_u32() as u8,
                (true, _) => (random.next_u32() & random.next_u32()) as u8 & 0x11,
            };
        }
        if short {
            return Err(FlashFault::PowerLost);
        }
        Ok(())
    }

    /// Writes words, which must be erased.
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashFault> {
        let from = offset as usize;
        let aligned = from.is_multiple_of(WORD) && bytes.len().is_multiple_of(WORD);
        let allowed = aligned && from + bytes.len() <= self.bytes.len();
        self.check(allowed, "write of what are no words", offset)?;
        for (at, word) in (from..).step_by(WORD).zip(bytes.chunks(WORD)) {
            let short = self.begin()?;
            if self.deaf {
                continue;
            }
            let erased = self.bytes[at..at + WORD].iter().all(|&byte| byte == 0xff);
            self.check(erased, "written twice without an erasure", at as u32)?;
            self.words += 1;
            let random = &mut self.power.borrow_mut().random;
            for (place, &byte) in self.bytes[at..at + WORD].iter_mut().zip(word) {
                let kept = if short { random.next_u32() as u8 } else { 0 };
                *place &= byte | kept;
            }
            if short {
                return Err(FlashFault::PowerLost);
            }
        }
        Ok(())
    }
}
