//! Simulated hardware with fault injection, and a scanner on it.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use stairscan::Iq;
use stairscan::answer::DropEdge;
use stairscan::config::{Config, ConfigError, Plane};
use stairscan::motion::{Drive, Odometry};
use stairscan::mount::Mounting;
use stairscan::report::{ScanLine, Sentence};
use stairscan::scanner::command::framed;
use stairscan::scanner::settings::{MotorConfig, SweepMode};
use stairscan::scanner::{
    BoardHealth, BootInfo, DataPath, Hardware, LentParts, Micros, Mirror, MirrorError, Motion,
    Scanner, SecondMemory, Settings,
};
use stairscan::signal::radar::LinkError;
use stairscan::verdict::{
    Conditions, Evidence, FreeGround, GuardEvidence, GuardResult, MotionQuality, Outcome,
};
use testbed::{Board, Echoes, Module, Port};

/// Everything outside the scanner, shared between the implementations of its traits and the test.
#[derive(Default)]
pub struct World {
    /// Report port, which takes a few bytes at once.
    pub port: testbed::Shared<Port>,
    pub board: testbed::Shared<Board>,
    /// Result of a calibration.
    pub mounting: Option<Mounting>,
    // Mirror.
    pub homed: bool,
    pub enabled: bool,
    /// Number of polls until the current move ends.
    pub moving: Rc<Cell<u32>>,
    /// Target of a continuous sweep.
    pub passing: Option<i32>,
    pub position: i32,
    pub stall: bool,
    pub no_home: bool,
    /// The radar module.
    pub module: testbed::Shared<Module<Watched>>,
    // Data.
    pub rows: Vec<u16>,
    pub lost: Vec<u16>,
    pub begun: Vec<u32>,
    /// Plane of each scan at its beginning.
    pub planes: Vec<Plane>,
    /// Distance at which the depth plane detects a drop, metres.
    pub drop_m: Option<f32>,
    /// Result of the guard's inference.
    pub ground: Option<FreeGround>,
    pub arithmetic_broken: bool,
    pub row_worked_while_still: bool,
}

impl World {
    /// Lets the report port take nothing, or a few bytes at once.
    pub fn stick_port(&mut self, stuck: bool) {
        self.port.get().wires.room = if stuck { 0 } else { 7 };
    }
}

/// Motion of a continuous sweep between two polls, microsteps.
const PASSED: i32 = 3;

#[derive(Clone)]
pub struct Shared(pub Rc<RefCell<World>>);

impl Mirror for Shared {
    fn start_home(&mut self, _: &MotorConfig) {
        let mut w = self.0.borrow_mut();
        (w.enabled, w.homed, w.position) = (true, true, -23_467);
        w.moving.set(5);
        w.passing = None;
    }
    fn start_move(&mut self, position: i32, motor: &MotorConfig) {
        let mut w = self.0.borrow_mut();
        assert!(w.enabled && w.homed, "moved without a driver or a home");
        if motor.speed < MotorConfig::default().speed {
            w.passing = Some(position);
        } else {
            w.position = position;
            w.moving.set(3);
        }
    }
    fn poll(&mut self, _: Micros) -> Result<Motion, MirrorError> {
        let mut w = self.0.borrow_mut();
        if w.stall {
            (w.homed, w.enabled) = (false, false);
            return Err(MirrorError::Stall);
        }
        if w.no_home {
            w.homed = false;
            return Err(MirrorError::HomeNotFound);
        }
        w.moving.set(w.moving.get().saturating_sub(1));
        if let Some(end) = w.passing {
            let way = end - w.position;
            w.position += way.clamp(-PASSED, PASSED);
            if way != 0 {
                return Ok(Motion::Moving);
            }
            w.passing = None;
        }
        Ok(if w.moving.get() > 0 {
            Motion::Moving
        } else {
            Motion::Still
        })
    }
    fn position(&self) -> i32 {
        self.0.borrow().position
    }
    fn homed(&self) -> bool {
        self.0.borrow().homed
    }
    fn disable(&mut self) {
        let mut w = self.0.borrow_mut();
        (w.homed, w.enabled) = (false, false);
    }
}

