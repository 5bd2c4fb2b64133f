//! A TMC2209 over its single-wire UART: set-up, and status before each scan.
//!
//! In: the settings of motor and driver. Out: [`DriverError`] if the driver does not answer, was reset or
//! reports a fault.
//!
//! Sections are those of Trinamic's data sheet, revision 1.09. One wire carries both directions (section 4):
//! the bytes sent are received back, and the answer follows. A register is written by eight bytes without an
//! answer; the chip counts the valid ones (`IFCNT`). So all registers are written, and the count must have
//! grown by their number. If a byte is lost or damaged, the whole set-up, or the whole reading, is repeated.
//!
//! | register | value |
//! |---|---|
//! | `GSTAT` | flags cleared: a reset flag from now on means a reset after this set-up |
//! | `GCONF` | UART instead of power-down on this pin, microsteps from `CHOPCONF`, StealthChop (StallGuard4 needs it), current from the registers and not from VREF, filter of STEP |
//! | `IHOLD_IRUN` | `motor-current`, at standstill, too: the mirror's position does not shift with the current, and between scans EN switches it off |
//! | `TPOWERDOWN` | the power-up value |
//! | `TCOOLTHRS` | StallGuard works from 0.8 of `search-speed` on; off if `stall-threshold` is 0 |
//! | `SGTHRS` | `stall-threshold` |
//! | `CHOPCONF` | `microsteps-per-turn`, assuming a motor of 200 full steps; range of the current; the rest as after power-up, with interpolation to 256 |
//!
//! | status | meaning |
//! |---|---|
//! | `GSTAT`: reset | the driver was reset after the set-up, and works with the configuration of its pins |
//! | `GSTAT`: driver error, charge pump | the driver has switched itself off |
//! | `DRV_STATUS`: overtemperature, short to ground or supply | the driver has switched itself off |
//! | `DRV_STATUS`: overtemperature warning, open load | ignored: the first precedes the switch-off, the second is reported for every motor that stands or turns fast (section 5.5.3) |

use core::hint::black_box;
use core::task::Poll;

use super::driver::{DriverError, MotorDriver};
use super::settings::{DriverConfig, MotorConfig};
use crate::port::BytePort;
use crate::time::Micros;

/// Baud rate of the TMC2209's wire. The chip accepts 9600 to 500,000 and detects it (section 4).
pub const BAUD: u32 = 115_200;

/// First byte of a datagram (section 4.1).
const SYNC: u8 = 0x05;
/// Address of the TMC2209 on the wire: its pins MS1 and MS2 are low.
const CHIP: u8 = 0;
/// Address of the master, which is the scanner, in an answer.
const MASTER: u8 = 0xff;
/// Bit of a register address that marks a write datagram.
const WRITE: u8 = 0x80;
/// Length of a write datagram, and of an answer, bytes.
const DATAGRAM: usize = 8;

// Addresses of registers (section 5).
const GCONF: u8 = 0x00;
const GSTAT: u8 = 0x01;
const IFCNT: u8 = 0x02;
const IHOLD_IRUN: u8 = 0x10;
const TPOWERDOWN: u8 = 0x11;
const TCOOLTHRS: u8 = 0x14;
const SGTHRS: u8 = 0x40;
const CHOPCONF: u8 = 0x6c;
const DRV_STATUS: u8 = 0x6f;

