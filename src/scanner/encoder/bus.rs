//! I²C over two pins, as the only master, with a timeout of every wait.
//!
//! The HAL's driver of the chip's I²C peripheral waits for its flags without a timeout: a line that is held low
//! would block the scanner until the watchdog resets it. Here a line that stays low is an error after 0.1 ms,
//! and a device that was interrupted within a byte is clocked out of it first.
//!
//! A bit has three waits of 1.3 µs: until the data line is stable, while the clock is high, and while it is low. That is
//! 256 kbit/s at most, and each time is within fast mode (UM10204, table 10): low 2.6 µs (minimum 1.3), high 1.3 µs
//! (0.6, of which the pull-ups may take 0.3 to rise), bus free between stop and start 2.6 µs (1.3).

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::i2c::{self, ErrorKind, I2c, NoAcknowledgeSource, Operation};

/// Error of an I²C transaction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusError {
    /// A device holds the clock or data line low.
    Held,
    /// No device acknowledges.
    NoAcknowledge,
    /// A pin cannot be set or read.
    Pin,
}

impl i2c::Error for BusError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Held => ErrorKind::Bus,
            Self::NoAcknowledge => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Unknown),
            Self::Pin => ErrorKind::Other,
        }
    }
}

/// Duration of each of the three waits of a bit, ns.
const WAIT_NS: u32 = 1_300;
/// Maximum time for which a device may hold the clock low, in waits of 1.3 µs: 0.1 ms.
const STRETCH: u8 = 77;
/// Number of clock pulses after which an interrupted device has released the data line: a byte and its
/// acknowledgement.
const RELEASE: u8 = 9;

/// I²C bus over two open-drain pins with pull-ups; `delay` times the bits.
#[derive(Debug)]
pub struct PinBus<C, D, T> {
    clock: C,
    data: D,
    delay: T,
    /// First error of the current transaction, after which no more bits are sent; `None` without an error.
    error: Option<BusError>,
}

impl<C, D, T> PinBus<C, D, T>
where
    C: InputPin + OutputPin,
    D: InputPin + OutputPin,
    T: DelayNs,
{
    /// Creates the bus with both lines released.
    pub fn new(mut clock: C, mut data: D, delay: T) -> Self {
        // A pin that fails does so again when it is used.
        let _ = (clock.set_high(), data.set_high());
        Self {
            clock,
            data,
            delay,
            error: None,
        }
    }

    fn wait(&mut self) {
        self.delay.delay_ns(WAIT_NS);
    }

    /// Stores `error` if it is the first of the transaction.
    fn fail(&mut self, error: BusError) {
        self.error.get_or_insert(error);
    }

    /// Releases the clock line and waits until no device holds it low; an error after 0.1 ms.
    fn clock_high(&mut self) {
        let mut pin = self.clock.set_high().is_ok();
        for _ in 0..STRETCH {
            self.wait();
            let high = self.clock.is_high();
            pin &= high.is_ok();
            if high.unwrap_or(true) {
                if !pin {
                    self.fail(BusError::Pin);
                }
                return;
            }
        }
        self.fail(BusError::Held);
    }

    fn clock_low(&mut self) {
        if self.clock.set_low().is_err() {
            self.fail(BusError::Pin);
        }
        self.wait();
    }

    fn set_data(&mut self, high: bool) {
        if self.data.set_state(high.into()).is_err() {
            self.fail(BusError::Pin);
        }
        self.wait();
    }

    fn data_high(&mut self) -> bool {
        self.data.is_high().unwrap_or(true)
    }

    /// Sends one bit and returns the level of the data line while the clock was high: send ones to read. After
    /// an error it does nothing and returns a one.
    fn bit(&mut self, bit: bool) -> bool {
        if self.error.is_some() {
            return true;
        }
        self.set_data(bit);
        self.clock_high();
        let seen = self.data_high();
        self.clock_low();
        seen
    }

    /// Sends a start condition, or a repeated one. If a device holds the data line low, it is clocked first until
    /// it releases the line.
    fn start(&mut self) {
        self.set_data(true);
        self.clock_high();
        let mut clocks = RELEASE;
        while !self.data_high() && clocks > 0 {
            self.bit(true);
            self.clock_high();
            clocks -= 1;
        }
        if !self.data_high() {
            self.fail(BusError::Held);
        }
        self.set_data(false);
        self.clock_low();
    }

    fn stop(&mut self) {
        self.set_data(false);
        self.clock_high();
        self.set_data(true);
    }

    fn send(&mut self, byte: u8) {
        for place in (0..u8::BITS).rev() {
            self.bit(byte >> place & 1 != 0);
        }
        // A zero is an acknowledgement.
        if self.bit(true) {
            self.fail(BusError::NoAcknowledge);
        }
    }

    fn receive(&mut self, last: bool) -> u8 {
        let mut byte = 0;
        for _ in 0..u8::BITS {
            byte = byte << 1 | u8::from(self.bit(true));
        }
        self.bit(last);
        byte
    }

    /// Performs one read or write of a transaction.
    fn operate(&mut self, address: u8, operation: &mut Operation<'_>, neighbours: Neighbours) {
        if !neighbours.continues {
            self.start();
            self.send(address << 1 | u8::from(is_read(operation)));
        }
        match operation {
            Operation::Write(bytes) => bytes.iter().for_each(|&byte| self.send(byte)),
            Operation::Read(bytes) => {
                let mut rest = bytes.len();
                for byte in bytes.iter_mut() {
                    rest -= 1;
                    *byte = self.receive(rest == 0 && !neighbours.goes_on);
                }
            }
        }
    }
}

/// Operations before and after one of a transaction, compared with its direction.
#[derive(Clone, Copy, Debug)]
struct Neighbours {
    /// Whether the previous one has the same direction: start condition and address are left out.
    continues: bool,
    /// Whether the next one has the same direction: the last byte read is acknowledged.
    goes_on: bool,
}

fn is_read(operation: &Operation<'_>) -> bool {
    matches!(operation, Operation::Read(_))
}

impl<C, D, T> i2c::ErrorType for PinBus<C, D, T> {
    type Error = BusError;
}

impl<C, D, T> I2c for PinBus<C, D, T>
where
    C: InputPin + OutputPin,
    D: InputPin + OutputPin,
    T: DelayNs,
{
    fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), BusError> {
        self.error = None;
        let mut before = None;
        let mut rest = operations;
        while let Some((operation, later)) = rest.split_first_mut() {
            let read = is_read(operation);
            let neighbours = Neighbours {
                continues: before == Some(read),
                goes_on: later.first().is_some_and(|next| is_read(next) == read),
            };
            self.operate(address, operation, neighbours);
            before = Some(read);
            rest = later;
        }
        self.stop();
        match self.error {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests;
