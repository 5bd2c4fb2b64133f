//! An AS5600, a magnetic encoder of 4096 counts a turn, over I²C.
//!
//! Registers are those of the data sheet of ams, revision 1-06. The chip keeps its power-up configuration;
//! nothing is written to it. The magnet is diametric and centred on the shaft's end to 0.25 mm. The pin DIR
//! sets the direction in which the angle grows: it must grow when the beam turns downwards.

use embedded_hal::i2c::I2c;

use super::{AngleEncoder, EncoderError};

/// I²C address of the AS5600, 7 bits.
pub const ADDRESS: u8 = 0x36;
/// Address of the register STATUS: state of the magnet.
const STATUS: u8 = 0x0b;
/// Address of the register RAW ANGLE: two bytes, the upper one first.
const RAW_ANGLE: u8 = 0x0c;
/// Bit MD of STATUS: magnet detected.
const MAGNET: u8 = 1 << 5;
/// Number of bits of RAW ANGLE: 4096 counts are a turn.
const BITS: u32 = 12;

/// An AS5600 on the I²C bus `bus`.
#[derive(Debug)]
pub struct As5600<B> {
    bus: B,
}

impl<B: I2c> As5600<B> {
    /// Creates the encoder without any access to the bus.
    pub fn new(bus: B) -> Self {
        Self { bus }
    }

    /// Reads as many bytes as `bytes` holds, one or two, from `register` on.
    fn read(&mut self, register: u8, bytes: &mut [u8]) -> Result<(), EncoderError> {
        let read = self.bus.write_read(ADDRESS, &[register], bytes);
        read.map_err(|_| EncoderError::Silent)
    }
}

impl<B: I2c> AngleEncoder for As5600<B> {
    fn angle(&mut self) -> Result<u16, EncoderError> {
        let mut bytes = [0; 2];
        let [status, _] = &mut bytes;
        self.read(STATUS, core::slice::from_mut(status))?;
        if *status & MAGNET == 0 {
            return Err(EncoderError::NoMagnet);
        }
        self.read(RAW_ANGLE, &mut bytes)?;
        Ok(u16::from_be_bytes(bytes) << (u16::BITS - BITS))
    }
}
