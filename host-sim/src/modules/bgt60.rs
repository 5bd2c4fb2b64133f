//! Model of Infineon's BGT60TR13C behind its SPI: registers, state machine, FIFO and faults.
//!
//! Written from the data sheet (V2.4.9, sections in brackets), independently of the driver that is
//! tested with it: it decodes its programming by the sheet's formulas. Not modelled: the sensor
//! ADC, more than one shape or channel, triangular chirps, continuous wave and the data header.

mod chirp;
mod scene;

use std::collections::VecDeque;

use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
use stairscan::scanner::Micros;

pub use chirp::Chirp;
pub use scene::chirps;

/// Frequency of the chip's reference clock, Hz.
const CLOCK_HZ: f64 = 80e6;
/// Size of the chip's FIFO, words of 24 bits.
const FIFO_WORDS: usize = 8192;
/// Number of register addresses [4.1], and addresses of the registers that the model uses.
const REGISTERS: usize = 0x60;
const MAIN: usize = 0x00;
const ADC0: usize = 0x01;
const CHIP_ID: usize = 0x02;
const PACR1: usize = 0x04;
const PACR2: usize = 0x05;
const SFCTL: usize = 0x06;
const CCR: usize = 0x2c;
const PLL1: usize = 0x30;
const FSTAT: usize = 0x5f;
/// Error bits of the register FSTAT, which persist until a reset [4.23]: those of the FIFO until a FIFO reset [5.10], those
/// of transfers until a software reset [5.8].
const CLOCK_ERROR: u32 = 1 << 17;
const BURST_ERROR: u32 = 1 << 18;
const UNDERFLOW: u32 = 1 << 19;
const OVERFLOW: u32 = 1 << 23;
/// Bit OSCCLKEN of the register PACR1: the clock is enabled.
const CLOCK_ON: u32 = 1 << 23;
/// Bit MISO_HS_RD of the register SFCTL: MISO changes earlier, for fast SPI clocks.
const FAST_MISO: u32 = 1 << 16;

/// Fault of the chip or of its wires, for tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The chip is absent, and MISO reads as this byte.
    Absent(u8),
    /// The register CHIP_ID has this wrong value.
    Identity(u32),
    /// The register at this address keeps its value when written.
    Stuck(u8),
    /// No frame (measurement) ends.
    NeverReady,
    /// The FIFO overflows at the end of a frame.
    Overflow,
    /// The FIFO reports that it is filled, but holds only this number of words.
    Short(usize),
    /// The chip counts one clock too many in every burst.
    Clocks,
    /// The scanner's own SPI port fails.
    Port,
}

/// Model of the BGT60TR13C with its state.
pub struct Chip {
    registers: [u32; REGISTERS],
    fifo: VecDeque<u32>,
    /// Error bits of the register FSTAT.
    errors: u32,
    frames: u32,
    now: Micros,
    ends: Option<Micros>,
    fault: Option<Fault>,
    /// Samples that the converter takes in the next chirp, 12-bit codes. A list that is too short
    /// is filled up with mid scale.
    pub echo: Vec<u16>,
    /// Number of SPI transfers so far.
    pub transfers: usize,
}

impl Default for Chip {
    fn default() -> Self {
        Self::new()
    }
}

impl Chip {
    /// Creates a chip in its state after power-up.
    pub fn new() -> Self {
        let mut chip = Self {
            registers: [0; REGISTERS],
            fifo: VecDeque::new(),
            errors: 0,
            frames: 0,
            now: Micros(0),
            ends: None,
            fault: None,
            echo: Vec::new(),
            transfers: 0,
        };
        chip.reset();
        chip
    }

    /// Creates a chip in its state after power-up, with a fault.
    pub fn with(fault: Fault) -> Self {
        let mut chip = Self::new();
        chip.fault = Some(fault);
        chip
    }

    /// Sets the chip's fault, or clears it with `None`, from now on.
    pub fn set_fault(&mut self, fault: Option<Fault>) {
        self.fault = fault;
    }

    /// Sets the model's time; a frame that has ended by then fills the FIFO.
    pub fn at(&mut self, now: Micros) {
        self.now = now;
        if self.ends.is_some_and(|end| now.reached(end)) {
            self.end_frame();
        }
    }

