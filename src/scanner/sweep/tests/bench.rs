//! Simulation of mirror shaft, serial wire and radar module on one clock.

use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::convert::Infallible;
use std::rc::Rc;
use std::vec::Vec;

use embedded_hal::digital::OutputPin;

use super::super::*;
use super::chip::SpiChip;
use crate::Iq;
use crate::config::{Config, ConfigError, RadarConfig};
use crate::drive::Drive;
use crate::mount::Mounting;
use crate::port::BytePort;
use crate::scanner::mirror::MirrorError;
use crate::scanner::pulser::Pulser;
use crate::scanner::settings::MotorConfig;
use crate::signal::radar::FrameLink;
use crate::signal::radar::frame::{self, Ability, Decoder, FrameKind, MAX_FRAME, Progress};
use crate::verdict::Conditions;

/// Core clocks in a microsecond.
pub const MHZ: u64 = 168;
/// Time between two polls of the sweep, µs.
pub const SPARE: u32 = 5;
/// Time for which the simulated data path processes a row, µs.
const WORK: u64 = 150;
/// Index of the scanner's end in pairs of both ends of the wire; below, that of the module's end.
const SCANNER: usize = 0;
const MODULE: usize = 1;
/// Time by which the answer with a late chirp is delayed, µs.
const LATE_US: u64 = 70_000;

/// Fault of the answer to one trigger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    Lost,
    Corrupt,
    Late,
    Error,
    Repeat,
}

/// Position of the shaft at begin, middle and end of a captured chirp, microsteps.
#[derive(Clone, Copy, Debug)]
pub struct Capture {
    /// Position of the row that was triggered, microsteps.
    pub wanted: i32,
    pub begin: f64,
    pub middle: f64,
    pub end: f64,
}

/// Result of a scan.
#[derive(Debug)]
pub struct Outcome {
    pub fault: Option<Reason>,
    pub ms: f64,
    pub captures: Vec<Capture>,
    pub rows: Vec<u16>,
    pub lost: Vec<u16>,
    pub mixed_up: u32,
    pub fired: Vec<(u16, u32)>,
    pub without_edge: u32,
    /// Number of polls.
    pub polls: usize,
}

/// An unconnected pin.
#[derive(Debug)]
struct Pin;

impl embedded_hal::digital::ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

pub struct World {
    /// Current time, core clocks.
    pub now: u64,
    pulser: Pulser<Pin, Pin, Pin>,
    next_step: Option<u64>,
    /// Time, core clocks, and position, microsteps, after every step, in order.
    way: Vec<(u64, i32)>,
    /// Baud rates of the scanner's end and of the module's, Mbaud.
    rates: [u8; 2],
    /// Maximum baud rate of the module, Mbaud.
    fastest: u8,
    /// Number, from 0, of the trigger after which the module falls back to 1 Mbaud; `None`: it never does.
    reset_at: Option<u32>,
    ahead: bool,
    pin: bool,
    /// Time of the last rising edge of TRIG, core clocks; `None` once a trigger has used it.
    edge: Option<u64>,
    /// Number of chirps whose trigger came without an edge.
    without_edge: u32,
    chirp_us: u64,
    /// Time until which the scanner's transmitter is busy, core clocks.
    sending: u64,
    to_module: VecDeque<(u64, u8, u8)>,
    /// Time until which the module's transmitter is busy, core clocks.
    answering: u64,
    to_scanner: VecDeque<(u64, u8, u8)>,
    decoder: Decoder,
    fates: BTreeMap<u32, Fate>,
    triggers: u32,
    /// Shaft angle in the trigger (0.001°), start and end (core clocks) of every captured chirp, in order.
    pub captures: Vec<(i32, u64, u64)>,
    before: Vec<u8>,
}

impl World {
    /// Returns the duration of a byte at the baud rate of end `end` of the wire, core clocks.
    fn byte(&self, end: usize) -> u64 {
        10 * MHZ / u64::from(self.rates[end])
    }

    /// Returns the byte that end `end` of the wire receives if one is sent at `rate`, Mbaud; `None` if its port
    /// drops it.
    fn heard(&self, byte: u8, rate: u8, end: usize) -> Option<u8> {
        match self.rates[end] {
            own if own == rate => Some(byte),
            // The port drops framing errors, except for bit patterns that look like a byte.
            _ => (byte & 1 == 1).then_some(byte.rotate_left(3)),
        }
    }

