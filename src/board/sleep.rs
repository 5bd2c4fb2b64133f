//! Sleep of the core between two steps of the scanner.
//!
//! The core sleeps by WFE: each interrupt sets its event register, so that one that came before WFE ends the sleep at
//! once (ARMv7-M Architecture Reference Manual, B1.5.18). So none is missed, and nothing needs to be masked. TIM2 ends a
//! sleep in which no other interrupt comes.
//!
//! Without the crystal the core does not sleep: at 16 MHz a step takes as long as most rests. It waits awake for as long,
//! and leaves ports and timers alone meanwhile, but polls where the module's reply is awaited. So it is in the emulator,
//! which has no crystal: there each poll of a port costs more than the wait, and the module, a program outside, needs the
//! time that polls take. The model of the chip (`chip/`) tests the sleep.

use stairscan::scanner::rest::Rest;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc};

use super::clock::{self, Clocks, HSI, prescaler};
use super::delay::delay_clocks;

/// Timer that ends the core's sleep; `None` if the core does not sleep.
pub struct Sleep(Option<pac::TIM2>);

impl Sleep {
    /// Sets TIM2 up to count microseconds, once per sleep.
    pub fn new(timer: pac::TIM2, clocks: &Clocks, rcc: &mut Rcc) -> Self {
        if *clocks != clock::HSE {
            return Self(None);
        }
        pac::TIM2::enable(rcc);
        let division = prescaler(clocks.timer_hz, 1_000_000);
        timer.psc().write(|w| w.psc().set(division as u16));
        // The prescaler counts from the next update on, which here sets no flag.
        timer.cr1().write(|w| w.urs().counter_only());
        timer.egr().write(|w| w.ug().update());
        timer.dier().write(|w| w.uie().enabled());
        Self(Some(timer))
    }

    /// Sleeps until an interrupt comes, at most as long as `rest` allows; returns at once if one has come since the last
    /// sleep. Without the crystal it waits as long as `rest` allows.
    pub fn wait(&mut self, rest: Rest) {
        let Some(us) = rest.limit_us() else {
            return;
        };
        let Some(timer) = &self.0 else {
            if rest > Rest::Reply {
                delay_clocks(us * (HSI.core_hz / 1_000_000));
            }
            return;
        };
        timer.arr().write(|w| w.set(us));
        timer.cnt().write(|w| w.set(0));
        timer
            .cr1()
            .write(|w| w.urs().counter_only().opm().enabled().cen().enabled());
        cortex_m::asm::wfe();
        timer.cr1().write(|w| w.urs().counter_only());
    }
}

/// Handles TIM2's interrupt, whose only purpose is to end a sleep.
pub fn end() {
    // SAFETY: only this handler writes the register; zeros clear its flags, and its reset value is 0.
    unsafe { (*pac::TIM2::ptr()).sr().write(|w| w.bits(0)) };
}
