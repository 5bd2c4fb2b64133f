//! The clocks of the image, for the loader.

pub use super::board::clock::apply::stop;
pub use super::board::clock::{Clocks, HSE, brr, start};

/// Fastest rate of the report port, in units of 100 kbaud: 42 MHz make 3 Mbaud exactly, 16 MHz 1 Mbaud.
pub fn fastest(clocks: &Clocks) -> u8 {
    if *clocks == HSE { 30 } else { 10 }
}