    fn advance(&mut self, by: u64) {
        self.now += by;
        while let Some(at) = self.next_step.filter(|&at| at <= self.now) {
            let ticks = self.pulser.tick();
            self.way.push((at, self.pulser.position()));
            self.next_step = ticks.map(|ticks| at + u64::from(ticks));
        }
        while let Some((at, byte, rate)) = self.to_module.pop_front_if(|b| b.0 <= self.now) {
            if byte == 0 && rate < self.rates[MODULE] {
                // A break on the line.
                self.rates[MODULE] = 1;
                self.decoder.reset();
            }
            let heard = self.heard(byte, rate, MODULE);
            if heard.map(|byte| self.decoder.push(byte)) == Some(Ok(Progress::Complete)) {
                self.request(at);
            }
        }
    }

    /// Returns the time of the next interrupt, by a motor step or a received byte, core clocks.
    fn next_interrupt(&self) -> Option<u64> {
        let bytes = self.to_scanner.iter().map(|&(at, ..)| at);
        let later = bytes.chain(self.next_step).filter(|&at| at > self.now);
        later.min()
    }

    /// Handles a complete request that the module has received at `at`, core clocks.
    fn request(&mut self, at: u64) {
        let Some(frame) = self.decoder.frame() else {
            return;
        };
        let (kind, sequence) = (frame.kind, frame.sequence);
        match kind {
            FrameKind::Configure | FrameKind::Program => {
                let ability = Ability {
                    fastest: self.fastest,
                    ahead: self.ahead,
                    pin: self.pin,
                };
                let payload = frame::settings_payload(&RadarConfig::default(), ability);
                return self.answer(at, encode(FrameKind::Settings, sequence, &payload));
            }
            FrameKind::Rate => {
                let rate = frame.payload[0];
                self.answer(at, encode(FrameKind::RateSet, sequence, &[rate]));
                self.rates[MODULE] = rate;
                return;
            }
            _ => {}
        }
        let angle = i32::from_le_bytes(frame.payload.try_into().unwrap());
        let at = match (self.pin, self.edge.take()) {
            (true, Some(edge)) if at - edge < 1_000 * MHZ => edge,
            (true, _) => {
                self.without_edge += 1;
                at
            }
            (false, _) => at,
        };
        let end = at + self.chirp_us * MHZ;
        self.captures.push((angle, at, end));
        if self.reset_at == Some(self.triggers) {
            self.rates[MODULE] = 1;
        }
        let fate = self.fates.get(&self.triggers).copied();
        self.triggers += 1;
        // The samples contain the angle for which they were captured.
        let samples = angle.to_le_bytes().repeat(200);
        let chirp = encode(FrameKind::Chirp, sequence, &samples);
        let before = std::mem::replace(&mut self.before, chirp.clone());
        match fate {
            Some(Fate::Lost) => {}
            Some(Fate::Late) => self.answer(end + LATE_US * MHZ, chirp),
            Some(Fate::Error) => self.answer(end, encode(FrameKind::Error, sequence, &[2])),
            Some(Fate::Corrupt) => {
                let mut chirp = chirp;
                chirp[300] ^= 8;
                self.answer(end, chirp);
            }
            Some(Fate::Repeat) => {
                self.answer(end, before);
                self.answer(end, chirp);
            }
            None => self.answer(end, chirp),
        }
    }

    fn answer(&mut self, from: u64, bytes: Vec<u8>) {
        let mut at = self.answering.max(from);
        for byte in bytes {
            at += self.byte(MODULE);
            self.to_scanner.push_back((at, byte, self.rates[MODULE]));
        }
        self.answering = at;
    }

    /// Returns the position of the shaft at `time` (core clocks), interpolated between steps, microsteps.
    fn place(&self, time: u64) -> f64 {
        let next = self.way.partition_point(|&(at, _)| at <= time);
        let (from, a) = self.way[next.saturating_sub(1)];
        match self.way.get(next) {
            // The shaft stood until the first step of a move.
            Some(&(to, b)) if to - from < 400 * MHZ => {
                f64::from(a) + f64::from(b - a) * (time - from) as f64 / (to - from) as f64
            }
            _ => f64::from(a),
        }
    }
}

fn encode(kind: FrameKind, sequence: u16, payload: &[u8]) -> Vec<u8> {
    let mut out = heapless::Vec::<u8, MAX_FRAME>::new();
    frame::encode(kind, sequence, payload, &mut out);
    out.to_vec()
}

#[derive(Clone)]
pub struct Shared(pub Rc<RefCell<World>>);

impl BytePort for Shared {
    fn read(&mut self) -> Option<u8> {
        let mut w = self.0.borrow_mut();
        let now = w.now;
        while let Some((_, byte, rate)) = w.to_scanner.pop_front_if(|b| b.0 <= now) {
            if let Some(byte) = w.heard(byte, rate, SCANNER) {
                return Some(byte);
            }
        }
        None
    }

