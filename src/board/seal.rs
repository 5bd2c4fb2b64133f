//! Access to the image's seal in the chip's flash.

use core::ptr;

use stairscan::scanner::seal::{BLANK, ImageState, SLOT, WORDS, judge};

// SAFETY: the section is the seal's alone, within flash and behind the vector table (`memory.x`).
#[used]
#[unsafe(link_section = ".seal")]
static SEAL: [u32; WORDS] = BLANK;

// SAFETY: the section is the header's alone, at the beginning of the slot (`memory.x`).
#[used]
#[unsafe(link_section = ".header")]
static HEADER: [u32; 128] = [u32::MAX; 128];

/// Compares the image that runs with its seal; returns the image's state.
pub fn verdict() -> ImageState {
    // The address is linked in, and so tells the slot.
    let moved = (&raw const HEADER as u32).wrapping_sub(SLOT);
    // SAFETY: a static; volatile, since what stands there is put in after the compiler has seen it.
    let seal = unsafe { ptr::read_volatile(&raw const SEAL) };
    judge(seal, |from, to| {
        let length = to.saturating_sub(from) as usize;
        // SAFETY: within the flash, by `judge`, which is always mapped and holds no variables; nobody
        // writes there.
        unsafe { core::slice::from_raw_parts(from.wrapping_add(moved) as *const u8, length) }
    })
}
