//! Serial ports: received bytes come by interrupt, outgoing ones are written as the port takes them.

use core::sync::atomic::{AtomicU16, Ordering};

use super::clock::Clocks;
use super::delay::delay_clocks;
use heapless::spsc::{Consumer, Producer, Queue};
use stairscan::scanner::BytePort;
use stm32f4xx_hal::gpio::{Output, PC9};
use stm32f4xx_hal::nb;
use stm32f4xx_hal::pac::{self, Interrupt};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::serial::{Instance, Rx, Serial, Tx};

/// Baud rate of the report port.
pub const REPORT_BAUD: u32 = 115_200;

/// Queue of bytes received from the radar module: more than a whole chirp frame, since the scanner may be
/// processing a row meanwhile.
pub type LinkQueue = Queue<u8, 2048>;
/// Queue of bytes received at the report port: some command lines.
pub type ReportQueue = Queue<u8, 512>;
/// Queue of bytes received on the motor driver's wire: the echo of a request and its answer are twelve.
pub type DriverQueue = Queue<u8, 32>;

/// Receiving half of a serial port, for its interrupt.
pub struct Receiver<U: Instance> {
    rx: Rx<U>,
    queue: Producer<'static, u8>,
    errors: &'static AtomicU16,
}

impl<U: Instance> Receiver<U> {
    /// Queues a received byte. Bytes are lost if the queue is full, or if the port reports an error or overrun:
    /// the frame or line they belong to then fails its own check.
    pub fn receive(&mut self) {
        let lost = match self.rx.read() {
            Ok(byte) => self.queue.enqueue(byte).is_err(),
            Err(nb::Error::Other(_)) => true,
            Err(nb::Error::WouldBlock) => false,
        };
        if lost {
            // Only this function writes it.
            let errors = self.errors.load(Ordering::Relaxed);
            self.errors
                .store(errors.saturating_add(1), Ordering::Relaxed);
        }
    }
}

/// The scanner's half of a serial port: transmitter, and queue of received bytes.
pub struct Port<U: Instance> {
    tx: Tx<U>,
    queue: Consumer<'static, u8>,
    errors: &'static AtomicU16,
    interrupt: Interrupt,
}

/// The radar module's port, with a variable baud rate, and its trigger line TRIG.
pub struct LinkPort {
    port: Port<pac::USART1>,
    trig: PC9<Output>,
    clocks: Clocks,
}

impl LinkPort {
    /// Creates the radar module's port from the serial port `port`, which runs at 1 Mbaud.
    pub fn new(port: Port<pac::USART1>, trig: PC9<Output>, clocks: Clocks) -> Self {
        Self { port, trig, clocks }
    }
}

/// Microseconds in a second: with it the core's frequency becomes the clocks of a pulse on TRIG, 1 µs.
const MILLION: u32 = 1_000_000;

impl BytePort for LinkPort {
    fn read(&mut self) -> Option<u8> {
        self.port.read()
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        self.port.write(bytes)
    }

    fn errors(&self) -> u16 {
        self.port.errors()
    }

    fn has_rate(&self, baud: u32) -> bool {
        self.clocks.link_rate(baud).is_some()
    }

    fn set_rate(&mut self, baud: u32) {
        if let Some(divider) = self.clocks.link_rate(baud) {
            // SAFETY: only the scanner, which owns this port, writes the register, and `Clocks::link_rate`
            // returns only dividers that are valid for the port.
            unsafe {
                (*pac::USART1::ptr())
                    .brr()
                    .write(|w| w.bits(divider as u16))
            };
        }
    }

    fn pulse(&mut self) {
        self.trig.set_high();
        delay_clocks(self.clocks.core_hz / MILLION);
        self.trig.set_low();
    }
}
/// The scanner's half of the report port.
pub type ReportPort = Port<pac::USART2>;
/// The scanner's half of the motor driver's port.
pub type DriverPort = Port<pac::USART3>;

/// Splits a serial port that receives by `interrupt` into the scanner's half and the receiving half for the
/// interrupt.
pub fn part<U: Instance>(
    serial: Serial<U>,
    interrupt: Interrupt,
    (producer, queue): (Producer<'static, u8>, Consumer<'static, u8>),
    errors: &'static AtomicU16,
) -> (Port<U>, Receiver<U>) {
    let (tx, mut rx) = serial.split();
    rx.listen();
    let port = Port {
        tx,
        queue,
        errors,
        interrupt,
    };
    let receiver = Receiver {
        rx,
        queue: producer,
        errors,
    };
    (port, receiver)
}

/// Whether the port's receiver holds a byte: bit RXNE of SR, its first register (RM0090 30.6.1).
fn holds_byte<U: Instance>() -> bool {
    const RXNE: u32 = 1 << 5;
    // SAFETY: a device's register, always there. Reading it changes nothing: only a read of DR behind it clears error
    // bits, and the interrupt, which alone reads DR, reads SR first.
    unsafe { U::PTR.cast::<u32>().read_volatile() & RXNE != 0 }
}

impl<U: Instance> BytePort for Port<U> {
    /// Returns the next received byte from the queue, which the interrupt fills. If the queue is empty and the port
    /// holds a byte nevertheless, the interrupt is set pending: the emulator's port loses an interrupt if a byte comes
    /// in while another is read.
    fn read(&mut self) -> Option<u8> {
        let byte = self.queue.dequeue();
        if byte.is_none() && holds_byte::<U>() {
            rtic::pend(self.interrupt);
        }
        byte
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        let taken = bytes
            .iter()
            .take_while(|&&byte| self.tx.write(byte).is_ok());
        taken.count()
    }

    fn errors(&self) -> u16 {
        self.errors.load(Ordering::Relaxed)
    }
}

/// Sends `bytes` at the report port from the fault path, where nothing else runs any more; the timeout counts
/// polls, not time.
pub fn send_last(bytes: &[u8]) {
    /// Maximum number of polls until the port takes a byte: longer than a byte lasts at any baud rate and clock.
    const POLLS: u32 = 100_000;
    // SAFETY: the fault path never returns to other users of the port.
    let usart = unsafe { &*pac::USART2::ptr() };
    for &byte in bytes {
        let _ = (0..POLLS).any(|_| usart.sr().read().txe().bit_is_set());
        usart.dr().write(|w| w.dr().set(u16::from(byte)));
    }
    let _ = (0..POLLS).any(|_| usart.sr().read().tc().bit_is_set());
}
