//! Fault status of the processor, register SCB_CFSR (PM0214 4.4.13): what a fault has left behind that can be read.
#![cfg_attr(not(target_os = "none"), allow(dead_code))]

/// Violations of memory protection, the lowest byte.
const MEMORY: u32 = 0xff;
/// MMARVALID: MMFAR holds the address of a violation of memory protection.
const MEMORY_ADDRESS: u32 = 1 << 7;
/// BFARVALID: BFAR holds the address of a bus fault.
const BUS_ADDRESS: u32 = 1 << 15;
/// MSTKERR and STKERR: the exception frame could not be written.
const NO_FRAME: u32 = 1 << 4 | 1 << 12;
/// Bytes of an exception frame without floating-point registers: r0 to r3, r12, LR, PC, xPSR.
pub const FRAME: u32 = 32;
/// Offset of LR in the frame; PC follows it.
pub const FRAME_LR: u32 = 20;

/// Whether `cfsr` reports a violation of memory protection.
pub fn is_memory(cfsr: u32) -> bool {
    cfsr & MEMORY != 0
}

/// Whether the exception frame of the fault was written as a whole.
pub fn has_frame(cfsr: u32) -> bool {
    cfsr & NO_FRAME == 0
}

/// Returns which of the registers MMFAR and BFAR holds the address whose access failed; `None` if neither does.
pub fn address(cfsr: u32, mmfar: u32, bfar: u32) -> Option<u32> {
    if cfsr & MEMORY_ADDRESS != 0 {
        Some(mmfar)
    } else if cfsr & BUS_ADDRESS != 0 {
        Some(bfar)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_counts_unless_writing_it_failed() {
        assert!(has_frame(0) && has_frame(0x82) && has_frame(0x8200));
        for failed in [1 << 4, 1 << 12] {
            assert!(!has_frame(failed | 0x82), "{failed:x}");
        }
    }

    #[test]
    fn an_address_counts_only_where_its_register_is_valid() {
        assert_eq!(address(0x82, 1, 2), Some(1));
        assert_eq!(address(0x8200, 1, 2), Some(2));
        // IACCVIOL, IMPRECISERR and UNDEFINSTR have none.
        for cfsr in [0, 1, 0x400, 0x1_0000] {
            assert_eq!(address(cfsr, 1, 2), None, "{cfsr:x}");
        }
        assert!(is_memory(1) && !is_memory(0x8200));
    }
}
