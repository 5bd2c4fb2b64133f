//! 168 MHz from the crystal, as the image has it, and back to what holds after a reset before the image begins.

pub use super::board::clock::{Clocks, HSE, brr, start};
use stm32f4xx_hal::pac;

/// Polls for the switch back: some clocks of the core.
const POLLS: u32 = 100_000;

/// Fastest rate of the report port, in units of 100 kbaud: 42 MHz make 3 Mbaud exactly, 16 MHz 1 Mbaud.
pub fn fastest(clocks: &Clocks) -> u8 {
    if *clocks == HSE { 30 } else { 10 }
}

/// Leaves the clocks as a reset does, so that the image begins as it does without a loader.
pub fn stop(rcc: &pac::RCC, flash: &pac::FLASH) {
    // SAFETY: 0 is the reset value (RM0090 7.3.3): the internal oscillator, nothing divided.
    rcc.cfgr().write(|w| unsafe { w.bits(0) });
    let _ = (0..POLLS).any(|_| rcc.cfgr().read().sws().is_hsi());
    rcc.cr().modify(|_, w| {
        w.csson()
            .clear_bit()
            .pllon()
            .clear_bit()
            .hseon()
            .clear_bit()
    });
    // SAFETY: 0 is the reset value (RM0090 3.9.2): no wait states, which 16 MHz do not need.
    flash.acr().write(|w| unsafe { w.bits(0) });
}
