//! A stack for images whose own buffers would not fit the firmware's.

/// The emulated board has 192 KB of SRAM; the chip's 128 KB end far below this.
const TOP: usize = 0x2003_0000;

/// Goes on in `run` with the memory above the chip's as stack.
pub fn enlarge(run: extern "C" fn() -> !) -> ! {
    // SAFETY: nothing on the old stack is used again; the new one is memory of nobody.
    unsafe {
        core::arch::asm!(
            "msr msp, {top}",
            "bx {run}",
            top = in(reg) TOP,
            run = in(reg) run,
            options(noreturn)
        )
    }
}
