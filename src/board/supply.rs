//! Voltage detector of the supply: interrupts into the fault path when the voltage falls.

use stm32f4xx_hal::pac::{self, Interrupt};

use super::delay::delay_clocks;

/// Value of PLS in register PWR_CR (RM0090 5.4.1): the detector trips between 2.85 and 2.99 V on a falling and
/// releases at 3.10 V at most on a rising voltage (DS8626, embedded reset and power control block). The core at
/// 168 MHz and flash writes of 32 bits need 2.7 V; a 3.3 V supply within 5 % stays above 3.13 V.
const LEVEL: u8 = 0b110;
/// Bit of EXTI line 16, the interrupt of the voltage detector.
const LINE: u32 = 1 << 16;
/// Maximum number of polls of the detector at boot, 10 µs apart at 16 MHz: 0.1 s for a rising supply.
const POLLS: u32 = 10_000;
/// Core clocks between two polls of the detector: 10 µs at 16 MHz.
const POLL_CLOCKS: u32 = 160;

/// Starts the voltage detector, waits for the supply to rise, and returns whether it is high enough. The clock of
/// PWR must be on.
pub fn detect(pwr: &pac::PWR) -> bool {
    pwr.cr().modify(|_, w| w.pls().set(LEVEL).pvde().set_bit());
    (0..POLLS).any(|_| {
        delay_clocks(POLL_CLOCKS);
        pwr.csr().read().pvdo().bit_is_clear()
    })
}

/// As [`detect`]; from then on a fall of the voltage causes an interrupt.
pub fn start(pwr: &pac::PWR, exti: &pac::EXTI) -> bool {
    let high = detect(pwr);
    // SAFETY: sets one line's bit and leaves the others; the detector's output rises when the supply falls.
    exti.rtsr()
        .modify(|r, w| unsafe { w.bits(r.bits() | LINE) });
    // SAFETY: as above.
    exti.imr().modify(|r, w| unsafe { w.bits(r.bits() | LINE) });
    // SAFETY: its handler ends in the fault path and shares nothing (`fault`).
    unsafe { cortex_m::peripheral::NVIC::unmask(Interrupt::PVD) };
    high
}
