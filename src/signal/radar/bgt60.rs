//! Infineon BGT60TR13C: 58.0 to 63.5 GHz, one transmitter, real samples, over SPI.
//!
//! The chip runs one frame of one chirp for each trigger and sleeps in between. It takes a millisecond to wake up, by
//! its own clock to the microsecond, so that a mirror that turns is triggered that much earlier. Its FIFO is asked over SPI; neither its interrupt nor its reset pin is used (the
//! latter is tied high). The crate `bgt60trxx` has the same registers, but it waits for the interrupt pin in async
//! functions, drives the reset pin, takes its register values ready-made, and needs a heap for frames.
//!
//! No function waits: each one makes a few transfers of up to 16 words, some 30 µs at 21 MHz.

mod chip;

#[cfg(test)]
mod tests;

use core::task::Poll;

use embedded_hal::spi::SpiDevice;

use super::module::{LinkError, Wish};
use super::wire::RowTimes;
use crate::Iq;
use crate::config::RadarConfig;
use crate::time::Micros;
use chip::{
    BURST_ERROR, CHIP_ID, CLOCK_ERROR, ChirpShape, FIFO_RESET, FILLED, FRAME_START, FSTAT,
    GSR0_ERRORS, GSR0_FIFO, IDENTITY, MAIN, MAIN_AT_REST, OVERFLOW, PACR1, PLL_ON, SFCTL, SW_RESET,
    UNDERFLOW,
};

/// [`LinkError::Module`]: the SPI port itself failed.
pub const PORT_FAILED: u8 = 1;
/// [`LinkError::Module`]: there is no such chip, or none at all.
pub const STRANGER: u8 = 2;
/// [`LinkError::Module`]: a register does not hold what was written to it.
pub const NOT_HELD: u8 = 3;
/// [`LinkError::Module`]: the FIFO ran over, or was read beyond its end.
pub const FIFO_FAILED: u8 = 4;
/// [`LinkError::Module`]: the chip counted other clocks or words than it was told.
pub const SPI_FAILED: u8 = 5;

/// Behind a software reset nothing is sent for so long, microseconds: the data sheet asks for 100 ns (section 5.10),
/// the vendor's driver waits for 10 ms.
const RESET_US: u32 = 10_000;
/// From one look at the FIFO to the next, microseconds. The first one comes when the chirp should be over: a transfer
/// while the converter samples would couple into it.
const LOOK_US: u32 = 50;
/// Words of the FIFO that are read in one transfer: 52 bytes with the command, 20 µs at 21 MHz.
const PIECE: usize = 16;
/// From one piece to the next, microseconds: the transfer, its command and the scanner's loop around it.
const PIECE_US: u32 = 40;
/// Bytes of a command, and of a word of the FIFO.
const COMMAND: usize = 4;
const WORD: usize = 3;
/// The command of a burst from the FIFO, but for the number of words (section 5.7): bounded, so that the chip takes
/// no word out of the FIFO that is not asked for.
const BURST: u32 = 0x7f << 25 | 1 << 24 | 0x60 << 17;

/// What the chip is asked for.
#[derive(Clone, Copy, Debug)]
enum ChipStage {
    /// Nothing.
    Idle,
    /// It comes out of its reset.
    Resetting,
    /// So many registers are written.
    Writing(u8),
    /// Its chirp is on its way into the FIFO.
    Sampling,
    /// So many words of it have been read.
    Reading(u16),
    /// The last request could not be made.
    Failed(LinkError),
}

/// The chip without its port.
#[derive(Debug)]
pub struct Bgt60 {
    stage: ChipStage,
    shape: ChirpShape,
    /// The chip is left alone until then.
    look: Micros,
    /// By when the answer must have come.
    until: Micros,
    /// Bits of FSTAT that stood before the chirp.
    stale: u32,
}

impl Default for Bgt60 {
    fn default() -> Self {
        Self::new()
    }
}

impl Bgt60 {
    /// With nothing asked for.
    pub const fn new() -> Self {
        Self {
            stage: ChipStage::Idle,
            shape: ChirpShape::DEFAULT,
            look: Micros(0),
            until: Micros(0),
            stale: 0,
        }
    }

    /// Begins to set the chip up: its identity, and a software reset.
    pub fn program(
        &mut self,
        spi: &mut impl SpiDevice<u8>,
        now: Micros,
        wish: &Wish,
        timeout_us: u32,
    ) {
        self.shape = ChirpShape::of(wish.bandwidth_khz, wish.samples);
        self.until = now.plus(timeout_us);
        self.look = now.plus(RESET_US);
        self.stage = match greet(spi, &self.shape) {
            Ok(()) => ChipStage::Resetting,
            Err(error) => ChipStage::Failed(error),
        };
    }

