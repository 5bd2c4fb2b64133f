//! Simulation of mirror shaft, serial wire and radar module on one clock.

use std::cell::RefCell;
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
use crate::scanner::mirror::MirrorError;
use crate::scanner::pulser::Pulser;
use crate::scanner::settings::MotorConfig;
use crate::signal::radar::FrameLink;
use crate::signal::radar::frame::Ability;
use crate::testing;
use crate::testing::framed::{FramedModule, RATES};
use crate::verdict::Conditions;

/// Core clocks in a microsecond.
pub const MHZ: u64 = 168;
/// Time between two polls of the sweep, µs.
pub const SPARE: u32 = 5;
/// Time for which the simulated data path processes a row, µs.
const WORK: u64 = 150;
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
    /// Serial wire, and the radar module at its other end.
    pub port: Port,
}

/// Serial port of the scanner, with the module.
type Port = testing::shared::Shared<testing::port::Port<FramedModule>>;

impl World {
    fn advance(&mut self, by: u64) {
        self.now += by;
        while let Some(at) = self.next_step.filter(|&at| at <= self.now) {
            let ticks = self.pulser.tick();
            self.way.push((at, self.pulser.position()));
            self.next_step = ticks.map(|ticks| at + u64::from(ticks));
        }
        self.port.get().advance(self.now);
    }

    /// Returns the time of the next interrupt, by a motor step or a received byte, core clocks.
    fn next_interrupt(&self) -> Option<u64> {
        let arrival = self.port.get().wires.next_arrival(self.now);
        let step = self.next_step.filter(|&at| at > self.now);
        arrival.into_iter().chain(step).min()
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

#[derive(Clone)]
pub struct Shared(pub Rc<RefCell<World>>);

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
    /// Durations of other work of the scanner, one every 401 polls, µs.
    pub busy_us: Vec<u32>,
    /// Whether the scanner sleeps between two polls, as long as [`Sweep::may_rest`] allows.
    pub sleeps: bool,
}

impl Bench {
    pub fn new(baud: u32) -> Self {
        let ability = Ability {
            fastest: (baud / 1_000_000) as u8,
            ahead: true,
            pin: false,
            adds: true,
        };
        let module = FramedModule::new(RadarConfig::default(), ability, 0);
        let mut port = testing::port::Port::new(module);
        port.wires.ticks = Some(1_000_000 * MHZ);
        port.wires.lags = true;
        port.wires.supported = RATES;
        let world = World {
            now: 0,
            pulser: Pulser::new(Pin, Pin, Pin, 1_000_000 * MHZ as u32),
            next_step: None,
            way: Vec::new(),
            port: testing::shared::Shared::new(port),
        };
        Self {
            world: Shared(Rc::new(RefCell::new(world))),
            busy_us: Vec::new(),
            sleeps: false,
        }
    }

    /// Changes the radar module, such as by a fault.
    pub fn module(&mut self, change: impl FnOnce(&mut FramedModule)) {
        change(&mut self.world.0.borrow().port.get().device);
    }

    /// Makes one scan, from the first move to the end.
    pub fn scan(self, settings: &Settings, backward: bool) -> Outcome {
        let link = FrameLink::new(self.world.0.borrow().port.clone());
        self.scan_with(link, settings, backward)
    }

    /// Makes one scan with a chip on SPI instead of the serial module.
    pub fn scan_chip(self, settings: &Settings, backward: bool) -> Outcome {
        let link = SpiChip::new(&self.world);
        self.scan_with(link, settings, backward)
    }

    fn scan_with(self, mut link: impl RadarModule, settings: &Settings, backward: bool) -> Outcome {
        let mut mirror = self.world.clone();
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
        let port = w.port.get();
        let module = &port.device;
        let captured = module.captures.iter().map(|chirp| Capture {
            wanted: crate::schedule::microsteps(chirp.angle),
            begin: w.place(chirp.begin),
            middle: w.place(u64::midpoint(chirp.begin, chirp.end)),
            end: w.place(chirp.end),
        });
        Outcome {
            fault,
            ms: (w.now - asked) as f64 / (1000.0 * MHZ as f64),
            captures: captured.collect(),
            rows: data.rows,
            lost: data.lost,
            mixed_up: data.mixed_up,
            fired,
            without_edge: module.without_edge,
            polls,
        }
    }
}
