//! Serial port of the scanner with the wires and a device behind it.
//!
//! In: what the scanner writes and what the device or the test sends. Out: the same bytes at the other end, at once or in
//! the time of their bit rate, with faults on command: a port that takes few bytes or none, overflow, different bit rates
//! of the two ends, a device that is mute or sends without pause.

use std::collections::VecDeque;

use rand_core::Rng;
use rand_xoshiro::Xoshiro128PlusPlus;
use stairscan::port::BytePort;

/// Index of the scanner's end in pairs of both ends of the wires.
pub const SCANNER: usize = 0;
/// Index of the device's end in pairs of both ends of the wires.
pub const DEVICE: usize = 1;
/// Bit rate of both ends at power-up, baud.
pub const FIRST_BAUD: u32 = 1_000_000;

/// A byte under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Byte {
    /// Time at which its last bit arrives, in the unit of [`Wires::now`].
    pub at: u64,
    /// Value as it was sent.
    pub value: u8,
    /// Bit rate at which it was sent, baud.
    pub baud: u32,
}

impl Byte {
    /// Returns the value that a port at `baud` receives. A port at another bit rate drops framing errors; bit patterns
    /// that look like a byte are received as a different one.
    fn heard(self, baud: u32) -> Option<u8> {
        match baud == self.baud {
            true => Some(self.value),
            false => (self.value & 1 == 1).then_some(self.value.rotate_left(3)),
        }
    }
}

/// Device at the far end of the wires.
pub trait Device {
    /// Takes a byte of the scanner that arrives at time `at`.
    fn receive(&mut self, byte: u8, at: u64, wires: &mut Wires);
    /// Takes a break: a zero byte at a lower bit rate than the device's.
    fn receive_break(&mut self, _wires: &mut Wires) {}
    /// Returns a byte for the scanner, which reads and finds none under way.
    fn send(&mut self) -> Option<u8> {
        None
    }
    /// Returns the maximum number of bytes that the port takes in the next write.
    fn room(&self) -> usize {
        usize::MAX
    }
}

/// Records what the scanner sends.
impl Device for Vec<u8> {
    fn receive(&mut self, byte: u8, _: u64, _: &mut Wires) {
        self.push(byte);
    }
}

/// The two wires between scanner and device, with the buffers of the scanner's port.
#[derive(Clone, Debug)]
pub struct Wires {
    /// Current time, in any unit.
    pub now: u64,
    /// Units of [`Wires::now`] in a second; `None`: bytes take no time.
    pub ticks: Option<u64>,
    /// Whether the device receives bytes when their time has passed, rather than when the port takes them.
    pub lags: bool,
    /// Maximum time for which bytes have left since the scanner's last write, for a scanner whose idle time is skipped.
    pub skipped: u64,
    /// Bit rates of the scanner's end and of the device's, baud.
    pub rates: [u32; 2],
    /// Bit rates that the scanner's port supports, baud.
    pub supported: &'static [u32],
    /// Maximum number of bytes that the port takes in one write; 0: it is stuck.
    pub room: usize,
    /// Size of the scanner's input buffer, bytes; further bytes are lost and counted.
    pub capacity: usize,
    /// Number of received bytes that were damaged or lost.
    pub errors: u16,
    /// Whether bytes of the device are lost on the wire.
    pub mute: bool,
    /// Random bytes that the scanner receives without pause; `None`: no fault.
    pub babble: Option<Xoshiro128PlusPlus>,
    /// Time of the last pulse on TRIG; `None` once the device has used it.
    pub edge: Option<u64>,
    /// Number of pulses on TRIG.
    pub edges: u32,
    /// Bytes under way to the scanner, or arrived and not read.
    pub incoming: VecDeque<Byte>,
    outgoing: VecDeque<Byte>,
    /// Time until which the scanner's transmitter is busy, and the device's.
    busy: [u64; 2],
    /// Whether the scanner's last write did not fit completely.
    pub waiting: bool,
}

impl Default for Wires {
    fn default() -> Self {
        Self {
            now: 0,
            ticks: None,
            lags: false,
            skipped: 0,
            rates: [FIRST_BAUD; 2],
            supported: &[],
            room: usize::MAX,
            capacity: usize::MAX,
            errors: 0,
            mute: false,
            babble: None,
            edge: None,
            edges: 0,
            incoming: VecDeque::new(),
            outgoing: VecDeque::new(),
            busy: [0; 2],
            waiting: false,
        }
    }
}

impl Wires {
    /// Returns the duration of a byte at the bit rate of end `end`: ten bits.
    pub fn byte(&self, end: usize) -> u64 {
        self.ticks.map_or(0, |t| {
            (10 * t + u64::from(self.rates[end]) / 2) / u64::from(self.rates[end])
        })
    }

    /// Returns the duration `us`, µs, in the unit of [`Wires::now`]; 0 if bytes take no time.
    pub fn us(&self, us: u64) -> u64 {
        self.ticks.map_or(0, |ticks| us * (ticks / 1_000_000))
    }