/// Value for GCONF: `pdn_disable`, `mstep_reg_select`, `multistep_filt` (section 5.1).
const GCONF_VALUE: u32 = 1 << 6 | 1 << 7 | 1 << 8;
/// Flag `reset` of GSTAT: the chip was reset (section 5.1).
const WAS_RESET: u32 = 1;
/// Flags `drv_err` and `uv_cp` of GSTAT: the driver has switched itself off, or its charge pump has undervoltage.
const FAILED: u32 = 1 << 1 | 1 << 2;
/// Value of TPOWERDOWN after power-up (section 5.2).
const TPOWERDOWN_VALUE: u32 = 20;
/// Value of CHOPCONF after power-up: `intpol`, HSTRT 5, TOFF 3 (section 5.5.1). MRES is 0, 256 microsteps.
const CHOPCONF_VALUE: u32 = 0x1000_0053;
/// Bit position of MRES in CHOPCONF.
const MRES: u32 = 24;
/// Bit VSENSE of CHOPCONF: sense voltage 0.18 V at full scale instead of 0.325 V.
const VSENSE: u32 = 1 << 17;
/// Flags of DRV_STATUS at which the driver switches itself off: `ot`, `s2ga`, `s2gb`, `s2vsa`, `s2vsb` (section
/// 5.5.3).
const FATAL: u32 = 0b11_1110;

/// Full-scale current of a phase with a sense voltage of 0.325 V and of 0.18 V, mA rms: V / (0.13 Ω · √2), with
/// 0.11 Ω on the board and 0.02 Ω in the chip (section 9).
const FULL_SCALE: [u32; 2] = [1_767, 979];
/// Number of steps of the current scale, to which IHOLD and IRUN refer.
const SCALE: u32 = 32;

/// The chip's clock of 12 MHz times 1.25, Hz: divided by `search-speed` it gives TCOOLTHRS, so that StallGuard
/// works from 0.8 of this speed on. TCOOLTHRS is compared with TSTEP, the clocks from one of 256 microsteps to
/// the next (section 5.2).
const CLOCK_AND_QUARTER: u32 = 15_000_000;
/// Maximum of TCOOLTHRS and TSTEP, which have 20 bits.
const MAX_TSTEP: u32 = 0xf_ffff;

/// Timeout of an answer, µs. The answer begins 8 bits after the request and takes 64 (section 4.1.2): 0.7 ms.
/// The main loop may add a few ms.
const ANSWER_US: u32 = 10_000;
/// Number of attempts after which the chip counts as silent: within 30 ms, less than the margin of a move's
/// deadline.
const TRIES: u8 = 3;
/// Maximum number of received bytes that one poll takes from the port: more than can have come.
const BURST: u8 = 64;
/// Time of StealthChop's automatic tuning after EN, µs: the chip measures the motor at standstill for up to 130
/// ms (section 6.1).
const TUNING_US: u32 = 140_000;

/// CRC-8 of a datagram: polynomial 0x07, the least significant bit first (section 4.2).
// Out of line and not unrolled: speed does not matter here.
#[inline(never)]
pub fn crc(bytes: &[u8]) -> u8 {
    /// The polynomial x⁸ + x² + x + 1 without its highest term.
    const POLYNOMIAL: u8 = 0x07;
    let mut crc = 0_u8;
    for &byte in bytes {
        for bit in 0..black_box(u8::BITS) {
            let carry = (crc >> 7) ^ (byte >> bit & 1);
            crc = (crc << 1) ^ (carry * POLYNOMIAL);
        }
    }
    crc
}

/// Returns the current scale (IRUN and IHOLD, 0 to 31) and whether VSENSE is set, for a phase current in mA rms:
/// the nearest value not above it, on the finer range if that suffices (section 9).
pub fn current_scale(milliamperes: u16) -> (u32, bool) {
    let [coarse, fine] = FULL_SCALE;
    let current = u32::from(milliamperes);
    let vsense = current <= fine;
    let full = if vsense { fine } else { coarse };
    let steps = (current * SCALE / full).clamp(1, SCALE);
    (steps - 1, vsense)
}

/// Request of one datagram: to read the register at an address, or to write a value to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Datagram {
    Read(u8),
    Write(u8, u32),
}

/// Current step of a set-up or status reading, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DriverStep {
    /// Nothing is under way.
    Idle,
    /// Reads IFCNT before the set-up.
    Before,
    /// Writes the register with this index in the list of `Tmc2209::registers`.
    Write(u8),
    /// Reads IFCNT to check that all registers were received.
    Written,
    /// Reads GSTAT: the flags since the set-up.
    Flags,
    /// Reads DRV_STATUS, the driver's status.
    Status,
}

