//! A TMC2209 over its single wire: set-up, and status before each scan.
//!
//! Sections are those of Trinamic's data sheet, revision 1.09. One wire carries both directions
//! (section 4): what is sent comes back, and the answer follows. A register is written by eight bytes that
//! nobody answers; the chip counts those that were whole (`IFCNT`). So all are written, and the count must
//! have grown by as many. What is lost or damaged makes the whole set-up, or the reading, begin again.
//!
//! | register | is set to |
//! |---|---|
//! | `GSTAT` | its flags are cleared: a reset that is told from now on comes after this set-up |
//! | `GCONF` | the wire is for this, microsteps come from `CHOPCONF`, StealthChop (StallGuard4 needs it), current from the registers and not from VREF, filter of STEP |
//! | `IHOLD_IRUN` | `motor-current`, standing or not: the mirror's place does not shift with the current, and between scans EN is what switches it off |
//! | `TPOWERDOWN` | the chip's own value after power-up |
//! | `TCOOLTHRS` | StallGuard works from 0.8 of `search-speed` on; not at all where `stall-threshold` is 0 |
//! | `SGTHRS` | `stall-threshold` |
//! | `CHOPCONF` | `microsteps-per-turn`, a motor of 200 full steps taken for granted; range of the current; the rest as after power-up, with interpolation to 256 |
//!
//! | status | means |
//! |---|---|
//! | `GSTAT`: reset | it was reset since it was set up, and drives with what its pins say |
//! | `GSTAT`: driver error, charge pump | it has switched itself off |
//! | `DRV_STATUS`: overtemperature, short to ground or supply | likewise |
//! | `DRV_STATUS`: overtemperature warning, open load | nothing: the one comes before it switches off, the other is told of every motor that stands or turns fast (section 5.5.3) |

use core::hint::black_box;
use core::task::Poll;

use super::driver::{DriverError, MotorDriver};
use super::settings::{DriverConfig, MotorConfig};
use crate::port::BytePort;
use crate::time::Micros;

/// Baud rate of the wire: the chip takes 9600 to 500,000 and finds out by itself (section 4).
pub const BAUD: u32 = 115_200;

/// A datagram's first byte (section 4.1).
const SYNC: u8 = 0x05;
/// The chip's address: its pins MS1 and MS2 are low.
const CHIP: u8 = 0;
/// Address of whoever asked.
const MASTER: u8 = 0xff;
/// Bit of a register's address that makes a datagram write it.
const WRITE: u8 = 0x80;
/// Bytes of a datagram that writes, and of an answer.
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

/// GCONF: `pdn_disable`, `mstep_reg_select`, `multistep_filt` (section 5.1).
const GCONF_VALUE: u32 = 1 << 6 | 1 << 7 | 1 << 8;
/// GSTAT: `reset` (section 5.1).
const WAS_RESET: u32 = 1;
/// GSTAT: `drv_err`, `uv_cp`.
const FAILED: u32 = 1 << 1 | 1 << 2;
/// TPOWERDOWN after power-up (section 5.2).
const TPOWERDOWN_VALUE: u32 = 20;
/// CHOPCONF after power-up: `intpol`, HSTRT 5, TOFF 3 (section 5.5.1). MRES is 0, 256 microsteps.
const CHOPCONF_VALUE: u32 = 0x1000_0053;
/// Where MRES stands in it.
const MRES: u32 = 24;
/// CHOPCONF: the sense resistors' voltage is 0.18 V at full scale in place of 0.325.
const VSENSE: u32 = 1 << 17;
/// DRV_STATUS: `ot`, `s2ga`, `s2gb`, `s2vsa`, `s2vsb` (section 5.5.3).
const FATAL: u32 = 0b11_1110;

/// Greatest current with 0.325 V, and with 0.18 V, over 0.11 Ω and the chip's own 0.02 Ω, mA rms:
/// V / (0.13 Ω · √2) (section 9).
const FULL_SCALE: [u32; 2] = [1_767, 979];
/// Steps of the current's scale.
const SCALE: u32 = 32;

/// The chip's own clock, and a quarter more, so that StallGuard already works a little below the speed:
/// TSTEP counts it from microstep to microstep, of 256, and TCOOLTHRS is compared with it (section 5.2).
const CLOCK_AND_QUARTER: u32 = 15_000_000;
/// TCOOLTHRS has 20 bits.
const SLOWEST: u32 = 0xf_ffff;

