//! Interface of a serial port: radar module, motor driver's wire and report UART.

/// Maximum number of bytes that are read from a port in one call, so that a module that sends without pause
/// cannot hold the scanner up beyond a deadline. It exceeds the size of a port's queue.
pub const MAX_READ: u32 = 4096;

/// A serial port that never blocks.
pub trait BytePort {
    /// Returns the next received byte, if any.
    fn read(&mut self) -> Option<u8>;
    /// Discards bytes received before a request, which would be read as its reply. At most [`MAX_READ`] bytes, in case
    /// the module sends all the time.
    fn drain(&mut self) {
        for _ in 0..MAX_READ {
            if self.read().is_none() {
                break;
            }
        }
    }
    /// Writes as many bytes as fit, and returns their number.
    fn write(&mut self, bytes: &[u8]) -> usize;
    /// Returns the number of received bytes that were damaged or lost since boot, at most 65535.
    fn errors(&self) -> u16 {
        0
    }
    /// Returns whether the port can be set to exactly this bit rate, baud.
    fn has_rate(&self, _baud: u32) -> bool {
        false
    }
    /// Sets the port to a bit rate, baud, that it supports, while it sends nothing.
    fn set_rate(&mut self, _baud: u32) {}
    /// Sends a pulse on the TRIG pin beside the port, which triggers the radar module.
    fn pulse(&mut self) {}
}

impl<P: BytePort + ?Sized> BytePort for &mut P {
    fn read(&mut self) -> Option<u8> {
        (**self).read()
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        (**self).write(bytes)
    }

    fn errors(&self) -> u16 {
        (**self).errors()
    }

    fn has_rate(&self, baud: u32) -> bool {
        (**self).has_rate(baud)
    }

    fn set_rate(&mut self, baud: u32) {
        (**self).set_rate(baud);
    }

    fn pulse(&mut self) {
        (**self).pulse();
    }
}
