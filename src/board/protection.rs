//! Memory protection unit: no code in RAM, and a guard region at the end of the stack.
//!
//! Three regions over the processor's default map; where two overlap, the one with the higher number applies.
//! Nothing in RAM's half gigabyte is executed. The lowest 32 bytes of the stack are inaccessible, so that a
//! growing stack faults before it leaves the memory. The core-coupled memory is inaccessible, too, until its test has
//! passed ([`super::second_memory`]). A violation enters the fault path as `memory-fault`.

/// A region of the memory protection unit: start, size and access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// First address of the region, a multiple of its size.
    pub base: u32,
    /// Binary logarithm of the size in bytes: 5 at least.
    pub log2_size: u32,
    /// Whether the region may be read and written; code is executed from no region.
    pub open: bool,
}

/// All regions; the index is the region's number.
pub const REGIONS: [Region; 3] = [
    // SRAM and all its aliases.
    Region {
        base: 0x2000_0000,
        log2_size: 29,
        open: true,
    },
    // Guard below the stack: `memory.x` keeps `_stack_end` above it.
    Region {
        base: 0x2000_0000,
        log2_size: 5,
        open: false,
    },
    // Core-coupled memory: closed until it has been tested.
    Region {
        base: 0x1000_0000,
        log2_size: 16,
        open: false,
    },
];

/// Value of register MPU_CTRL (PM0214 4.5.5): enabled; default map outside the regions; disabled within hard
/// faults.
#[cfg_attr(not(target_os = "none"), allow(dead_code))]
pub const CONTROL: u32 = 1 << 2 | 1;

impl Region {
    /// Returns the value of register MPU_RBAR (PM0214 4.2.8): the address, and the region's number with its valid
    /// flag.
    pub const fn rbar(self, number: u32) -> u32 {
        self.base | 1 << 4 | number
    }

    /// Returns the value of register MPU_RASR (PM0214 4.2.9): no execution, full or no access, shared and cached
    /// as for internal RAM.
    pub const fn rasr(self) -> u32 {
        const EXECUTE_NEVER: u32 = 1 << 28;
        const ALL: u32 = 0b011 << 24;
        const SHARED: u32 = 1 << 18;
        const CACHED: u32 = 1 << 17;
        let access = if self.open { ALL } else { 0 };
        EXECUTE_NEVER | access | SHARED | CACHED | (self.log2_size - 1) << 1 | 1
    }
}

/// Returns the number of the region that begins at `address`, and the region with another access; `None` if none of
/// them is to be opened and closed at run time.
pub fn changed(address: u32, open: bool) -> Option<(u32, Region)> {
    let regions = (0..).zip(REGIONS).skip(2);
    let mut found = regions.filter(|(_, region)| region.base == address);
    let (number, region) = found.next()?;
    Some((number, Region { open, ..region }))
}

#[cfg(target_os = "none")]
mod apply {
    use super::{CONTROL, REGIONS, changed};
    use cortex_m::peripheral::MPU;

    /// Sets up the regions and enables the memory protection unit.
    pub fn start(mpu: &MPU) {
        for (number, region) in (0..).zip(REGIONS) {
            // SAFETY: registers of the processor, with values checked by this module's tests; no running code
            // is in these regions, and all data in them is in the open one.
            unsafe {
                mpu.rbar.write(region.rbar(number));
                mpu.rasr.write(region.rasr());
            }
        }
        // SAFETY: as above.
        unsafe { mpu.ctrl.write(CONTROL) };
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
    }

    /// Opens or closes the memory that begins at `address` for data, if a region of its own closes it.
    pub fn open(mpu: &MPU, address: u32, open: bool) {
        let Some((number, region)) = changed(address, open) else {
            return;
        };
        // SAFETY: registers of the processor, with values checked by this module's tests; no running code and no
        // data is in this region.
        unsafe {
            mpu.rbar.write(region.rbar(number));
            mpu.rasr.write(region.rasr());
        }
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
    }
}

#[cfg(target_os = "none")]
pub use apply::{open, start};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn registers_hold_what_the_programming_manual_says() {
        let field = |value: u32, low: u32, bits: u32| (value >> low) & ((1 << bits) - 1);
        for (number, region) in (0..).zip(REGIONS) {
            assert!(region.log2_size >= 5);
            assert_eq!(region.base & ((1 << region.log2_size) - 1), 0, "aligned");
            let (rbar, rasr) = (region.rbar(number), region.rasr());
            assert_eq!(rbar & !0x1f, region.base);
            assert_eq!(
                (field(rbar, 4, 1), field(rbar, 0, 4)),
                (1, number),
                "VALID, REGION"
            );
            assert_eq!(field(rasr, 28, 1), 1, "XN");
            assert_eq!(
                field(rasr, 24, 3),
                if region.open { 0b011 } else { 0 },
                "AP"
            );
            assert_eq!(
                1_u64 << (field(rasr, 1, 5) + 1),
                1 << region.log2_size,
                "SIZE"
            );
            assert_eq!(field(rasr, 8, 8), 0, "no subregion is left out");
            assert_eq!(field(rasr, 0, 1), 1, "ENABLE");
        }
        assert_eq!(CONTROL, 0b101, "PRIVDEFENA, not HFNMIENA, ENABLE");
    }

    #[test]
    fn only_the_core_coupled_memory_is_opened_at_run_time() {
        let [sram, _, ccm] = REGIONS;
        assert_eq!(
            changed(ccm.base, true),
            Some((2, Region { open: true, ..ccm }))
        );
        assert_eq!(changed(ccm.base, false), Some((2, ccm)));
        for address in [sram.base, 0x2002_0000] {
            assert_eq!(changed(address, false), None);
        }
    }

    #[test]
    fn memory_x_leaves_the_guard_out_of_the_stack() {
        let memory = include_str!("memory.x");
        assert!(memory.contains("_stack_bottom = ORIGIN(STACK);"));
        assert!(memory.contains("_stack_end = ORIGIN(STACK) + 32;"));
        assert!(memory.contains("STACK : ORIGIN = 0x20000000"));
        let [_, guard, _] = REGIONS;
        assert_eq!((guard.base, 1 << guard.log2_size), (0x2000_0000, 32));
    }
}