    /// Accepts one byte on the wire and one waiting behind it.
    fn write(&mut self, bytes: &[u8]) -> usize {
        let mut w = self.0.borrow_mut();
        let mut taken = 0;
        for &byte in bytes {
            if w.sending > w.now + w.byte(SCANNER) {
                break;
            }
            w.sending = w.sending.max(w.now) + w.byte(SCANNER);
            let (at, rate) = (w.sending, w.rates[SCANNER]);
            w.to_module.push_back((at, byte, rate));
            taken += 1;
        }
        taken
    }

    fn has_rate(&self, baud: u32) -> bool {
        matches!(baud, 1_000_000 | 2_000_000 | 3_000_000)
    }

    fn set_rate(&mut self, baud: u32) {
        let mut w = self.0.borrow_mut();
        w.rates[SCANNER] = (baud / 1_000_000) as u8;
    }

    fn pulse(&mut self) {
        let mut w = self.0.borrow_mut();
        w.edge = Some(w.now);
    }
}

impl Mirror for Shared {
    fn start_home(&mut self, _: &MotorConfig) {}

    fn start_move(&mut self, position: i32, motor: &MotorConfig) {
        let mut w = self.0.borrow_mut();
        assert!(!w.pulser.moving(), "a move in the midst of another");
        let ramp = motor.ramp();
        let now = w.now;
        let here = w.pulser.position();
        w.way.push((now, here));
        w.next_step = w.pulser.begin(position, ramp).map(|t| now + u64::from(t));
    }

    fn poll(&mut self, _: Micros) -> Result<Motion, MirrorError> {
        Ok(match self.0.borrow().pulser.moving() {
            true => Motion::Moving,
            false => Motion::Still,
        })
    }

    fn position(&self) -> i32 {
        self.0.borrow().pulser.position()
    }

    fn homed(&self) -> bool {
        true
    }

    fn disable(&mut self) {}
}

/// Data path that records the rows it gets, and takes time for each.
struct Data {
    world: Shared,
    schedule: Schedule,
    samples: [Iq; 200],
    rows: Vec<u16>,
    lost: Vec<u16>,
    mixed_up: u32,
}

impl DataPath for Data {
    fn begin(&mut self, _: &Config, _: u32) -> Result<(), ConfigError> {
        Ok(())
    }

    fn begin_guard(&mut self, config: &Config, sweep: u32) -> Result<(), ConfigError> {
        self.begin(config, sweep)
    }

    fn samples(&mut self) -> &mut [Iq] {
        &mut self.samples
    }

    fn row(&mut self, row: u16) {
        let angle = shaft_angle(self.schedule.position(row));
        let [a, b] = [angle as u16 as i16, (angle >> 16) as i16];
        let own = self.samples.iter().all(|&s| s == Iq::new(a, b));
        self.mixed_up += u32::from(!own);
        self.rows.push(row);
        self.world.0.borrow_mut().advance(WORK * MHZ);
    }

    fn lost(&mut self, row: u16) {
        self.lost.push(row);
    }

    fn conclude(&mut self, _: &Drive<'_>, _: Conditions) -> crate::verdict::Outcome {
        crate::verdict::Outcome::silent()
    }

    fn guard(&mut self, _: &Drive<'_>, _: Conditions) -> crate::verdict::GuardResult {
        crate::verdict::GuardResult::new(&crate::verdict::GuardEvidence::default())
    }

    fn calibrate(&mut self, _: f32) -> Result<Mounting, ConfigError> {
        let (field, expected) = ("scene", "another one");
        Err(ConfigError { field, expected })
    }

    fn self_test(&mut self) -> bool {
        true
    }
}

/// A bench for one scan, with the shaft at rest near the sector.
pub struct Bench {
    world: Shared,
    pub ahead: bool,
    /// Whether chirps begin at the edge of TRIG.
    pub pin: bool,
    /// Number, from 0, of the trigger at which the module falls back to 1 Mbaud; `None`: it never does.
    pub reset_at: Option<u32>,
    /// Faults of answers by number of the trigger, from 0; all other triggers are answered.
    pub fates: BTreeMap<u32, Fate>,
    /// Durations of other work of the scanner, one every 401 polls, µs.
    pub busy_us: Vec<u32>,
    /// Whether the scanner sleeps between two polls, as long as [`Sweep::may_rest`] allows.
    pub sleeps: bool,
}