    /// Returns the programmed chirp, computed by the formulas of [3.4] and [4.12 to 4.16].
    pub fn chirp(&self) -> Chirp {
        let field = |address: usize, low: u32, bits: u32| {
            f64::from((self.registers[address] >> low) & ((1 << bits) - 1))
        };
        let scaled = |address: usize, low: u32, multiplier: u32, bits: u32| {
            let power = field(address, multiplier, bits);
            field(address, low, 8) * power.exp2() * 8.0 + power + 3.0
        };
        let signed = |address: usize| f64::from((self.registers[address] << 8) as i32 >> 8);
        let hz = |steps: f64| 8.0 * CLOCK_HZ * steps / f64::from(1 << 20);
        let origin = 8.0 * CLOCK_HZ * (4.0 * (field(PACR2, 0, 5) + 2.0) + 8.0);
        let start = origin + hz(signed(PLL1));
        let slope = hz(signed(PLL1 + 1));
        let until_ramp = field(CCR + 1, 0, 9) * 8.0 + 10.0;
        let until_sample = field(CCR + 3, 0, 9) * 8.0 + field(CCR + 3, 9, 5) * 8.0 + 1.0;
        let (divider, samples) = (field(ADC0, 14, 10), field(PLL1 + 3, 0, 12));
        let wake_up = scaled(MAIN, 4, 12, 4);
        let settle = scaled(CCR + 3, 14, 22, 2) + scaled(CCR, 14, 22, 2);
        Chirp {
            first_hz: start + slope * (until_sample - until_ramp),
            step_hz: slope * divider,
            ramp_hz: [start, start + slope * field(PLL1 + 2, 0, 14) * 8.0],
            samples: samples as usize,
            rate_hz: CLOCK_HZ / divider,
            duration_s: (wake_up + settle + until_sample + divider * samples) / CLOCK_HZ,
        }
    }

    fn reset(&mut self) {
        self.registers = [0; REGISTERS];
        // Reset values other than 0 [4.2 to 4.11], as far as used here.
        self.registers[MAIN] = 3 << 19 | 3 << 17;
        self.registers[ADC0] = 40 << 14 | 1 << 9 | 1 << 6;
        self.registers[CHIP_ID] = 0x000303;
        self.registers[PACR1] = 0x19_6524;
        self.registers[PACR2] = 1 << 18 | 20;
        self.registers[SFCTL] = 14 << 19 | FAST_MISO;
        for address in [0x0b, 0x0f, 0x16, 0x1d, 0x24, 0x2b] {
            self.registers[address] = 0xb60;
        }
        self.errors = 0;
        self.reset_fifo();
    }

    fn reset_fifo(&mut self) {
        self.fifo.clear();
        self.errors &= !(OVERFLOW | UNDERFLOW);
        (self.frames, self.ends) = (0, None);
    }

    fn start_frame(&mut self) {
        let most = self.registers[CCR + 2] & 0xfff;
        let awake = self.registers[PACR1] & CLOCK_ON != 0;
        if awake && self.ends.is_none() && (most == 0 || self.frames < most) {
            let micros = (self.chirp().duration_s * 1e6).ceil() as u32;
            self.ends = Some(self.now.plus(micros));
        }
    }

    fn end_frame(&mut self) {
        if self.fault == Some(Fault::NeverReady) {
            return;
        }
        self.ends = None;
        self.frames += 1;
        // Deep sleep: the state machine switches the clock off.
        self.registers[PACR1] &= !CLOCK_ON;
        if self.fault == Some(Fault::Overflow) {
            self.errors |= OVERFLOW;
        }
        let samples = self.chirp().samples;
        let echo = (self.echo.iter().copied())
            .chain(std::iter::repeat(2048))
            .take(samples)
            .collect::<Vec<u16>>();
        for pair in echo.chunks_exact(2) {
            if self.fifo.len() == FIFO_WORDS {
                self.errors |= OVERFLOW;
                return;
            }
            let word = u32::from(pair[0] & 0xfff) << 12 | u32::from(pair[1] & 0xfff);
            self.fifo.push_back(word);
        }
    }

    fn state(&self) -> u32 {
        let fill = self.fifo.len() as u32;
        let filled = fill > (self.registers[SFCTL] & 0x1fff);
        self.errors
            | fill
            | u32::from(filled) << 21
            | u32::from(fill == 0) << 20
            | u32::from(fill as usize == FIFO_WORDS) << 22
    }

    fn read_register(&self, address: usize) -> u32 {
        match (address, self.fault) {
            (CHIP_ID, Some(Fault::Identity(identity))) => identity,
            (FSTAT, _) => self.state(),
            _ => self.registers.get(address).copied().unwrap_or(0),
        }
    }

    fn write_register(&mut self, address: usize, value: u32) {
        if self.fault == Some(Fault::Stuck(address as u8)) {
            return;
        }
        match address {
            MAIN => {
                self.registers[MAIN] = value & !0xf;
                match value & 0xf {
                    bits if bits & 0b0010 != 0 => self.reset(),
                    bits if bits & 0b1000 != 0 => self.reset_fifo(),
                    bits if bits & 0b0100 != 0 => (self.frames, self.ends) = (0, None),
                    0b0001 => self.start_frame(),
                    _ => {}
                }
            }
            CHIP_ID | 0x03 | 0x5d.. => {}
            _ => self.registers[address] = value,
        }
    }

