//! SPI port of a radar module: mode 0, with the module's select line low during each transaction.

use embedded_hal::spi::{ErrorType, Operation, SpiBus, SpiDevice};
use stm32f4xx_hal::gpio::{Output, PA4, PA5, PA6, PA7, Speed};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::spi::{self, Mode, Phase, Polarity, Spi};

use super::delay::delay_clocks;

/// SPI clock to request from the HAL so that it divides APB2 by four, Hz: the HAL assumes the clocks as after
/// reset. With the crystal that gives 21 MHz, below the 25 MHz up to which the BGT60TR13C sends with the right
/// edge for mode 0 (data sheet, V2.4.9, table 27).
const HAL_HZ: u32 = super::clock::HSI.apb2_hz / 4;
/// Core clocks for each 10 ns of a wait within a transaction: enough at 168 MHz, longer than needed at 16 MHz.
const CLOCKS_PER_10_NS: u32 = 2;

/// Pins of the port.
pub struct SpiPins {
    /// Select line of the module, active low.
    pub select: PA4<Output>,
    /// Clock.
    pub clock: PA5,
    /// Data from the module.
    pub from: PA6,
    /// Data to the module.
    pub to: PA7,
}

/// Port SPI1 with the radar module's select line.
pub struct ModuleSpi {
    bus: Spi<pac::SPI1>,
    select: PA4<Output>,
}

impl ModuleSpi {
    /// Creates the port with the module deselected.
    pub fn new(
        port: pac::SPI1,
        SpiPins {
            mut select,
            clock,
            from,
            to,
        }: SpiPins,
        rcc: &mut Rcc,
    ) -> Self {
        select.set_high();
        let pins = (
            Some(clock.into_alternate::<5>().speed(Speed::High)),
            Some(from.into_alternate::<5>().internal_pull_up(true)),
            Some(to.into_alternate::<5>().speed(Speed::High)),
        );
        let mode = Mode {
            polarity: Polarity::IdleLow,
            phase: Phase::CaptureOnFirstTransition,
        };
        Self {
            bus: Spi::new(port, pins, mode, HAL_HZ.Hz(), rcc),
            select,
        }
    }

    /// Performs one operation of a transaction. The port makes the SPI clock itself, so every word ends.
    fn operate(&mut self, operation: &mut Operation<'_, u8>) -> Result<(), spi::Error> {
        match operation {
            Operation::Read(words) => SpiBus::read(&mut self.bus, words),
            Operation::Write(words) => SpiBus::write(&mut self.bus, words),
            Operation::Transfer(read, write) => SpiBus::transfer(&mut self.bus, read, write),
            Operation::TransferInPlace(words) => SpiBus::transfer_in_place(&mut self.bus, words),
            Operation::DelayNs(ns) => {
                delay_clocks((*ns / 10 + 1).saturating_mul(CLOCKS_PER_10_NS));
                Ok(())
            }
        }
    }
}

impl ErrorType for ModuleSpi {
    type Error = spi::Error;
}

impl SpiDevice<u8> for ModuleSpi {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), spi::Error> {
        self.select.set_low();
        let done = operations.iter_mut().try_for_each(|o| self.operate(o));
        let flushed = SpiBus::flush(&mut self.bus);
        self.select.set_high();
        done.and(flushed)
    }
}
