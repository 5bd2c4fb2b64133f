//! The report port, polled.

use stairscan_boot::receive::FIRST_BAUD;
use stm32f4xx_hal::pac;

use super::clock::brr;

/// Polls of the transmitter until it is given up: at 115,200 baud a byte takes 15,000 clocks of the core.
const POLLS: u32 = 1_000_000;
/// USART_CR1 (RM0090 30.6.4): UE, TE, RE; and OVER8.
const ENABLE: u16 = 1 << 13 | 1 << 3 | 1 << 2;
const OVER8: u16 = 1 << 15;
/// PA2 and PA3 in alternate function 7 (DS8626, table 9), PA3 with a pull-up.
const PIN_A2_A3: u32 = 0b1010 << 4;
const PULL_A3: u32 = 0b01 << 6;
const AF7_A2_A3: u32 = 0x77 << 8;
/// The mode bits of both pins.
const MODE_MASK: u32 = 0b1111 << 4;
/// The alternate function bits of both pins.
const AF_MASK: u32 = 0xff << 8;

/// USART2 on PA2 and PA3.
#[derive(Debug)]
pub struct Port {
    bus_hz: u32,
    rate: u32,
}

fn usart() -> &'static pac::usart1::RegisterBlock {
    // SAFETY: a device's registers, always there; only this port uses them, and nothing interrupts it.
    unsafe { &*pac::USART2::ptr().cast() }
}

impl Port {
    /// Starts the port at the first rate.
    pub fn start(chip: &pac::Peripherals, bus_hz: u32) -> Self {
        chip.RCC.ahb1enr().modify(|_, w| w.gpioaen().set_bit());
        chip.RCC.apb1enr().modify(|_, w| w.usart2en().set_bit());
        let pins = &chip.GPIOA;
        // SAFETY: fields of two pins that this port owns; the others stay.
        pins.afrl()
            .modify(|r, w| unsafe { w.bits(r.bits() & !AF_MASK | AF7_A2_A3) });
        // SAFETY: as above.
        pins.pupdr()
            .modify(|r, w| unsafe { w.bits(r.bits() | PULL_A3) });
        // SAFETY: as above.
        pins.moder()
            .modify(|r, w| unsafe { w.bits(r.bits() & !MODE_MASK | PIN_A2_A3) });
        let port = Self {
            bus_hz,
            rate: FIRST_BAUD,
        };
        port.apply(FIRST_BAUD);
        port
    }

    /// Leaves port and pins as a reset does.
    pub fn stop(&self, chip: &pac::Peripherals) {
        self.flush();
        chip.RCC.apb1rstr().modify(|_, w| w.usart2rst().set_bit());
        chip.RCC.apb1rstr().modify(|_, w| w.usart2rst().clear_bit());
        chip.RCC.ahb1rstr().modify(|_, w| w.gpioarst().set_bit());
        chip.RCC.ahb1rstr().modify(|_, w| w.gpioarst().clear_bit());
        chip.RCC.apb1enr().modify(|_, w| w.usart2en().clear_bit());
        chip.RCC.ahb1enr().modify(|_, w| w.gpioaen().clear_bit());
    }

    /// The present rate, baud.
    pub fn rate(&self) -> u32 {
        self.rate
    }

    /// Goes on at another rate once all has been sent.
    pub fn set_rate(&mut self, baud: u32) {
        self.flush();
        self.rate = baud;
        self.apply(baud);
    }

    /// Divider and oversampling (RM0090 30.3.4): 16-fold where the bus allows, else 8-fold, whose fraction has three bits.
    fn apply(&self, baud: u32) {
        let ticks = brr(self.bus_hz, baud.max(1));
        let (over8, divider) = if ticks >= 16 {
            (0, ticks)
        } else {
            (OVER8, (ticks & !7) << 1 | ticks & 7)
        };
        // SAFETY: a divider of 8 ticks and more, which the port can work with.
        usart().brr().write(|w| unsafe { w.bits(divider as u16) });
        // SAFETY: bits of the reference manual; no interrupt is enabled.
        usart().cr1().write(|w| unsafe { w.bits(ENABLE | over8) });
    }

    /// A byte that has come.
    pub fn read(&self) -> Option<u8> {
        // Reading status and data clears errors, too: what was damaged fails the frame's checksum.
        let status = usart().sr().read();
        let came = status.rxne().bit_is_set() || status.ore().bit_is_set();
        came.then(|| usart().dr().read().bits() as u8)
    }

    /// Sends bytes, and waits for that.
    pub fn write(&self, bytes: &[u8]) {
        for &byte in bytes {
            let _ = (0..POLLS).any(|_| usart().sr().read().txe().bit_is_set());
            // SAFETY: any byte is one.
            usart().dr().write(|w| unsafe { w.bits(byte.into()) });
        }
        self.flush();
    }

    fn flush(&self) {
        let _ = (0..POLLS).any(|_| usart().sr().read().tc().bit_is_set());
    }
}
