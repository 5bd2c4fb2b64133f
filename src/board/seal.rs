//! The image's seal, where the chip has it.

use core::ptr;

use stairscan::scanner::seal::{BLANK, ImageState, WORDS, judge};

// SAFETY: the section is the seal's alone, within flash and behind the vector table (`memory.x`).
#[used]
#[unsafe(link_section = ".seal")]
static SEAL: [u32; WORDS] = BLANK;

/// What the seal says of this image.
pub fn verdict() -> ImageState {
    // SAFETY: a static; volatile, since what stands there is put in after the compiler has seen it.
    let seal = unsafe { ptr::read_volatile(&raw const SEAL) };
    judge(seal, |from, to| {
        let length = to.saturating_sub(from) as usize;
        // SAFETY: within the flash, by `judge`, which is always mapped and holds no variables; nobody
        // writes there.
        unsafe { core::slice::from_raw_parts(from as *const u8, length) }
    })
}
