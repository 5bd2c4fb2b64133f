//! The two serial ports: received bytes come by interrupt, sent ones go as the port takes them.

use core::ops::Deref;

use stairscan::scan::BytePort;
use stm32f4xx_hal::pac::{self, Interrupt, interrupt};

use super::clock::brr;
use super::ring::Ring;

/// Speed of the report port.
pub const REPORT_BAUD: u32 = 115_200;

/// More than a whole chirp frame: the main loop may work off a row meanwhile.
const LINK_QUEUE: usize = 2048;
/// Some command lines.
const REPORT_QUEUE: usize = 512;

static LINK: Ring<LINK_QUEUE> = Ring::new();
static REPORT: Ring<REPORT_QUEUE> = Ring::new();

type Registers = pac::usart1::RegisterBlock;

/// One serial port.
#[derive(Debug)]
pub struct Port<U, const N: usize> {
    usart: U,
    queue: &'static Ring<N>,
}

/// The radar module's port.
pub type LinkPort = Port<pac::USART1, LINK_QUEUE>;
/// The report port.
pub type ReportPort = Port<pac::USART2, REPORT_QUEUE>;

/// Starts the radar module's port.
pub fn link(usart: pac::USART1, bus_hz: u32) -> LinkPort {
    let baud = stairscan::scan::frame::LINK_BAUD;
    start(usart, &LINK, brr(bus_hz, baud), Interrupt::USART1)
}

/// Starts the report port.
pub fn report(usart: pac::USART2, bus_hz: u32) -> ReportPort {
    start(usart, &REPORT, brr(bus_hz, REPORT_BAUD), Interrupt::USART2)
}

/// 8 data bits, no parity, 1 stop bit; the receiver interrupts.
fn start<U: Deref<Target = Registers>, const N: usize>(
    usart: U,
    queue: &'static Ring<N>,
    brr: u32,
    interrupt: Interrupt,
) -> Port<U, N> {
    // SAFETY: the divider is below 2^16 for every clock and baud rate of this board.
    usart.brr().write(|w| unsafe { w.bits(brr as u16) });
    usart.cr1().write(|w| {
        w.ue().enabled();
        w.te().enabled();
        w.re().enabled();
        w.rxneie().enabled()
    });
    // SAFETY: its handler, below, touches nothing but the queue and the data register.
    unsafe { pac::NVIC::unmask(interrupt) };
    Port { usart, queue }
}

impl<U: Deref<Target = Registers>, const N: usize> BytePort for Port<U, N> {
    /// The interrupt fills the queue. When that is empty the flag is looked at as well: the
    /// emulator's port forgets an interrupt when a byte comes in while another is read.
    fn read(&mut self) -> Option<u8> {
        if let Some(byte) = self.queue.pop() {
            return Some(byte);
        }
        cortex_m::interrupt::free(|_| receive(&self.usart, self.queue));
        self.queue.pop()
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        let mut taken = 0;
        for &byte in bytes {
            if self.usart.sr().read().txe().bit_is_clear() {
                break;
            }
            self.usart.dr().write(|w| w.dr().set(u16::from(byte)));
            taken += 1;
        }
        taken
    }
}

/// Reading SR and then DR takes the byte and clears an overrun as well.
fn receive<const N: usize>(usart: &Registers, queue: &Ring<N>) {
    let status = usart.sr().read();
    if status.rxne().bit_is_set() || status.ore().bit_is_set() {
        queue.push(usart.dr().read().dr().bits() as u8);
    }
}

#[interrupt]
fn USART1() {
    // SAFETY: only this handler reads the data register; writing it is another register.
    receive(unsafe { &*pac::USART1::ptr() }, &LINK);
}

#[interrupt]
fn USART2() {
    // SAFETY: as above.
    receive(unsafe { &*pac::USART2::ptr() }, &REPORT);
}

/// Sends `bytes` from the fault path, where nothing else runs any more: bounded by polls, not by
/// time.
pub fn send_last(bytes: &[u8]) {
    /// Longer than a byte at any baud rate and clock.
    const POLLS: u32 = 100_000;
    // SAFETY: the fault path never returns to whoever else used the port.
    let usart = unsafe { &*pac::USART2::ptr() };
    for &byte in bytes {
        let _ = (0..POLLS).any(|_| usart.sr().read().txe().bit_is_set());
        usart.dr().write(|w| w.dr().set(u16::from(byte)));
    }
    let _ = (0..POLLS).any(|_| usart.sr().read().tc().bit_is_set());
}
