//! Reading of addresses that may not exist.

use core::arch::naked_asm;

use cortex_m::peripheral::SCB;

/// Bit of register SCB_SHCSR that enables the bus fault handler; without it a bus fault becomes a hard fault.
const BUSFAULTENA: u32 = 1 << 17;
/// Flags of a bus fault in register SCB_CFSR (PM0214 4.4.9), which are cleared by writing ones: a later crash must not
/// find them.
const BUS_FAULT_FLAGS: u32 = 0xff << 8;

/// Returns the word at `address`, a multiple of four whose reading has no side effects; `None` if it does not respond.
/// Interrupts must be enabled: otherwise a bus fault becomes a hard fault.
pub fn read(address: u32) -> Option<u32> {
    // SAFETY: the system control block is always there, and no interrupt uses it.
    let scb = unsafe { &*SCB::PTR };
    // SAFETY: one bit of the processor's own register, set here and cleared below; meanwhile a bus fault enters
    // the handler below, which passes on those that are not from `load`.
    unsafe { scb.shcsr.modify(|bits| bits | BUSFAULTENA) };
    // SAFETY: reads the address, without side effects; if it does not respond, the handler continues.
    let answer = unsafe { load(address) };
    // SAFETY: as above.
    unsafe { scb.shcsr.modify(|bits| bits & !BUSFAULTENA) };
    if answer >> 32 == 0 {
        // SAFETY: clears flags that only a bus fault sets, and the last one has been handled.
        unsafe { scb.cfsr.write(BUS_FAULT_FLAGS) };
        return None;
    }
    Some(answer as u32)
}

/// Returns the word at `address`, and 1 in the upper half; 0 on a bus fault.
#[unsafe(naked)]
#[unsafe(export_name = "stairscan_probe")]
unsafe extern "C" fn load(address: u32) -> u64 {
    naked_asm!("ldr r0, [r0]", "movs r1, #1", "bx lr")
}

/// Handles a bus fault: one of `load` returns 0 and continues after its first two instructions, two bytes each; any
/// other becomes a hard fault.
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
        "adds r1, #4",
        "str r1, [r0, #24]",
        "movs r1, #0",
        "str r1, [r0]",
        "str r1, [r0, #4]",
        "bx lr",
        ".ltorg",
        load = sym load,
        hard_fault = sym super::fault::HardFault,
    )
}
