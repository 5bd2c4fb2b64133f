//! A serial port, as radar modules, the driver's wire and the report have one.

/// Most bytes that are read of a port in one go, so that a module that never falls silent cannot hold the
/// scanner up beyond a deadline: more than a port's queue holds.
pub const MOST_READ: u32 = 4096;

/// A serial port that never waits.
pub trait BytePort {
    /// The next byte that has come in.
    fn read(&mut self) -> Option<u8>;
    /// Throws away what has come in, before a request: it answers an earlier one. A module that babbles fills
    /// the port again meanwhile.
    fn drain(&mut self) {
        for _ in 0..MOST_READ {
            if self.read().is_none() {
                break;
            }
        }
    }
    /// Takes as many bytes as fit and says how many.
    fn write(&mut self, bytes: &[u8]) -> usize;
    /// Bytes that came damaged or were lost on the way in, since boot; 65535 for more.
    fn errors(&self) -> u16 {
        0
    }
    /// Whether the port can be set to this rate, baud, exactly.
    fn has_rate(&self, _baud: u32) -> bool {
        false
    }
    /// Sets it to a rate that it has, while it sends nothing.
    fn set_rate(&mut self, _baud: u32) {}
    /// A pulse on the TRIG pin beside the port.
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
