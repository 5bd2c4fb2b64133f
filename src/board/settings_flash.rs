//! The two sectors of the chip's flash that hold settings.
//!
//! Sectors 1 and 2, of 16 KB, among those of the boot loader (`boot/src/layout.rs`): the chip does
//! nothing else while it erases one, since its code lies in the same bank, and the 0.5 s that a small
//! sector takes at most are within the watchdog's timeout, where the 2 s of a large one are not.

use super::controller::{Chip, Wait};
use super::flash::Sectors;
use super::time::Time;

/// Size of a flash sector, bytes.
const SECTOR: usize = 16 * 1024;
/// Number of the first of the two sectors.
const FIRST: u32 = 1;
/// Address of the first of the two sectors.
const BASE: u32 = 0x0800_4000;

/// Wait by the clock in microseconds, which must have been started.
#[derive(Debug)]
pub struct ByClock;

impl Wait for ByClock {
    fn wait(at_most_us: u32, mut ended: impl FnMut() -> bool) -> bool {
        let begun = Time::now_anywhere();
        loop {
            // In this order: the chip may stand still between the two.
            let late = Time::now_anywhere().since(begun) > at_most_us;
            if ended() {
                return true;
            }
            if late {
                return false;
            }
        }
    }
}

/// The sectors of the settings.
pub type SettingsFlash = Sectors<Chip<ByClock>, SECTOR, 2>;

/// Returns access to the sectors of the settings.
pub fn open() -> SettingsFlash {
    Sectors::new(Chip(ByClock), BASE, FIRST)
}
