//! The two sectors of settings as NOR flash: erasing sets all bits of a sector, writing clears bits.
//!
//! It counts erasures of each sector, and refuses a write that would set a bit.

use embedded_storage::nor_flash::NorFlashErrorKind;

/// Size of a sector, bytes: sectors 1 and 2 of the STM32F405 (RM0090, table 5).
pub const SECTOR: usize = 16 * 1024;
/// Unit of writing, bytes.
pub const WORD: usize = 4;
/// Number of erasures that a sector endures (STM32F405 datasheet DS8626, flash memory endurance: at least 10 kcycles).
pub const ENDURANCE: u64 = 10_000;
/// Minimum and maximum duration of erasing a sector, µs (DS8626, table 42: 250 ms typical, 500 ms at most, 32 bits at a
/// time).
const ERASE_US: [u64; 2] = [250_000, 500_000];
/// Duration of writing a word, µs (DS8626, table 42: 16 typical).
const WORD_US: u64 = 16;

/// Content and wear of the two sectors.
#[derive(Clone, Debug)]
pub struct FlashModel {
    bytes: Vec<u8>,
    /// Number of erasures of each sector.
    pub erasures: [u64; 2],
    /// Whether a sector has been erased in the present pass of the scanner's loop; the erasure blocks that pass.
    pub erased: bool,
    /// Number of operations that were refused because of their alignment, or because a bit would have to be set.
    pub refused: u64,
}

impl FlashModel {
    /// Creates two erased sectors, as a programmer leaves them.
    pub fn new() -> Self {
        Self {
            bytes: vec![0xff; 2 * SECTOR],
            erasures: [0; 2],
            erased: false,
            refused: 0,
        }
    }

    /// Returns the size of both sectors, bytes.
    pub fn capacity(&self) -> usize {
        self.bytes.len()
    }

    /// Erases the content without counting it: a fault in a test.
    pub fn lose(&mut self) {
        self.bytes.fill(0xff);
    }

    fn range(&mut self, offset: u32, length: usize) -> Result<&mut [u8], NorFlashErrorKind> {
        let from = offset as usize;
        let place = self.bytes.get_mut(from..from + length);
        place.ok_or(NorFlashErrorKind::OutOfBounds)
    }

    /// Reads the bytes from `offset` on, which counts from the first sector's beginning.
    ///
    /// # Errors
    /// The place is beyond the sectors.
    pub fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        bytes.copy_from_slice(self.range(offset, bytes.len())?);
        Ok(())
    }

    /// Erases one whole sector, from byte `from` to byte `to`, and returns the time it takes, µs; `unit` is a random
    /// number from 0 to 1.
    ///
    /// # Errors
    /// The range is no sector.
    pub fn erase(&mut self, from: u32, to: u32, unit: f64) -> Result<u64, NorFlashErrorKind> {
        let sector = from as usize / SECTOR;
        if from as usize != sector * SECTOR || to as usize != (sector + 1) * SECTOR {
            self.refused += 1;
            return Err(NorFlashErrorKind::NotAligned);
        }
        self.range(from, SECTOR)?.fill(0xff);
        self.erasures[sector] += 1;
        self.erased = true;
        let [least, most] = ERASE_US;
        Ok(least + ((most - least) as f64 * unit) as u64)
    }

    /// Writes whole words from byte `offset` on, and returns the time it takes, µs.
    ///
    /// # Errors
    /// A bit would have to be set, or the place is beyond the sectors.
    pub fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<u64, NorFlashErrorKind> {
        let place = self.range(offset, bytes.len())?;
        let settable = |(old, new): (&u8, &u8)| old & new == *new;
        let aligned = (offset as usize).is_multiple_of(WORD) && bytes.len().is_multiple_of(WORD);
        if !aligned || !place.iter().zip(bytes).all(settable) {
            self.refused += 1;
            return Err(NorFlashErrorKind::Other);
        }
        place.copy_from_slice(bytes);
        Ok(WORD_US * (bytes.len() / WORD) as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bit_is_set_by_an_erasure_only() {
        let mut flash = FlashModel::new();
        flash.write(4, &[0xf0, 0, 0xff, 1]).unwrap();
        flash.write(4, &[0x10, 0, 0xff, 0]).unwrap();
        assert!(flash.write(4, &[0x11, 0, 0xff, 0]).is_err());
        assert!(flash.write(6, &[0; 4]).is_err());
        assert_eq!(flash.refused, 2);
        flash.erase(0, SECTOR as u32, 0.5).unwrap();
        flash.write(4, &[0x11, 0, 0xff, 0]).unwrap();
        assert!(flash.erase(4, SECTOR as u32 + 4, 0.5).is_err());
        assert_eq!(flash.erasures, [1, 0]);
    }
}
