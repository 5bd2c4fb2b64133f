//! A larger stack, for images whose buffers do not fit beside the firmware's.

/// Top of the enlarged stack: the emulated board has 192 KB of SRAM; the chip's 128 KB end far below.
const TOP: usize = 0x2003_0000;

/// Continues in `run`, with the memory above the chip's as the stack.
pub fn enlarge(run: extern "C" fn() -> !) -> ! {
    // SAFETY: nothing on the old stack is used again; the memory of the new one is unused.
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
