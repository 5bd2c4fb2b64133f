//! Pins of the encoder on the mirror's shaft.

use embedded_hal::delay::DelayNs;
use stairscan::scanner::encoder::bus::PinBus;
use stm32f4xx_hal::gpio::{OpenDrain, Output, PB8, PB9, PinState};

use super::delay::delay_clocks;

/// Nanoseconds in a microsecond.
const MICROSECOND: u32 = 1_000;

/// I²C bus of the encoder: SCL on pin PB8, SDA on PB9.
pub type EncoderBus = PinBus<PB8<Output<OpenDrain>>, PB9<Output<OpenDrain>>, CycleDelay>;

/// Delay by counting the core's clocks: at least as long as requested, longer if an interrupt comes.
#[derive(Debug)]
pub struct CycleDelay {
    per_us: u32,
}

impl DelayNs for CycleDelay {
    fn delay_ns(&mut self, ns: u32) {
        let whole = (ns / MICROSECOND).saturating_mul(self.per_us);
        let rest = (ns % MICROSECOND * self.per_us).div_ceil(MICROSECOND);
        delay_clocks(whole.saturating_add(rest));
    }
}

/// Creates the encoder's bus with both lines released; the board's resistors pull them up (`docs/user/hardware.md`).
pub fn bus(clock: PB8, data: PB9, core_hz: u32) -> EncoderBus {
    let clock = clock.into_open_drain_output_in_state(PinState::High);
    let data = data.into_open_drain_output_in_state(PinState::High);
    let per_us = core_hz / 1_000_000;
    PinBus::new(clock, data, CycleDelay { per_us })
}
