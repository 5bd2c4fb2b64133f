//! The message between boot loader and image, where the chip has it.

use core::ptr;

use cortex_m::peripheral::SCB;
use stairscan::scanner::handover::{Handover, WORDS};

unsafe extern "C" {
    /// Top of SRAM, behind everything that the linker places (`memory.x`).
    static mut _handover: [u32; WORDS];
}

/// Takes the boot loader's message, which then is gone.
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
