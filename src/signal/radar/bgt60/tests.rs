//! The driver with a bus that gives arbitrary answers. For tests with a model of the chip see
//! `host-sim/tests/suite/bgt60.rs`.

use core::convert::Infallible;

use embedded_hal::spi::{ErrorType, Operation};
use proptest::prelude::*;

use super::*;

/// SPI bus that answers every transfer with `bytes`, repeated.
struct Babble {
    bytes: Vec<u8>,
    at: usize,
    /// Maximum length of a transfer so far, bytes.
    longest: usize,
}

impl Babble {
    fn new(bytes: Vec<u8>) -> Self {
        Self {
            bytes,
            at: 0,
            longest: 0,
        }
    }
}

impl ErrorType for Babble {
    type Error = Infallible;
}

impl SpiDevice for Babble {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        for operation in operations {
            let buffer: &mut [u8] = match operation {
                Operation::TransferInPlace(buffer) | Operation::Transfer(buffer, _) => buffer,
                Operation::Read(buffer) => buffer,
                _ => continue,
            };
            self.longest = self.longest.max(buffer.len());
            for byte in buffer {
                *byte = *self
                    .bytes
                    .get(self.at % self.bytes.len().max(1))
                    .unwrap_or(&0);
                self.at += 1;
            }
        }
        Ok(())
    }
}

#[test]
fn samples_lie_left_and_the_ends_are_full_scale() {
    let codes = [0, 1, 2, 2047, 2048, 2049, 4094, 4095].map(sample_of);
    let book = [i16::MIN, i16::MIN, -32_736, -16, 0, 16, 32_736, i16::MAX];
    assert_eq!(codes, book);
}

#[test]
fn a_dead_bus_has_nobody_at_its_end() {
    for byte in [0x00, 0xff] {
        let (mut chip, mut spi) = (Bgt60::new(), Babble::new(vec![byte]));
        chip.program(&mut spi, Micros(0), &RequestedSettings::DEFAULT, 100_000);
        let answer = chip.settings(&mut spi, Micros(1));
        assert_eq!(answer, Poll::Ready(Err(LinkError::Module(WRONG_CHIP))));
    }
}

proptest! {
    #[test]
    fn no_answer_of_the_bus_stops_it(
        bytes in proptest::collection::vec(any::<u8>(), 1..400),
        (bandwidth_khz, samples) in (any::<u32>(), any::<u16>()),
        (holds, step) in (0..600usize, 0u32..5_000),
    ) {
        let requested = RequestedSettings { bandwidth_khz, samples, ..RequestedSettings::DEFAULT };
        let (mut chip, mut spi) = (Bgt60::new(), Babble::new(bytes));
        let mut iq = vec![Iq::default(); holds];
        let mut now = Micros(u32::MAX - 10_000);
        chip.program(&mut spi, now, &requested, 100_000);
        for _ in 0..100 {
            now = now.plus(step);
            let _ = chip.settings(&mut spi, now);
        }
        for _ in 0..3 {
            chip.trigger(&mut spi, now, 0, 20_000);
            for _ in 0..100 {
                now = now.plus(step);
                let _ = chip.poll(&mut spi, now, &mut iq);
            }
        }
        prop_assert!(spi.longest <= COMMAND + WORD * BURST_WORDS);
    }
}

#[test]
fn a_burst_returns_its_last_word_and_each_pair_of_samples() {
    let mut bus = Babble::new(vec![0, 0, 0, 0, 0x12, 0x34, 0x56, 0x80, 0x08, 0x01]);
    let mut piece = [Iq::new(0, 0); 2];
    assert_eq!(burst(&mut bus, &mut piece), Ok(0x80_0801));
    let pair = |first, second| Iq::new(sample_of(first), sample_of(second));
    assert_eq!(piece, [pair(0x123, 0x456), pair(0x800, 0x801)]);
}