/// The test's view of the radar module's chirps.
#[derive(Default)]
pub struct Watched {
    moving: Rc<Cell<u32>>,
    pub triggers: Vec<i32>,
}

impl Echoes for Watched {
    fn triggered(&mut self, shaft_angle: i32) {
        assert_eq!(self.moving.get(), 0, "triggered while moving");
        self.triggers.push(shaft_angle);
    }

    fn chirp(&mut self, _: i32, samples: &mut [Iq]) -> Result<(), LinkError> {
        assert_eq!(samples.len(), 200);
        Ok(())
    }
}

pub struct Data(Shared, [Iq; 200]);

impl DataPath for Data {
    fn begin(&mut self, config: &Config, scan: u32) -> Result<(), ConfigError> {
        assert_eq!(Some(config.radar), self.0.0.borrow().module.get().radar);
        let mut w = self.0.0.borrow_mut();
        w.begun.push(scan);
        w.planes.push(config.mount.plane.first());
        Ok(())
    }
    fn begin_guard(&mut self, config: &Config, sweep: u32) -> Result<(), ConfigError> {
        self.begin(config, sweep)
    }
    fn samples(&mut self) -> &mut [Iq] {
        &mut self.1
    }
    fn row(&mut self, row: u16) {
        let mut w = self.0.0.borrow_mut();
        // Only the last row of a sweep may be processed without a simultaneous move.
        let last = (w.rows.len() + w.lost.len()) % 281 == 280;
        w.row_worked_while_still |= w.moving.get() == 0 && w.passing.is_none() && !last;
        w.rows.push(row);
    }
    fn lost(&mut self, row: u16) {
        self.0.0.borrow_mut().lost.push(row);
    }
    fn conclude(&mut self, _: &Drive<'_>, conditions: Conditions) -> Outcome {
        let sight = testbed::sure();
        let mut outcome = Outcome::silent();
        let w = self.0.0.borrow();
        let seen = w.planes.last() == Some(&Plane::Depth);
        outcome.answer.drop = w.drop_m.filter(|_| seen).map(|distance_m| DropEdge {
            distance_m,
            distance_sigma_m: 0.01,
            depth_m: None,
            probability: 0.99,
        });
        outcome.decide(&Evidence {
            conditions,
            assessment: Some(sight),
            ..Evidence::default()
        });
        outcome
    }
    fn guard(&mut self, drive: &Drive<'_>, conditions: Conditions) -> GuardResult {
        GuardResult::new(&GuardEvidence {
            echo_found: true,
            motion: MotionQuality::of(drive),
            conditions,
            ground: self.0.0.borrow().ground,
            ..GuardEvidence::default()
        })
    }
    fn calibrate(&mut self, wall_m: f32) -> Result<Mounting, ConfigError> {
        self.0.0.borrow().mounting.map_or(
            Err(ConfigError {
                field: "scene",
                expected: "a wall",
            }),
            |found| {
                assert_eq!(wall_m, 1.5);
                Ok(found)
            },
        )
    }
    fn self_test(&mut self) -> bool {
        !self.0.0.borrow().arithmetic_broken
    }
}

/// Hardware of the scanner under test, with any mirror.
type Parts<M> =
    Hardware<M, testbed::Shared<Module<Watched>>, testbed::Shared<Port>, testbed::Shared<Board>>;

pub struct Bench<M: Mirror = Shared> {
    pub world: Shared,
    pub scanner: Scanner<'static, (Parts<M>, Data)>,
    pub now: Micros,
}

pub const IDENTITY: BootInfo = BootInfo {
    version: "1.2.3",
    revision: "abcdef",
    reset: "power-on",
    clock: "hsi-16",
    boots: 3,
    serial: [0x0012_3456, 0x789a_bcde, 0xf012_3456],
    second_memory: SecondMemory::Unknown,
    option_bytes: None,
    cause: None,
    crash_loop: false,
    health: BoardHealth::GOOD,
};

impl Bench {
    /// A scanner with saved settings: the defaults, but it stops at every angle.
    pub fn new(prepare: impl FnOnce(&mut World)) -> Self {
        let settings = Settings {
            sweep_mode: SweepMode::Stop,
            ..Settings::default()
        };
        Self::boot(Some(settings), IDENTITY, prepare)
    }