    /// Sends bytes to the scanner, one after the other, from time `from` on or as soon as the device's transmitter is
    /// free.
    pub fn send(&mut self, from: u64, bytes: &[u8]) {
        if self.mute {
            return;
        }
        let mut at = from.max(self.busy[DEVICE]);
        for &value in bytes {
            at += self.byte(DEVICE);
            if self.incoming.len() < self.capacity {
                let baud = self.rates[DEVICE];
                self.incoming.push_back(Byte { at, value, baud });
            } else {
                self.errors = self.errors.wrapping_add(1);
            }
        }
        self.busy[DEVICE] = at;
    }

    /// Adds bytes that arrive at time `at`, all at once, at the bit rate of the scanner's port.
    pub fn type_in(&mut self, at: u64, bytes: &[u8]) {
        let baud = self.rates[SCANNER];
        let bytes = bytes.iter().map(|&value| Byte { at, value, baud });
        self.incoming.extend(bytes);
    }

    /// Returns the first time after `seen` at which a byte arrives for the scanner.
    pub fn next_arrival(&self, seen: u64) -> Option<u64> {
        let times = self.incoming.iter().map(|byte| byte.at);
        times.filter(|&at| at > seen).min()
    }

    /// Returns the time until which the scanner's transmitter is busy.
    pub fn busy_until(&self) -> u64 {
        self.busy[SCANNER]
    }

    /// Takes a byte of the scanner, unless one is on the wire and one waits; returns whether it was taken.
    fn take(&mut self, value: u8) -> bool {
        let from = self.busy[SCANNER].max(self.now.saturating_sub(self.skipped));
        if from > self.now + self.byte(SCANNER) {
            return false;
        }
        let at = from + self.byte(SCANNER);
        self.busy[SCANNER] = at;
        let baud = self.rates[SCANNER];
        self.outgoing.push_back(Byte { at, value, baud });
        true
    }
}

/// Serial port of the scanner, and the device at the other end; by default one that records.
#[derive(Clone, Debug, Default)]
pub struct Port<D = Vec<u8>> {
    /// Wires and buffers.
    pub wires: Wires,
    /// Device at the other end.
    pub device: D,
}

impl<D: Device> Port<D> {
    /// Connects `device` to a port that takes any number of bytes and needs no time.
    pub fn new(device: D) -> Self {
        Self {
            wires: Wires::default(),
            device,
        }
    }

    /// Sends bytes to the scanner, which receives them at once.
    pub fn type_in(&mut self, bytes: impl AsRef<[u8]>) {
        self.wires.send(self.wires.now, bytes.as_ref());
    }

    /// Advances the time; the device receives what has arrived by then.
    pub fn advance(&mut self, now: u64) {
        self.wires.now = now;
        self.deliver(now);
    }

    fn deliver(&mut self, until: u64) {
        while let Some(byte) = self.wires.outgoing.pop_front_if(|byte| byte.at <= until) {
            let own = self.wires.rates[DEVICE];
            if byte.value == 0 && byte.baud < own {
                self.device.receive_break(&mut self.wires);
            }
            if let Some(value) = byte.heard(self.wires.rates[DEVICE]) {
                self.device.receive(value, byte.at, &mut self.wires);
            }
        }
    }
}

impl Port {
    /// Returns the complete lines that the scanner has sent since the last call, and keeps the rest.
    pub fn take_lines(&mut self) -> Vec<String> {
        let end = self.device.iter().rposition(|&byte| byte == b'\n');
        let whole: Vec<u8> = self.device.drain(..end.map_or(0, |end| end + 1)).collect();
        let text = String::from_utf8_lossy(&whole);
        text.lines().map(String::from).collect()
    }
}

impl<D: Device> BytePort for Port<D> {
    fn read(&mut self) -> Option<u8> {
        if let Some(random) = &mut self.wires.babble {
            return Some(random.next_u32() as u8);
        }
        let (now, baud) = (self.wires.now, self.wires.rates[SCANNER]);
        while let Some(byte) = self.wires.incoming.pop_front_if(|byte| byte.at <= now) {
            if let Some(value) = byte.heard(baud) {
                return Some(value);
            }
        }
        self.device.send()
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        let room = self.wires.room.min(self.device.room()).min(bytes.len());
        let taken = bytes[..room]
            .iter()
            .take_while(|&&byte| self.wires.take(byte));
        let taken = taken.count();
        self.wires.waiting = taken < bytes.len();
        if !self.wires.lags {
            self.deliver(u64::MAX);
        }
        taken
    }

    fn errors(&self) -> u16 {
        self.wires.errors
    }

    fn has_rate(&self, baud: u32) -> bool {
        self.wires.supported.contains(&baud)
    }

    fn set_rate(&mut self, baud: u32) {
        self.wires.rates[SCANNER] = baud;
    }

    fn pulse(&mut self) {
        self.wires.edge = Some(self.wires.now);
        self.wires.edges += 1;
    }
}