    /// Goes on setting it up, a register a call: what it is set to when all of them hold.
    pub fn settings(
        &mut self,
        spi: &mut impl SpiDevice<u8>,
        now: Micros,
    ) -> Poll<Result<RadarConfig, LinkError>> {
        let outcome = match self.stage {
            ChipStage::Failed(error) => Err(error),
            _ if now.reached(self.until) => Err(LinkError::Timeout),
            ChipStage::Resetting => {
                if now.reached(self.look) {
                    self.stage = ChipStage::Writing(0);
                }
                return Poll::Pending;
            }
            ChipStage::Writing(k) => match self.shape.register(k) {
                Some(register) => match set(spi, register) {
                    Ok(()) => {
                        self.stage = ChipStage::Writing(k + 1);
                        return Poll::Pending;
                    }
                    Err(error) => Err(error),
                },
                None => Ok(self.shape.radar()),
            },
            _ => Err(LinkError::Answer),
        };
        self.stage = ChipStage::Idle;
        Poll::Ready(outcome)
    }

    /// Empties the FIFO and starts a frame.
    pub fn trigger(
        &mut self,
        spi: &mut impl SpiDevice<u8>,
        now: Micros,
        _shaft_angle: i32,
        timeout_us: u32,
    ) {
        self.until = now.plus(timeout_us);
        self.look = now.plus(self.shape.time_us());
        self.stage = match start(spi) {
            Ok(stale) => {
                self.stale = stale;
                ChipStage::Sampling
            }
            Err(error) => ChipStage::Failed(error),
        };
    }

    /// Times of a row as the chip is set up now.
    pub fn row_times(&self) -> RowTimes {
        let shape = &self.shape;
        RowTimes {
            trigger_us: shape.ahead_us(),
            held_us: 0,
            chirp_us: Some(shape.acquisition_us()),
            answer_us: LOOK_US + PIECE_US * u32::from(shape.pairs).div_ceil(PIECE as u32),
            ahead: false,
        }
    }

    /// Times of a row of a chip that is set up as wished.
    pub fn times(wish: &Wish) -> RowTimes {
        let shape = ChirpShape::of(wish.bandwidth_khz, wish.samples);
        Self {
            shape,
            ..Self::new()
        }
        .row_times()
    }

    /// Whether the chirp has been captured: the chip wakes up for a millisecond before it sweeps, so that the mirror
    /// has to stand until its samples are seen in the FIFO.
    pub fn sent(&self) -> bool {
        !matches!(self.stage, ChipStage::Sampling)
    }

    /// Looks whether the chirp is complete, and reads it piece by piece.
    pub fn poll(
        &mut self,
        spi: &mut impl SpiDevice<u8>,
        now: Micros,
        samples: &mut [Iq],
    ) -> Poll<Result<(), LinkError>> {
        let outcome = match self.stage {
            ChipStage::Failed(error) => Err(error),
            _ if now.reached(self.until) => Err(LinkError::Timeout),
            _ if samples.len() != usize::from(self.shape.pairs) => Err(LinkError::Answer),
            ChipStage::Sampling if !now.reached(self.look) => Ok(false),
            ChipStage::Sampling => self.look_at_fifo(spi, now),
            ChipStage::Reading(done) => self.read_piece(spi, samples, done),
            _ => Err(LinkError::Answer),
        };
        let complete = match outcome {
            Ok(false) => return Poll::Pending,
            Ok(true) => Ok(()),
            Err(error) => Err(error),
        };
        self.stage = ChipStage::Idle;
        Poll::Ready(complete)
    }

    /// Whether all samples are there decides the FIFO's threshold: its fill level is not to be looked at while it
    /// changes (section 4.23).
    fn look_at_fifo(
        &mut self,
        spi: &mut impl SpiDevice<u8>,
        now: Micros,
    ) -> Result<bool, LinkError> {
        let state = self.state(spi)?;
        if state & (OVERFLOW | UNDERFLOW) != 0 {
            return Err(LinkError::Module(FIFO_FAILED));
        }
        if state & FILLED != 0 {
            self.stage = ChipStage::Reading(0);
        } else {
            self.look = now.plus(LOOK_US);
        }
        Ok(false)
    }

    /// FSTAT, if no transfer failed since the frame began. Whether a FIFO reset clears what stood before is said
    /// either way (sections 5.8 and 5.10).
    fn state(&self, spi: &mut impl SpiDevice<u8>) -> Result<u32, LinkError> {
        let state = read(spi, FSTAT)?;
        match state & !self.stale & (CLOCK_ERROR | BURST_ERROR) {
            0 => Ok(state),
            _ => Err(LinkError::Module(SPI_FAILED)),
        }
    }

