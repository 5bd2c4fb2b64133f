//! The anti-rollback counter: the largest number of an image that was ever confirmed.
//!
//! A log of records of eight bytes, a number and its complement; the largest whole record counts. A full sector is erased and
//! begun anew. A power cut there loses nothing: the image in force bears that very number, and every boot of it enters the
//! number again where it is missing.

use embedded_storage::nor_flash::NorFlash;

/// Bytes of a record.
const RECORD: u32 = 8;

/// The counter in a flash of one sector.
#[derive(Debug)]
pub struct Floor<F> {
    flash: F,
}

impl<F: NorFlash> Floor<F> {
    /// The counter in `flash`.
    pub fn new(flash: F) -> Self {
        const {
            assert!((RECORD as usize).is_multiple_of(F::WRITE_SIZE) && F::READ_SIZE == 1);
        }
        Self { flash }
    }

    /// The flash.
    pub fn flash_mut(&mut self) -> &mut F {
        &mut self.flash
    }

    fn record(&mut self, k: u32) -> [u8; RECORD as usize] {
        let mut bytes = [0; RECORD as usize];
        match self.flash.read(k * RECORD, &mut bytes) {
            Ok(()) => bytes,
            Err(_) => [0; RECORD as usize],
        }
    }

    /// The counter, 0 in an empty log.
    pub fn get(&mut self) -> u32 {
        let whole = |bytes: [u8; RECORD as usize]| {
            let word = u64::from_le_bytes(bytes);
            let (number, complement) = (word as u32, (word >> 32) as u32);
            (number == !complement).then_some(number)
        };
        let records = F::ERASE_SIZE as u32 / RECORD;
        (0..records)
            .filter_map(|k| whole(self.record(k)))
            .max()
            .unwrap_or(0)
    }

    /// Raises the counter to `number` where it is below. A flash that fails leaves it: the next boot tries again.
    pub fn raise(&mut self, number: u32) {
        if number <= self.get() {
            return;
        }
        let records = F::ERASE_SIZE as u32 / RECORD;
        let blank = [0xff; RECORD as usize];
        let used = (0..records).rev().find(|&k| self.record(k) != blank);
        let mut next = used.map_or(0, |k| k + 1);
        // A sector that looks blank may be one whose erasure was cut short.
        if next == 0 || next == records {
            if self.flash.erase(0, F::ERASE_SIZE as u32).is_err() {
                return;
            }
            next = 0;
        }
        let record = u64::from(number) | u64::from(!number) << 32;
        let _ = self.flash.write(next * RECORD, &record.to_le_bytes());
    }
}
