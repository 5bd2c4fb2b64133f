//! Delays counted in clocks of the core.
//!
//! `cortex_m::asm::delay(n)` of cortex-m 0.7.10 runs n + 1 passes of `subs` and `bne`; its documentation promises n
//! clocks at least, and on a Cortex-M4 it takes three times as many.

/// Core clocks of one pass of `cortex_m::asm::delay` on a Cortex-M4: one for `subs`, two for the taken `bne`
/// (Cortex-M4 Technical Reference Manual, 3.3: a taken branch refills the pipeline, here from an aligned target).
const CLOCKS_PER_PASS: u32 = 3;

/// Returns the argument of `cortex_m::asm::delay` for `clocks` core clocks. The last pass does not branch and takes
/// two clocks, so that the passes together take `clocks` to `clocks + 2`.
const fn argument(clocks: u32) -> u32 {
    clocks / CLOCKS_PER_PASS
}

/// Waits `clocks` core clocks, and a few more for call and rounding; longer if an interrupt comes or the flash's
/// prefetch misses.
#[cfg(target_os = "none")]
#[inline]
pub fn delay_clocks(clocks: u32) {
    cortex_m::asm::delay(argument(clocks));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the clocks of `cortex_m::asm::delay` by its instructions: n + 1 passes, the last without a branch.
    fn taken(argument: u32) -> u32 {
        let passes = argument + 1;
        3 * (passes - 1) + 2
    }

    #[test]
    fn the_delay_is_as_long_as_requested_and_two_clocks_more_at_most() {
        for clocks in [2, 3, 4, 5, 160, 168, 169, 1_680_000] {
            let taken = taken(argument(clocks));
            assert!((clocks..=clocks + 2).contains(&taken), "{clocks}: {taken}");
        }
        assert_eq!(taken(argument(0)), 2);
    }
}
