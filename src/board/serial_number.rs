//! The chip's own number.

use core::arch::naked_asm;

use cortex_m::peripheral::SCB;

/// Where the 96 bits stand (RM0090 39.1).
const PLACE: u32 = 0x1fff_7a10;
/// SCB_SHCSR: a bus fault is handled as one and not as a hard fault.
const BUSFAULTENA: u32 = 1 << 17;

/// The number; zeros where nothing answers at its place. Only with interrupts on: where they are off, no
/// bus fault is handled as one.
pub fn read() -> [u32; 3] {
    // SAFETY: the system control block is always there, and no interrupt uses it.
    let shcsr = unsafe { &(*SCB::PTR).shcsr };
    // SAFETY: one bit of the processor's own register, set here and cleared below; meanwhile a bus
    // fault comes to the handler below, which passes on what is not from `load`.
    unsafe { shcsr.modify(|bits| bits | BUSFAULTENA) };
    // SAFETY: a read of the place, which has no effect; where there is none, the handler answers.
    let words = [0, 4, 8].map(|at| unsafe { load(PLACE + at) });
    // SAFETY: as above.
    unsafe { shcsr.modify(|bits| bits & !BUSFAULTENA) };
    words
}

/// The word at `place`, or 0 where the bus says that there is none.
#[unsafe(naked)]
#[unsafe(export_name = "stairscan_probe")]
unsafe extern "C" fn load(place: u32) -> u32 {
    naked_asm!("ldr r0, [r0]", "bx lr")
}

/// A bus fault: one of `load` is answered by 0 and goes on behind its instruction, which is two bytes
/// long; any other is a hard fault.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn BusFault() {
    naked_asm!(
        // The stacked program counter, less the address of the instruction.
        "mov r0, sp",
        "ldr r1, [r0, #24]",
        "ldr r2, ={load}",
        "bic r2, r2, #1",
        "cmp r1, r2",
        "bne {hard_fault}",
        "adds r1, #2",
        "str r1, [r0, #24]",
        "movs r1, #0",
        "str r1, [r0]",
        "bx lr",
        ".ltorg",
        load = sym load,
        hard_fault = sym super::fault::HardFault,
    )
}