/// A TMC2209 whose wire is connected to `port`.
#[derive(Debug)]
pub struct Tmc2209<P> {
    port: P,
    motor: MotorConfig,
    step: DriverStep,
    /// First step of the set-up or reading under way, to which a retry returns.
    first: DriverStep,
    tries: u8,
    /// IFCNT before the set-up: the chip's count of valid writes.
    count: u8,
    frame: heapless::Vec<u8, DATAGRAM>,
    sent: usize,
    /// Timeout of the answer; `None` while the request is being sent.
    until: Option<Micros>,
    /// Last eight bytes received, the newest in the lowest byte.
    last_bytes: u64,
}

impl<P: BytePort> Tmc2209<P> {
    /// Creates the driver; nothing is under way.
    pub fn new(port: P) -> Self {
        Self {
            port,
            motor: MotorConfig::default(),
            step: DriverStep::Idle,
            first: DriverStep::Idle,
            tries: 0,
            count: 0,
            frame: heapless::Vec::new(),
            sent: 0,
            until: None,
            last_bytes: 0,
        }
    }

    /// Returns the port of the wire.
    pub fn port_mut(&mut self) -> &mut P {
        &mut self.port
    }

    /// Returns address and value of each register that a set-up writes, in the order of writing.
    fn registers(motor: &MotorConfig) -> [(u8, u32); 7] {
        let DriverConfig {
            stall_threshold,
            current,
            ..
        } = motor.driver;
        let (scale, vsense) = current_scale(current);
        // IHOLD and IRUN (section 5.2).
        let current = scale | scale << 8;
        let halvings = motor.driver.mres().unwrap_or(0);
        let range = if vsense { VSENSE } else { 0 };
        let coolest = match stall_threshold {
            0 => 0,
            _ => (CLOCK_AND_QUARTER / motor.search_speed.max(1)).min(MAX_TSTEP),
        };
        [
            (GSTAT, WAS_RESET | FAILED),
            (GCONF, GCONF_VALUE),
            (IHOLD_IRUN, current),
            (TPOWERDOWN, TPOWERDOWN_VALUE),
            (TCOOLTHRS, coolest),
            (SGTHRS, stall_threshold.into()),
            (CHOPCONF, CHOPCONF_VALUE | halvings << MRES | range),
        ]
    }

    /// Returns the datagram of the current step; `None` if nothing is under way, or after the last register.
    fn datagram(&self) -> Option<Datagram> {
        Some(match self.step {
            DriverStep::Idle => return None,
            DriverStep::Before | DriverStep::Written => Datagram::Read(IFCNT),
            DriverStep::Write(place) => {
                let registers = Self::registers(&self.motor);
                let &(register, value) = registers.get(usize::from(place))?;
                Datagram::Write(register, value)
            }
            DriverStep::Flags => Datagram::Read(GSTAT),
            DriverStep::Status => Datagram::Read(DRV_STATUS),
        })
    }

    /// Begins `step` with its datagram; after the last register that is the reading of IFCNT.
    #[inline(never)]
    fn enter(&mut self, step: DriverStep) {
        self.step = step;
        if self.datagram().is_none() && step != DriverStep::Idle {
            self.step = DriverStep::Written;
        }
        self.frame.clear();
        let (register, data) = match self.datagram() {
            None => return,
            Some(Datagram::Read(register)) => (register, None),
            Some(Datagram::Write(register, value)) => (register | WRITE, Some(value)),
        };
        // The capacity suffices for the longest datagram.
        let _ = self.frame.extend_from_slice(&[SYNC, CHIP, register]);
        if let Some(value) = data {
            let _ = self.frame.extend_from_slice(&value.to_be_bytes());
        }
        let _ = self.frame.push(crc(&self.frame));
        (self.sent, self.until, self.last_bytes) = (0, None, 0);
    }