/// An answer begins 8 bits after the question and takes 64 (section 4.1.2): 0.7 ms. The main loop may be
/// late by a few more.
const ANSWER_US: u32 = 10_000;
/// So many times it is tried before the chip counts as silent: within 30 ms, less than what a move's
/// deadline has to spare.
const TRIES: u8 = 3;
/// Bytes that are taken in one call: more than what can have come.
const BURST: u8 = 64;
/// StealthChop measures the motor while it stands, within 130 ms after EN (section 6.1).
const TUNING_US: u32 = 140_000;

/// CRC-8 of a datagram: polynomial 0x07, the least significant bit first (section 4.2).
// Out of line, and its loops rolled: nobody waits for it.
#[inline(never)]
pub fn crc(bytes: &[u8]) -> u8 {
    /// x⁸ + x² + x + 1.
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

/// Current scale (0 to 31) and whether VSENSE is set, for a current in mA rms: the nearest below it, on
/// the finer range where that reaches (section 9).
pub fn current_scale(milliamperes: u16) -> (u32, bool) {
    let [coarse, fine] = FULL_SCALE;
    let current = u32::from(milliamperes);
    let vsense = current <= fine;
    let full = if vsense { fine } else { coarse };
    let steps = (current * SCALE / full).clamp(1, SCALE);
    (steps - 1, vsense)
}

/// One datagram's purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Datagram {
    Read(u8),
    Write(u8, u32),
}

/// What is under way, one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DriverStep {
    /// Nothing.
    Idle,
    /// How many were written before.
    Before,
    /// The register of this place among those to write.
    Write(u8),
    /// Whether all of them have arrived.
    Written,
    /// Flags since the set-up.
    Flags,
    /// What it is at.
    Status,
}

/// A TMC2209 at the other end of `port`.
#[derive(Debug)]
pub struct Tmc2209<P> {
    port: P,
    motor: MotorConfig,
    step: DriverStep,
    /// Where to begin anew.
    first: DriverStep,
    tries: u8,
    /// IFCNT before the set-up.
    count: u8,
    frame: heapless::Vec<u8, DATAGRAM>,
    sent: usize,
    /// By when an answer has come; none while the question is being sent.
    until: Option<Micros>,
    /// The last bytes that came, the youngest lowest.
    heard: u64,
}

impl<P: BytePort> Tmc2209<P> {
    /// Nothing is under way.
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
            heard: 0,
        }
    }

    /// The wire.
    pub fn port_mut(&mut self) -> &mut P {
        &mut self.port
    }

    /// The registers that a set-up writes.
    fn registers(motor: &MotorConfig) -> [(u8, u32); 7] {
        let DriverConfig {
            stall_threshold,
            current,
            ..
        } = motor.driver;
        let (scale, vsense) = current_scale(current);
        // IHOLD and IRUN (section 5.2).
        let current = scale | scale << 8;
        let halvings = motor.driver.halvings().unwrap_or(0);
        let range = if vsense { VSENSE } else { 0 };
        let coolest = match stall_threshold {
            0 => 0,
            _ => (CLOCK_AND_QUARTER / motor.search_speed.max(1)).min(SLOWEST),
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

    /// The datagram of the present step.
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

    /// Begins the datagram of `step`; behind the last register the count follows.
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
        // It holds the longest.
        let _ = self.frame.extend_from_slice(&[SYNC, CHIP, register]);
        if let Some(value) = data {
            let _ = self.frame.extend_from_slice(&value.to_be_bytes());
        }
        let _ = self.frame.push(crc(&self.frame));
        (self.sent, self.until, self.heard) = (0, None, 0);
    }

    fn begin(&mut self, step: DriverStep) {
        (self.first, self.tries) = (step, 0);
        self.enter(step);
    }

    /// Once more from the beginning, some times.
    fn again(&mut self) -> Result<(), DriverError> {
        self.tries += 1;
        if self.tries >= TRIES {
            return Err(DriverError::Silent);
        }
        self.enter(self.first);
        Ok(())
    }

    /// Takes what has come, which is our own bytes too, up to an answer about `register`.
    fn hear(&mut self, register: u8) -> Option<u32> {
        for _ in 0..BURST {
            self.heard = self.heard << u8::BITS | u64::from(self.port.read()?);
            let bytes = self.heard.to_be_bytes();
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

    /// What an answer leads to.
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

    /// One look at the wire.
    fn advance(&mut self, now: Micros) -> Result<(), DriverError> {
        let register = match self.datagram() {
            None => return Ok(()),
            Some(Datagram::Read(register) | Datagram::Write(register, _)) => register,
        };
        let answer = self.hear(register);
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

    fn look(&mut self) {
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
mod chip;
#[cfg(test)]
mod tests;
