//! The pin that forces the loader: LOADER, PB12, held at 3.3 V. Its pull-down makes an open one low.

use stm32f4xx_hal::pac;

/// Number of the pin.
const PB12: u8 = 12;
/// Pull-down in GPIOB_PUPDR (RM0090 8.4.4). After a reset the pin is an input (8.4.1).
const PULL: u32 = 0b10 << (2 * PB12);
/// The pull bits of the pin.
const PULL_MASK: u32 = 0b11 << (2 * PB12);

/// Switches the pin's port and its pull-down on.
pub fn start(chip: &pac::Peripherals) {
    chip.RCC.ahb1enr().modify(|_, w| w.gpioben().set_bit());
    // The clock comes two cycles later (ES0182, delay after an RCC peripheral clock enabling).
    cortex_m::asm::dsb();
    // SAFETY: fields of a pin that only this module uses; the others stay.
    (chip.GPIOB.pupdr()).modify(|r, w| unsafe { w.bits(r.bits() & !PULL_MASK | PULL) });
}

/// Whether the pin is held. It has had time to settle since `start`: a microsecond.
pub fn is_held(chip: &pac::Peripherals) -> bool {
    chip.GPIOB.idr().read().bits() & (1 << PB12) != 0
}

/// Leaves the pin's port as a reset does.
pub fn stop(chip: &pac::Peripherals) {
    chip.RCC.ahb1rstr().modify(|_, w| w.gpiobrst().set_bit());
    chip.RCC.ahb1rstr().modify(|_, w| w.gpiobrst().clear_bit());
    chip.RCC.ahb1enr().modify(|_, w| w.gpioben().clear_bit());
}