    fn begin(&mut self, step: DriverStep) {
        (self.first, self.tries) = (step, 0);
        self.enter(step);
    }

    /// Repeats the set-up or reading from its first step; an error after [`TRIES`] attempts.
    fn again(&mut self) -> Result<(), DriverError> {
        self.tries += 1;
        if self.tries >= TRIES {
            return Err(DriverError::Silent);
        }
        self.enter(self.first);
        Ok(())
    }

    /// Reads received bytes, which include the echo of the sent ones, and returns the value in an answer about
    /// `register`; `None` if no such answer is complete.
    fn receive(&mut self, register: u8) -> Option<u32> {
        for _ in 0..BURST {
            self.last_bytes = self.last_bytes << u8::BITS | u64::from(self.port.read()?);
            let bytes = self.last_bytes.to_be_bytes();
            let [SYNC, MASTER, about, a, b, c, d, check] = bytes else {
                continue;
            };
            let (content, _) = bytes.split_at(DATAGRAM - 1);
            if about == register && crc(content) == check {
                return Some(u32::from_be_bytes([a, b, c, d]));
            }
        }
        None
    }

    /// Handles the value in the answer to the current step, and begins the next step.
    fn answered(&mut self, value: u32) -> Result<(), DriverError> {
        match self.step {
            DriverStep::Before => {
                self.count = value as u8;
                self.enter(DriverStep::Write(0));
            }
            DriverStep::Written => {
                let written = Self::registers(&self.motor).len() as u8;
                if value as u8 != self.count.wrapping_add(written) {
                    return self.again();
                }
                self.enter(DriverStep::Flags);
            }
            DriverStep::Flags if value & WAS_RESET != 0 => return Err(DriverError::Reset),
            DriverStep::Flags if value & FAILED != 0 => return Err(DriverError::Fault),
            DriverStep::Flags => self.enter(DriverStep::Status),
            DriverStep::Status if value & FATAL != 0 => return Err(DriverError::Fault),
            DriverStep::Status | DriverStep::Write(_) | DriverStep::Idle => {
                self.step = DriverStep::Idle
            }
        }
        Ok(())
    }

    /// Advances the set-up or reading by one step at most, without waiting.
    fn advance(&mut self, now: Micros) -> Result<(), DriverError> {
        let register = match self.datagram() {
            None => return Ok(()),
            Some(Datagram::Read(register) | Datagram::Write(register, _)) => register,
        };
        let answer = self.receive(register);
        if let Some(until) = self.until {
            return match answer {
                Some(value) => self.answered(value),
                None if now.reached(until) => self.again(),
                None => Ok(()),
            };
        }
        let rest = self.frame.get(self.sent..).unwrap_or(&[]);
        self.sent += self.port.write(rest);
        if self.sent < self.frame.len() {
            return Ok(());
        }
        match self.step {
            DriverStep::Write(place) => self.enter(DriverStep::Write(place.saturating_add(1))),
            _ => self.until = Some(now.plus(ANSWER_US)),
        }
        Ok(())
    }
}

impl<P: BytePort> MotorDriver for Tmc2209<P> {
    fn set_up(&mut self, motor: &MotorConfig) {
        self.motor = *motor;
        self.begin(DriverStep::Before);
    }

    fn read_status(&mut self) {
        if self.step == DriverStep::Idle {
            self.begin(DriverStep::Flags);
        }
    }

    #[inline(never)]
    fn poll(&mut self, now: Micros) -> Poll<Result<(), DriverError>> {
        let went = self.advance(now);
        if went.is_err() {
            self.step = DriverStep::Idle;
        }
        match (went, self.step) {
            (Ok(()), DriverStep::Idle) => Poll::Ready(Ok(())),
            (Ok(()), _) => Poll::Pending,
            (Err(error), _) => Poll::Ready(Err(error)),
        }
    }

    fn tuning_us(&self) -> u32 {
        TUNING_US
    }
}

#[cfg(test)]
mod tests;
