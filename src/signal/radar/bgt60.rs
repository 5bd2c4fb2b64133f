//! Infineon BGT60TR13C: 58.0 to 63.5 GHz, one transmitter, real samples, over SPI.
//!
//! The chip runs one frame of one chirp per trigger and sleeps in between. Wake-up takes a millisecond,
//! accurate to the microsecond by the chip's own clock, so a turning mirror is triggered that much earlier. The
//! FIFO is polled over SPI; neither interrupt nor reset pin is used (the reset pin is tied high). The crate
//! `bgt60trxx` has the same registers, but it waits for the interrupt pin in async functions, drives the reset
//! pin, needs precomputed register values, and needs a heap for frames.
//!
//! No function blocks: each makes a few transfers of up to 16 words, some 30 µs at 21 MHz. Only the trigger behind a
//! transfer that failed takes 0.1 ms: the chip keeps the error until a reset, which also resets its registers.

mod chip;

#[cfg(test)]
mod tests;

use core::task::Poll;

use embedded_hal::spi::SpiDevice;

use super::module::{LinkError, RequestedSettings};
use super::wire::RowTimes;
use crate::Iq;
use crate::config::RadarConfig;
use crate::time::Micros;
use chip::{
    BURST_ERROR, CHIP_ID, CLOCK_ERROR, ChirpShape, FIFO_RESET, FILLED, FRAME_START, FSTAT,
    GSR0_ERRORS, GSR0_FIFO, IDENTITY, MAIN, MAIN_AT_REST, OVERFLOW, PACR1, PLL_ON, SFCTL, SW_RESET,
    UNDERFLOW,
};

/// [`LinkError::Module`]: the SPI port failed.
pub const PORT_FAILED: u8 = 1;
/// [`LinkError::Module`]: another chip, or none.
pub const WRONG_CHIP: u8 = 2;
/// [`LinkError::Module`]: a register does not read back the value written.
pub const VERIFY_FAILED: u8 = 3;
/// [`LinkError::Module`]: overflow or underflow of the FIFO.
pub const FIFO_FAILED: u8 = 4;
/// [`LinkError::Module`]: the chip counted another number of clocks or words than were sent.
pub const SPI_FAILED: u8 = 5;

/// Pause after a software reset, microseconds: the data sheet requires 100 ns (section 5.10), the vendor's
/// driver waits for 10 ms.
const RESET_US: u32 = 10_000;
/// Interval of polling the FIFO, microseconds. The first poll is at the expected end of the chirp: a transfer
/// during sampling would couple into the converter.
const POLL_US: u32 = 50;
/// Maximum number of FIFO words per transfer: 52 bytes with the command, 20 µs at 21 MHz.
const BURST_WORDS: usize = 16;
/// Time to read up to [`BURST_WORDS`] words from the FIFO, microseconds: the transfer, its command and the
/// scanner's loop around it.
const PIECE_US: u32 = 40;
/// Length of an SPI command, bytes.
const COMMAND: usize = 4;
const WORD: usize = 3;
/// Command of a burst from the FIFO, without the number of words (section 5.7). It is bounded, so that the chip
/// removes no word from the FIFO that is not read.
const BURST: u32 = 0x7f << 25 | 1 << 24 | 0x60 << 17;

/// Stage of the present request to the chip, a set-up or a chirp.
#[derive(Clone, Copy, Debug)]
enum ChipStage {
    /// No request.
    Idle,
    /// Waiting for the end of the chip's reset.
    Resetting,
    /// Writing registers; number of registers written so far.
    Writing(u8),
    /// Waiting for the chirp in the FIFO.
    Sampling,
    /// Reading the chirp from the FIFO; number of words read so far.
    Reading(u16),
    /// The last request failed.
    Failed(LinkError),
}

/// Driver of the BGT60TR13C. Each call is given the SPI port.
#[derive(Debug)]
pub struct Bgt60 {
    stage: ChipStage,
    shape: ChirpShape,
    /// Time before which the chip is not accessed again.
    next_poll: Micros,
    /// Deadline of the present request.
    until: Micros,
}

impl Default for Bgt60 {
    fn default() -> Self {
        Self::new()
    }
}

impl Bgt60 {
    /// Creates a driver without a pending request.
    pub const fn new() -> Self {
        Self {
            stage: ChipStage::Idle,
            shape: ChirpShape::DEFAULT,
            next_poll: Micros(0),
            until: Micros(0),
        }
    }

