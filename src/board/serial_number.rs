//! The chip's unique number.

use super::probe;

/// Address of the chip's unique number of 96 bits (RM0090 39.1).
const PLACE: u32 = 0x1fff_7a10;

/// Returns the chip's unique number as three words; zeros if its address does not respond. Interrupts must be
/// enabled ([`probe::read`]).
pub fn read() -> [u32; 3] {
    [0, 4, 8].map(|at| probe::read(PLACE + at).unwrap_or(0))
}