impl Bench {
    pub fn new(baud: u32) -> Self {
        let pulser = Pulser::new(Pin, Pin, Pin, 1_000_000 * MHZ as u32);
        let world = World {
            now: 0,
            pulser,
            next_step: None,
            way: Vec::new(),
            rates: [1, 1],
            fastest: (baud / 1_000_000) as u8,
            reset_at: None,
            ahead: true,
            pin: false,
            edge: None,
            without_edge: 0,
            chirp_us: 1_000,
            sending: 0,
            to_module: VecDeque::new(),
            answering: 0,
            to_scanner: VecDeque::new(),
            decoder: Decoder::new(),
            fates: BTreeMap::new(),
            triggers: 0,
            captures: Vec::new(),
            before: Vec::new(),
        };
        Self {
            world: Shared(Rc::new(RefCell::new(world))),
            ahead: true,
            pin: false,
            reset_at: None,
            fates: BTreeMap::new(),
            busy_us: Vec::new(),
            sleeps: false,
        }
    }

    pub fn set_chirp_us(&mut self, us: u32) {
        self.world.0.borrow_mut().chirp_us = us.into();
    }

    /// Makes one scan, from the first move to the end.
    pub fn scan(self, settings: &Settings, backward: bool) -> Outcome {
        let link = FrameLink::new(self.world.clone());
        self.scan_with(link, settings, backward)
    }

    /// Makes one scan with a chip on SPI instead of the serial module.
    pub fn scan_chip(self, settings: &Settings, backward: bool) -> Outcome {
        let link = SpiChip::new(&self.world);
        self.scan_with(link, settings, backward)
    }

    fn scan_with(self, mut link: impl RadarModule, settings: &Settings, backward: bool) -> Outcome {
        let mut mirror = self.world.clone();
        {
            let mut w = self.world.0.borrow_mut();
            w.fates = self.fates;
            w.ahead = self.ahead;
            w.pin = self.pin;
            w.reset_at = self.reset_at;
        }
        let schedule = Schedule::new(&settings.config).unwrap();
        // Near the start of the sweep, as after the previous scan.
        let nearly = match backward {
            false => schedule.position(0) - 70,
            true => schedule.position(schedule.rows() - 1) + 70,
        };
        {
            let mut w = self.world.0.borrow_mut();
            w.pulser.set_position(nearly);
            w.way.push((0, nearly));
        }
        let mut data = Data {
            world: self.world.clone(),
            schedule,
            samples: [Iq::default(); 200],
            rows: Vec::new(),
            lost: Vec::new(),
            mixed_up: 0,
        };
        let boot = Micros(u32::MAX - 100_000);
        let time = || boot.plus((self.world.0.borrow().now / MHZ) as u32);
        // State after the self-test.
        let timeout = settings.timing.configure_timeout;
        link.program(time(), &settings.module, timeout);
        while link.settings(time()).is_pending() {
            self.world.0.borrow_mut().advance(u64::from(SPARE) * MHZ);
        }
        let task = Task {
            number: 1,
            plane: settings.config.mount.plane.first(),
            guard: false,
            mirror_moving: false,
        };
        let (start, asked) = (time(), self.world.0.borrow().now);
        let began = Sweep::start(start, settings, task, backward, &mut mirror, &mut link);
        let mut sweep = began.unwrap();
        let (mut fired, mut polls) = (Vec::new(), 0_usize);
        let mut before = Rest::None;
        let fault = loop {
            let polled = sweep.poll(time(), &mut mirror, &mut link, &mut data);
            fired.extend(sweep.triggered().map(|(row, at)| (row, at.since(start))));
            if let Poll::Ready(rows) = polled {
                assert_eq!(usize::from(rows.lost), data.lost.len());
                break rows.fault;
            }
            assert!(
                !time().reached(sweep.deadline()),
                "deadline missed: {sweep:?}"
            );
            polls += 1;
            let busy = (polls % 401 == 400).then(|| self.busy_us.get(polls / 401 % 64));
            let extra = busy.flatten().copied().unwrap_or(0);
            let mut clocks = u64::from(SPARE + extra) * MHZ;
            let rest = sweep.may_rest(time(), &link);
            let mut w = self.world.0.borrow_mut();
            if self.sleeps
                && let Some(us) = rest.min(before).limit_us()
            {
                let limit = w.now + u64::from(us) * MHZ;
                let wakes = w.next_interrupt().map_or(limit, |at| at.min(limit));
                clocks = clocks.max(wakes - w.now);
            }
            before = rest;
            w.advance(clocks);
        };
        let w = self.world.0.borrow();
        let captured = w.captures.iter().map(|&(angle, begin, end)| Capture {
            wanted: crate::schedule::microsteps(angle),
            begin: w.place(begin),
            middle: w.place(u64::midpoint(begin, end)),
            end: w.place(end),
        });
        Outcome {
            fault,
            ms: (w.now - asked) as f64 / (1000.0 * MHZ as f64),
            captures: captured.collect(),
            rows: data.rows,
            lost: data.lost,
            mixed_up: data.mixed_up,
            fired,
            without_edge: w.without_edge,
            polls,
        }
    }
}
