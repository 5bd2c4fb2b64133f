//! The chip's unique number.

use core::arch::naked_asm;

use cortex_m::peripheral::SCB;

/// Address of the chip's unique number of 96 bits (RM0090 39.1).
const PLACE: u32 = 0x1fff_7a10;
/// Bit of register SCB_SHCSR that enables the bus fault handler; without it a bus fault becomes a hard fault.
const BUSFAULTENA: u32 = 1 << 17;

/// Returns the chip's unique number as three words; zeros if its address does not respond. Interrupts must be
/// enabled: otherwise a bus fault becomes a hard fault.
pub fn read() -> [u32; 3] {
    // SAFETY: the system control block is always there, and no interrupt uses it.
    let shcsr = unsafe { &(*SCB::PTR).shcsr };
    // SAFETY: one bit of the processor's own register, set here and cleared below; meanwhile a bus fault enters
    // the handler below, which passes on those that are not from `load`.
    unsafe { shcsr.modify(|bits| bits | BUSFAULTENA) };
    // SAFETY: reads the address, without side effects; if it does not respond, the handler supplies 0.
    let words = [0, 4, 8].map(|at| unsafe { load(PLACE + at) });
    // SAFETY: as above.
    unsafe { shcsr.modify(|bits| bits & !BUSFAULTENA) };
    words
}

/// Returns the word at address `place`, or 0 on a bus fault.
#[unsafe(naked)]
#[unsafe(export_name = "stairscan_probe")]
unsafe extern "C" fn load(place: u32) -> u32 {
    naked_asm!("ldr r0, [r0]", "bx lr")
}

/// Handles a bus fault: one of `load` returns 0 and continues after its instruction, which is two bytes long;
/// any other becomes a hard fault.
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