    /// Reads the next words of the chirp: whether it was the last piece.
    fn read_piece(
        &mut self,
        spi: &mut impl SpiDevice<u8>,
        samples: &mut [Iq],
        done: u16,
    ) -> Result<bool, LinkError> {
        let mut pieces = samples.chunks_mut(PIECE).skip(usize::from(done) / PIECE);
        let Some(piece) = pieces.next() else {
            return Ok(true);
        };
        let last = pieces.next().is_none();
        let word = burst(spi, piece)?;
        self.stage = ChipStage::Reading(done + piece.len() as u16);
        // A word that was not there comes as ones (section 5.1).
        if last && self.state(spi)? & UNDERFLOW != 0 && word == 0xff_ffff {
            return Err(LinkError::Module(FIFO_FAILED));
        }
        Ok(last)
    }
}

fn write(spi: &mut impl SpiDevice<u8>, address: u8, value: u32) -> Result<(), LinkError> {
    let command = u32::from(address) << 25 | 1 << 24 | value;
    spi.write(&command.to_be_bytes())
        .map_err(|_| LinkError::Module(PORT_FAILED))
}

/// A register's 24 bits.
fn read(spi: &mut impl SpiDevice<u8>, address: u8) -> Result<u32, LinkError> {
    let mut bytes = (u32::from(address) << 25).to_be_bytes();
    spi.transfer_in_place(&mut bytes)
        .map_err(|_| LinkError::Module(PORT_FAILED))?;
    Ok(u32::from_be_bytes(bytes) & 0xff_ffff)
}

/// Writes a register and sees whether it holds.
fn set(spi: &mut impl SpiDevice<u8>, (address, value): (u8, u32)) -> Result<(), LinkError> {
    write(spi, address, value)?;
    match (read(spi, address)? ^ value) & chip::holds(address) {
        0 => Ok(()),
        _ => Err(LinkError::Module(NOT_HELD)),
    }
}

/// Sees who is there and resets it. SFCTL comes first: after power-up the chip sends with the edge at which it is
/// read.
fn greet(spi: &mut impl SpiDevice<u8>, shape: &ChirpShape) -> Result<(), LinkError> {
    write(spi, SFCTL, shape.fifo())?;
    if read(spi, CHIP_ID)? != IDENTITY {
        return Err(LinkError::Module(STRANGER));
    }
    write(spi, MAIN, MAIN_AT_REST | SW_RESET)
}

/// Starts a frame with an empty FIFO: what FSTAT says before it.
fn start(spi: &mut impl SpiDevice<u8>) -> Result<u32, LinkError> {
    // It resets the state machine, too, without which no second frame would start (section 3.1).
    write(spi, MAIN, MAIN_AT_REST | FIFO_RESET)?;
    let state = read(spi, FSTAT)?;
    // The state machine has switched the clock off (section 3.3.1).
    write(spi, PACR1, PLL_ON)?;
    write(spi, MAIN, MAIN_AT_REST | FRAME_START)?;
    Ok(state)
}

/// Reads as many words as `piece` has places, at most [`PIECE`]: the last one.
fn burst(spi: &mut impl SpiDevice<u8>, piece: &mut [Iq]) -> Result<u32, LinkError> {
    let mut bytes = [0; COMMAND + WORD * PIECE];
    let count = piece.len().min(PIECE);
    if let Some(command) = bytes.first_chunk_mut::<COMMAND>() {
        *command = (BURST | (count as u32) << 9).to_be_bytes();
    }
    let transfer = bytes.get_mut(..COMMAND + WORD * count).unwrap_or_default();
    spi.transfer_in_place(transfer)
        .map_err(|_| LinkError::Module(PORT_FAILED))?;
    let [status, _, _, _, words @ ..] = &bytes;
    match status & GSR0_ERRORS {
        0 => {}
        GSR0_FIFO => return Err(LinkError::Module(FIFO_FAILED)),
        _ => return Err(LinkError::Module(SPI_FAILED)),
    }
    let mut last = 0;
    for (sample, &[high, middle, low]) in piece.iter_mut().zip(words.as_chunks::<WORD>().0) {
        last = u32::from_be_bytes([0, high, middle, low]);
        *sample = Iq::new(sample_of(last >> 12), sample_of(last & 0xfff));
    }
    Ok(last)
}

/// A sample of 12 bits about 2048, left-aligned in 16. The converter's ends become full scale, by which clipping is
/// told; the chip itself may show its lower end as 1 (section 5.1).
fn sample_of(code: u32) -> i16 {
    match code {
        0 | 1 => i16::MIN,
        0xfff => i16::MAX,
        _ => ((code as i16) - 2048) << 4,
    }
}
