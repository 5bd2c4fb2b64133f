//! Access to the message between boot loader and image at the top of the chip's SRAM.

use core::ptr;

use cortex_m::peripheral::SCB;
use stairscan::scanner::handover::{Handover, WORDS};
use stairscan::scanner::resets::{self, Resets};

unsafe extern "C" {
    /// Words of the message at the top of SRAM, behind everything that the linker places (`memory.x`).
    static mut _handover: [u32; WORDS];
    /// Words of the boot loader's count of resets, behind the message.
    static mut _resets: [u32; resets::WORDS];
}

/// Returns the message that the boot loader has left, and deletes it; `None` if there is none.
pub fn take() -> Option<Handover> {
    let place = &raw mut _handover;
    // SAFETY: words of SRAM that nothing else uses; any bits are words.
    let words = unsafe { ptr::read_volatile(place) };
    // SAFETY: as above.
    unsafe { ptr::write_volatile(place, [0; WORDS]) };
    Handover::from_words(words)
}

/// Leaves a message for the boot loader and resets the chip.
pub fn reset_with(message: Handover) -> ! {
    // SAFETY: as in `take`.
    unsafe { ptr::write_volatile(&raw mut _handover, message.words()) };
    SCB::sys_reset()
}

/// Sets the boot loader's count of resets to 0: the image has run long enough since the last one.
pub fn clear_resets() {
    // SAFETY: as in `take`.
    unsafe { ptr::write_volatile(&raw mut _resets, Resets(0).words()) };
}