    fn pop(&mut self) -> u32 {
        if let Some(Fault::Short(words)) = self.fault {
            let samples = self.registers[PLL1 + 3] as usize & 0xfff;
            let gone = samples / 2 - self.fifo.len().min(samples / 2);
            if gone >= words {
                self.errors |= UNDERFLOW;
                return 0xff_ffff;
            }
        }
        self.fifo.pop_front().unwrap_or_else(|| {
            self.errors |= UNDERFLOW;
            0xff_ffff
        })
    }

    /// Stores an error in FSTAT, which all later answers report [5.8]: of the number of clocks, of
    /// the number of words, or both.
    fn report_error(&mut self, clocks: bool, words: bool) {
        self.errors |= (u32::from(clocks) * CLOCK_ERROR) | (u32::from(words) * BURST_ERROR);
    }

    /// Answers a burst [5.7]: returns the bytes of the register or FIFO words that follow its
    /// command.
    fn burst(&mut self, command: u32, bytes: usize) -> Vec<u8> {
        let (start, write, words) = (command >> 17 & 0x7f, command >> 16 & 1, command >> 9 & 0x7f);
        let whole = bytes / 3;
        let amiss = words != 0 && words as usize != whole;
        let clocks = !bytes.is_multiple_of(3) || self.fault == Some(Fault::Clocks);
        let mut answer = vec![0; bytes];
        for (k, word) in answer.chunks_exact_mut(3).enumerate() {
            let value = match start {
                0x60 if write == 0 => self.pop(),
                _ => self.read_register(start as usize + k),
            };
            word.copy_from_slice(&value.to_be_bytes()[1..]);
        }
        self.report_error(clocks, amiss);
        answer
    }

    /// Performs one SPI transfer; returns as many bytes as were sent.
    fn exchange(&mut self, there: &[u8]) -> Vec<u8> {
        if let Some(Fault::Absent(level)) = self.fault {
            return vec![level; there.len()];
        }
        let fast = self.registers[SFCTL] & FAST_MISO != 0;
        let error = |bits: u32| u8::from(self.errors & bits != 0);
        let overrun = error(OVERFLOW | UNDERFLOW);
        let transfer = error(CLOCK_ERROR) | error(BURST_ERROR) << 1;
        let status = 0xf0 | overrun << 3 | u8::from(fast) << 2 | transfer;
        let Some((command, rest)) = there.split_first_chunk::<4>() else {
            self.report_error(!there.is_empty(), false);
            return vec![status; there.len()];
        };
        let word = u32::from_be_bytes(*command);
        let (address, write) = ((word >> 25) as usize, word >> 24 & 1 == 1);
        let mut back = vec![status, 0, 0, 0];
        if address == 0x7f && write {
            back.extend(self.burst(word, rest.len()));
        } else {
            let value = self.read_register(address).to_be_bytes();
            back[1..].copy_from_slice(&value[1..]);
            back.extend(rest);
            self.report_error(!rest.is_empty(), false);
            if write && rest.is_empty() {
                self.write_register(address, word & 0xff_ffff);
            }
        }
        if fast {
            late(&mut back);
        }
        back
    }
}

/// Returns an answer shifted by one bit, as it is read if each bit changes before it is sampled:
/// the effect of MISO_HS_RD at a clock that is too slow for it.
fn late(bytes: &mut [u8]) {
    let mut next = 0;
    for byte in bytes.iter_mut().rev() {
        let first = *byte >> 7;
        *byte = *byte << 1 | next;
        next = first;
    }
}

impl ErrorType for Chip {
    type Error = ErrorKind;
}

impl SpiDevice for Chip {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        if self.fault == Some(Fault::Port) {
            return Err(ErrorKind::Other);
        }
        self.transfers += 1;
        let mut there = Vec::new();
        for operation in operations.iter() {
            match operation {
                Operation::Read(buffer) => there.extend(vec![0; buffer.len()]),
                Operation::Write(bytes) | Operation::Transfer(_, bytes) => there.extend(*bytes),
                Operation::TransferInPlace(buffer) => there.extend(buffer.iter()),
                Operation::DelayNs(_) => {}
            }
        }
        let mut back = self.exchange(&there).into_iter();
        for operation in operations {
            match operation {
                Operation::Write(bytes) => back.by_ref().take(bytes.len()).for_each(drop),
                Operation::Read(buffer)
                | Operation::Transfer(buffer, _)
                | Operation::TransferInPlace(buffer) => {
                    buffer
                        .iter_mut()
                        .for_each(|b| *b = back.next().unwrap_or(0));
                }
                Operation::DelayNs(_) => {}
            }
        }
        Ok(())
    }
}