    /// Begins to set the chip up: checks its identity and resets it by software.
    pub fn program(
        &mut self,
        spi: &mut impl SpiDevice<u8>,
        now: Micros,
        requested: &RequestedSettings,
        timeout_us: u32,
    ) {
        self.shape = ChirpShape::of(requested.bandwidth_khz, requested.samples);
        self.until = now.plus(timeout_us);
        self.next_poll = now.plus(RESET_US);
        self.stage = match identify_and_reset(spi, &self.shape) {
            Ok(()) => ChipStage::Resetting,
            Err(error) => ChipStage::Failed(error),
        };
    }

    /// Continues the set-up, one register per call. Returns the radar settings when all registers read back
    /// correctly.
    pub fn settings(
        &mut self,
        spi: &mut impl SpiDevice<u8>,
        now: Micros,
    ) -> Poll<Result<RadarConfig, LinkError>> {
        let outcome = match self.stage {
            ChipStage::Failed(error) => Err(error),
            _ if now.reached(self.until) => Err(LinkError::Timeout),
            ChipStage::Resetting => {
                if now.reached(self.next_poll) {
                    self.stage = ChipStage::Writing(0);
                }
                return Poll::Pending;
            }
            ChipStage::Writing(k) => match self.shape.register(k) {
                Some((address, value)) => match set(spi, address, value) {
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

    /// Empties the FIFO and starts a frame of one chirp.
    pub fn trigger(
        &mut self,
        spi: &mut impl SpiDevice<u8>,
        now: Micros,
        _shaft_angle: i32,
        timeout_us: u32,
    ) {
        self.until = now.plus(timeout_us);
        self.next_poll = now.plus(self.shape.time_us());
        self.stage = match start(spi, &self.shape) {
            Ok(()) => ChipStage::Sampling,
            Err(error) => ChipStage::Failed(error),
        };
    }

    /// Returns the times of trigger, chirp and answer of a row with the present settings.
    pub fn row_times(&self) -> RowTimes {
        let shape = &self.shape;
        RowTimes {
            trigger_us: shape.ahead_us(),
            held_us: 0,
            chirp_us: Some(shape.acquisition_us()),
            answer_us: POLL_US + PIECE_US * u32::from(shape.pairs).div_ceil(BURST_WORDS as u32),
            ahead: false,
        }
    }

    /// Returns the times of trigger, chirp and answer of a row with the requested settings.
    pub fn times(requested: &RequestedSettings) -> RowTimes {
        let shape = ChirpShape::of(requested.bandwidth_khz, requested.samples);
        Self {
            shape,
            ..Self::new()
        }
        .row_times()
    }

    /// Returns whether the chirp has been captured. The chip wakes up for a millisecond before the chirp, so
    /// the mirror has to stand until the samples are in the FIFO.
    pub fn sent(&self) -> bool {
        !matches!(self.stage, ChipStage::Sampling)
    }

    /// Checks whether the chirp is complete, and reads it into `samples`, one piece per call.
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
            ChipStage::Sampling if !now.reached(self.next_poll) => Ok(false),
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

    /// Checks by the FIFO's threshold whether all samples are there, from when on they are read; returns false,
    /// because none has been read yet. The fill level is not used: it must not be read while it changes
    /// (section 4.23).
    fn look_at_fifo(
        &mut self,
        spi: &mut impl SpiDevice<u8>,
        now: Micros,
    ) -> Result<bool, LinkError> {
        let state = state(spi)?;
        if state & (OVERFLOW | UNDERFLOW) != 0 {
            return Err(LinkError::Module(FIFO_FAILED));
        }
        if state & FILLED != 0 {
            self.stage = ChipStage::Reading(0);
        } else {
            self.next_poll = now.plus(POLL_US);
        }
        Ok(false)
    }

    /// Reads the next words of the chirp into `samples`, of which `done` are complete. Returns whether it was
    /// the last piece.
    fn read_piece(
        &mut self,
        spi: &mut impl SpiDevice<u8>,
        samples: &mut [Iq],
        done: u16,
    ) -> Result<bool, LinkError> {
        let mut pieces = samples
            .chunks_mut(BURST_WORDS)
            .skip(usize::from(done) / BURST_WORDS);
        let Some(piece) = pieces.next() else {
            return Ok(true);
        };
        let last = pieces.next().is_none();
        let word = burst(spi, piece)?;
        self.stage = ChipStage::Reading(done + piece.len() as u16);
        // A word beyond the end of the FIFO reads as ones (section 5.1).
        if last && state(spi)? & UNDERFLOW != 0 && word == 0xff_ffff {
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

/// Reads the 24 bits of a register.
fn read(spi: &mut impl SpiDevice<u8>, address: u8) -> Result<u32, LinkError> {
    let mut bytes = (u32::from(address) << 25).to_be_bytes();
    spi.transfer_in_place(&mut bytes)
        .map_err(|_| LinkError::Module(PORT_FAILED))?;
    Ok(u32::from_be_bytes(bytes) & 0xff_ffff)
}

/// Writes a register of 24 bits and checks that it reads back correctly.
fn set(spi: &mut impl SpiDevice<u8>, address: u8, value: u32) -> Result<(), LinkError> {
    write(spi, address, value)?;
    match (read(spi, address)? ^ value) & chip::readback_mask(address) {
        0 => Ok(()),
        _ => Err(LinkError::Module(VERIFY_FAILED)),
    }
}

/// Checks the chip's identity and resets it. SFCTL is written first: after power-up the chip changes MISO with
/// the edge at which it is sampled.
fn identify_and_reset(spi: &mut impl SpiDevice<u8>, shape: &ChirpShape) -> Result<(), LinkError> {
    write(spi, SFCTL, shape.fifo())?;
    if read(spi, CHIP_ID)? != IDENTITY {
        return Err(LinkError::Module(WRONG_CHIP));
    }
    write(spi, MAIN, MAIN_AT_REST | SW_RESET)
}

/// Returns the FIFO status (register FSTAT); an error if a transfer failed since the frame began.
fn state(spi: &mut impl SpiDevice<u8>) -> Result<u32, LinkError> {
    let state = read(spi, FSTAT)?;
    match state & (CLOCK_ERROR | BURST_ERROR) {
        0 => Ok(state),
        _ => Err(LinkError::Module(SPI_FAILED)),
    }
}

/// Resets the chip and writes its registers at once. The data sheet requires 100 ns after a reset (section 5.10), which
/// the next command takes; that the registers read back as written shows whether that was enough.
// Out of line: it is rare, and its stack would lie beneath the estimator.
#[inline(never)]
fn reset(spi: &mut impl SpiDevice<u8>, shape: &ChirpShape) -> Result<(), LinkError> {
    write(spi, MAIN, MAIN_AT_REST | SW_RESET)?;
    let mut registers = (0..).map_while(|k| shape.register(k));
    registers.try_for_each(|(address, value)| set(spi, address, value))
}

/// Starts a frame with an empty FIFO and without errors: those that a FIFO reset leaves, all but those of the FIFO or of
/// none (sections 5.8 and 5.10 differ), would fail every later chirp, and a software reset clears them.
fn start(spi: &mut impl SpiDevice<u8>, shape: &ChirpShape) -> Result<(), LinkError> {
    // This also resets the state machine, without which no second frame would start (section 3.1).
    write(spi, MAIN, MAIN_AT_REST | FIFO_RESET)?;
    if read(spi, FSTAT)? & (CLOCK_ERROR | BURST_ERROR | UNDERFLOW | OVERFLOW) != 0 {
        reset(spi, shape)?;
    }
    // The state machine has switched the clock off (section 3.3.1).
    write(spi, PACR1, PLL_ON)?;
    write(spi, MAIN, MAIN_AT_REST | FRAME_START)
}

/// Reads one FIFO word for each pair of real samples in `piece`, at most [`BURST_WORDS`]. Returns the last
/// word.
fn burst(spi: &mut impl SpiDevice<u8>, piece: &mut [Iq]) -> Result<u32, LinkError> {
    let mut bytes = [0; COMMAND + WORD * BURST_WORDS];
    let count = piece.len().min(BURST_WORDS);
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

/// Converts a 12-bit code, in which 2048 is zero, to a signed sample, left-aligned in 16 bits. The ends of the
/// converter's range become full scale, by which saturation is detected; the chip may give its lower end as 1
/// (section 5.1).
fn sample_of(code: u32) -> i16 {
    match code {
        0 | 1 => i16::MIN,
        0xfff => i16::MAX,
        _ => ((code as i16) - 2048) << 4,
    }
}
