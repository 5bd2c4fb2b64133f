//! Simulated TMC2209 with its registers at the other end of the wire, with optional faults.

use std::collections::{BTreeMap, VecDeque};

use super::port::{Device, Wires};

/// Fault of the chip or of the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ChipFault {
    /// No fault.
    #[default]
    Well,
    /// The chip does not answer; the echo of the sent bytes works.
    Silent,
    /// The wire is cut: there is no echo either.
    Cut,
    /// The answers have a wrong checksum.
    WrongChecksum,
    /// The chip answers for another register.
    Other,
    /// The chip ignores writes, but answers.
    IgnoresWrites,
}

/// A simulated TMC2209 on a single wire.
#[derive(Debug)]
pub struct Chip {
    /// Register values by address.
    pub registers: BTreeMap<u8, u32>,
    /// Fault of the chip or of the wire.
    pub fault: ChipFault,
    /// Number of accepted writes since reset (IFCNT), which wraps.
    pub count: u8,
    /// Indices of bytes from the scanner that will be lost on the wire; the next byte has index 0.
    pub loses: Vec<usize>,
    /// Number of writes after which the chip resets itself; `None`: it does not.
    pub resets_after: Option<u32>,
    /// Bytes on the wire that the scanner has not received yet.
    wire: VecDeque<u8>,
    /// Number of consecutive polls of the wire, a byte's time apart, that found it idle.
    idle: u8,
    /// Number of accepted writes since power-up.
    pub writes: u32,
    /// Number of answered datagrams.
    pub reads: u32,
    frame: Vec<u8>,
}

/// CRC-8 as the data sheet's own program computes it (section 4.2), bit by bit.
pub fn checksum(bytes: &[u8]) -> u8 {
    let mut crc = 0_u8;
    for &byte in bytes {
        let mut current = byte;
        for _ in 0..8 {
            if (crc >> 7) ^ (current & 1) == 1 {
                crc = (crc << 1) ^ 7;
            } else {
                crc <<= 1;
            }
            current >>= 1;
        }
    }
    crc
}

impl Default for Chip {
    fn default() -> Self {
        let mut chip = Self {
            registers: BTreeMap::new(),
            fault: ChipFault::Well,
            count: 0xfd,
            loses: Vec::new(),
            resets_after: None,
            wire: VecDeque::new(),
            idle: 0,
            writes: 0,
            reads: 0,
            frame: Vec::new(),
        };
        chip.reset();
        chip
    }
}

impl Chip {
    /// Resets the chip as at power-up: default registers, with the reset flag in GSTAT.
    pub fn reset(&mut self) {
        self.registers = [
            (0x00, 0x0000_0101),
            (0x01, 0x0000_0001),
            (0x6c, 0x1000_0053),
            (0x6f, 0xc000_0000),
        ]
        .into();
        self.count = 0;
    }

    /// Returns the register at `address`, 0 if it was never written.
    pub fn register(&self, address: u8) -> u32 {
        self.registers.get(&address).copied().unwrap_or(0)
    }

    /// Sets the register at `address` to a value that only the chip itself can write.
    pub fn put(&mut self, address: u8, value: u32) {
        self.registers.insert(address, value);
    }

    fn take(&mut self, frame: &[u8]) {
        let (body, check) = frame.split_at(frame.len() - 1);
        if checksum(body) != check[0] || body[1] != 0 {
            return;
        }
        let address = body[2] & 0x7f;
        if body.len() == 3 {
            return self.answer(address);
        }
        if self.fault == ChipFault::IgnoresWrites {
            return;
        }
        let value = u32::from_be_bytes(body[3..7].try_into().unwrap());
        match address {
            // Flags are cleared by writing them.
            0x01 => *self.registers.entry(0x01).or_default() &= !value,
            _ => {
                self.registers.insert(address, value);
            }
        }
        (self.count, self.writes) = (self.count.wrapping_add(1), self.writes + 1);
        if self.resets_after == Some(self.writes) {
            self.reset();
        }
    }

    fn answer(&mut self, address: u8) {
        self.reads += 1;
        let value = match address {
            0x02 => self.count.into(),
            _ => self.register(address),
        };
        let about = match self.fault {
            ChipFault::Other => address ^ 4,
            _ => address,
        };
        let mut frame = vec![0x05, 0xff, about];
        frame.extend(value.to_be_bytes());
        let check = checksum(&frame);
        frame.push(match self.fault {
            ChipFault::WrongChecksum => check ^ 0x10,
            _ => check,
        });
        self.wire.extend(frame);
    }
}

impl Device for Chip {
    /// Returns the next byte that the scanner receives from the wire. A pause of 63 bits makes the chip discard
    /// an incomplete datagram (section 4.1.1).
    fn send(&mut self) -> Option<u8> {
        let byte = self.wire.pop_front();
        self.idle = match byte {
            Some(_) => 0,
            None => self.idle.saturating_add(1),
        };
        if self.idle > 7 {
            self.frame.clear();
        }
        byte
    }

    fn receive(&mut self, byte: u8, _: u64, _: &mut Wires) {
        self.idle = 0;
        if self.fault != ChipFault::Cut {
            // One wire: the byte is echoed.
            self.wire.push_back(byte);
        }
        let lost = self.loses.contains(&0);
        self.loses.retain(|&away| away > 0);
        self.loses.iter_mut().for_each(|away| *away -= 1);
        if lost || matches!(self.fault, ChipFault::Silent | ChipFault::Cut) {
            return;
        }
        if self.frame.is_empty() && byte & 0x0f != 5 {
            return;
        }
        self.frame.push(byte);
        let writes = self.frame.get(2).is_some_and(|address| address & 0x80 != 0);
        let length = if writes { 8 } else { 4 };
        if self.frame.len() == length {
            let frame = std::mem::take(&mut self.frame);
            self.take(&frame);
        }
    }
}
