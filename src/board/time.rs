//! Time in microseconds from a timer.

use stairscan::scanner::Micros;
use stm32f4xx_hal::pac;

use super::clock::{Clocks, prescaler};

/// Clock in microseconds, from TIM5.
pub struct Time(pac::TIM5);

impl Time {
    /// Returns the current time, µs since the timer was started; it wraps.
    pub fn now(&self) -> Micros {
        Micros(self.0.cnt().read().bits())
    }

    /// Returns the current time from TIM5, for code that does not own the clock.
    pub fn now_anywhere() -> Micros {
        // SAFETY: a device's register, always there; reading it changes nothing.
        let timer = unsafe { &*pac::TIM5::ptr() };
        Micros(timer.cnt().read().bits())
    }
}

/// Starts TIM5 as a free-running counter of microseconds.
pub fn start(timer: pac::TIM5, clocks: &Clocks) -> Time {
    let division = prescaler(clocks.timer_hz, 1_000_000);
    timer.psc().write(|w| w.psc().set(division as u16));
    // SAFETY: any value is valid; this is the whole range.
    timer.arr().write(|w| unsafe { w.bits(u32::MAX) });
    timer.egr().write(|w| w.ug().update());
    timer.cr1().write(|w| w.cen().enabled());
    Time(timer)
}