    /// A scanner with the settings `saved` in its flash.
    pub fn boot(
        saved: Option<Settings>,
        identity: BootInfo,
        prepare: impl FnOnce(&mut World),
    ) -> Self {
        Self::over(Shared::clone, saved, identity, prepare)
    }

    /// Resets the chip. Flash, and memory that a reset does not clear, keep their contents.
    pub fn reset(self) -> Self {
        let old = self.world.0.take();
        let saved = old.board.get().load();
        Self::boot(saved, IDENTITY, |w| w.board = old.board)
    }
}

impl<M: Mirror> Bench<M> {
    /// A scanner with another mirror.
    pub fn over(
        mirror: impl FnOnce(&Shared) -> M,
        saved: Option<Settings>,
        identity: BootInfo,
        prepare: impl FnOnce(&mut World),
    ) -> Self {
        let mut world = World::default();
        world.module.get().echoes.moving = Rc::clone(&world.moving);
        world.stick_port(false);
        world.board.get().measured = 4321;
        prepare(&mut world);
        let world = Shared(Rc::new(RefCell::new(world)));
        let hardware = Hardware {
            mirror: mirror(&world),
            link: world.0.borrow().module.clone(),
            port: world.0.borrow().port.clone(),
            board: world.0.borrow().board.clone(),
        };
        // Leaked: the scanner borrows them for the whole test.
        let data = Data(world.clone(), [Iq::default(); 200]);
        let now = Micros(u32::MAX - 1_000_000);
        let lent = LentParts {
            reports: Box::leak(Box::default()),
            odometry: Box::leak(Box::new(Odometry::new())),
        };
        let scanner = Scanner::new(hardware, data, lent, saved, identity, now);
        Self {
            world,
            scanner,
            now,
        }
    }

    pub fn step(&mut self) {
        self.scanner.step(self.now);
        self.now = self.now.plus(1000);
        let healthy = self.scanner.healthy(self.now);
        assert!(healthy, "deadline missed in {}", self.scanner.state());
    }

    pub fn take_lines(&mut self) -> Vec<String> {
        self.world.0.borrow().port.get().take_lines()
    }

    /// Runs steps until a sentence satisfies `wanted`; returns everything printed up to it.
    pub fn until(&mut self, wanted: impl Fn(&Sentence<'_>) -> bool) -> Vec<String> {
        let mut lines = Vec::new();
        for _ in 0..40_000 {
            self.step();
            lines.extend(self.take_lines());
            if lines.iter().any(|l| wanted(&Sentence::parse(l).unwrap())) {
                return lines;
            }
        }
        panic!(
            "never came; state {}, lines {lines:#?}",
            self.scanner.state()
        );
    }

    pub fn scan(&mut self) -> ScanLine {
        let lines = self.until(|s| matches!(s, Sentence::Scan(_)));
        lines
            .iter()
            .find_map(|line| match Sentence::parse(line) {
                Ok(Sentence::Scan(scan)) => Some(scan),
                _ => None,
            })
            .unwrap()
    }

    pub fn type_line(&mut self, line: &str) {
        let world = self.world.0.borrow();
        world.port.get().type_in(format!("{line}\r\n"));
    }

    /// Sends a command as a sentence; returns its reply.
    pub fn send(&mut self, command: &str) -> String {
        let framed = framed(&command.split(',').collect::<Vec<_>>());
        self.ask(framed.trim_end())
    }

    /// Sends a line; returns the one sentence that replies to it.
    pub fn ask(&mut self, line: &str) -> String {
        self.type_line(line);
        let is_answer = |s: &Sentence<'_>| {
            !matches!(
                s,
                Sentence::Scan(_)
                    | Sentence::Step(_)
                    | Sentence::Guard(_)
                    | Sentence::Boot { .. }
                    | Sentence::Live(_)
            )
        };
        let lines = self.until(is_answer);
        let answers: Vec<String> = lines
            .into_iter()
            .filter(|l| is_answer(&Sentence::parse(l).unwrap()))
            .collect();
        assert_eq!(answers.len(), 1, "{answers:?}");
        let body = answers[0].trim_start_matches("$PSTR,");
        body.rsplit_once('*').unwrap().0.into()
    }
}
