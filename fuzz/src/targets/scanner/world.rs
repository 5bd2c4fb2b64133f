//! Everything outside the scanner, shared by the implementations of its traits.

use std::cell::RefCell;
use std::rc::Rc;

use stairscan::Iq;
use stairscan::answer::{Direction, Step};
use stairscan::config::{Config, ConfigError, MAX_SAMPLES, RadarConfig};
use stairscan::estimate::Estimate;
use stairscan::motion::Drive;
use stairscan::mount::Mounting;
use stairscan::scanner::encoder::{AngleEncoder, EncoderError};
use stairscan::scanner::settings::MotorConfig;
use stairscan::scanner::{DataPath, MICROSTEPS_PER_TURN};
use stairscan::signal::radar::frame::Ability;
use stairscan::verdict::{
    Conditions, Evidence, FreeGround, GuardEvidence, GuardResult, HazardKind, MotionQuality,
    Outcome,
};
use testbed::port::{Device, Wires};
use testbed::{AnswerFault, FramedModule, Motor, Pace};

/// Settings of the module: few samples, so that a scan is short.
pub const RADAR: RadarConfig = RadarConfig {
    carrier_khz: 94_000_000,
    bandwidth_khz: 3_200_000,
    samples: 64,
    real: false,
};
/// Motion of the shaft in a step, microsteps.
const WAY: u32 = 4_000;
/// Mechanical limits of the shaft, microsteps from the switch; pulses beyond them are lost.
const ENDS: (i32, i32) = (-600, 49_000);

/// Returns the fault of the module's answers for a byte; `None`: normal answers.
pub fn fault(byte: u8) -> Option<AnswerFault> {
    const ALL: [Option<AnswerFault>; 10] = [
        None,
        Some(AnswerFault::Lost),
        Some(AnswerFault::Error),
        Some(AnswerFault::Corrupt),
        Some(AnswerFault::Stale),
        Some(AnswerFault::Short),
        Some(AnswerFault::Other),
        Some(AnswerFault::Changed),
        Some(AnswerFault::Absurd),
        Some(AnswerFault::Babbling),
    ];
    ALL[usize::from(byte) % ALL.len()]
}

/// Motor and arithmetic.
pub struct World {
    pub motor: testbed::Shared<Motor>,
    pub encoder: u8,
    // The data path.
    pub broken: bool,
    pub verdict: u8,
}

impl World {
    pub fn new() -> Self {
        let mut motor = Motor::at(9_000, Pace::ByTurn);
        motor.ends = Some(ENDS);
        Self {
            motor: testbed::Shared::new(motor),
            encoder: 0,
            broken: false,
            verdict: 0,
        }
    }

    /// Removes all faults.
    pub fn heal(&mut self) {
        let mut motor = self.motor.get();
        (motor.stalled, motor.jammed, motor.switch_works) = (false, false, true);
        self.broken = false;
        (self.encoder, self.verdict) = (0, 0);
    }

    /// Turns the shaft for the time of one step.
    pub fn turn(&mut self) {
        self.motor.get().turn(WAY);
    }
}

/// Shared environment that implements one of the scanner's traits.
#[derive(Clone)]
pub struct Shared(pub Rc<RefCell<World>>);

impl AngleEncoder for Shared {
    fn angle(&mut self) -> Result<u16, EncoderError> {
        let w = self.0.borrow();
        let off = match w.encoder {
            1 => return Err(EncoderError::Silent),
            2 => return Err(EncoderError::NoMagnet),
            off => 20 * u16::from(off),
        };
        let seen = i64::from(w.motor.get().place) * 65_536 / i64::from(MICROSTEPS_PER_TURN);
        Ok((seen as u16).wrapping_add(off))
    }
}

/// The module at the other end of its serial port, with checks of when it is triggered.
pub struct Module {
    pub framed: FramedModule,
    world: Shared,
}

impl Module {
    pub fn new(world: &Shared) -> Self {
        Self {
            framed: FramedModule::new(RADAR, Ability::NONE, 0),
            world: world.clone(),
        }
    }
}

impl Device for Module {
    fn receive(&mut self, byte: u8, at: u64, wires: &mut Wires) {
        let triggers = self.framed.triggers;
        self.framed.receive(byte, at, wires);
        if self.framed.triggers > triggers {
            let w = self.world.0.borrow();
            let motor = w.motor.get();
            let still = motor.position == motor.target;
            // A continuous sweep is slower than other moves.
            let sweeping = motor.ramp.speed < MotorConfig::default().speed;
            assert!(still || sweeping, "fired while the mirror turns");
            assert!(motor.enabled, "fired without a driver");
        }
    }
}

/// A data path that only records its rows.
pub struct Rows {
    world: Shared,
    samples: [Iq; MAX_SAMPLES],
    count: usize,
    /// Rows that are final: received or lost.
    row_done: Vec<bool>,
}

impl Rows {
    pub fn new(world: Shared) -> Self {
        Self {
            world,
            samples: [Iq::default(); MAX_SAMPLES],
            count: 0,
            row_done: Vec::new(),
        }
    }

    fn see(&mut self, row: u16) {
        let seen = &mut self.row_done[usize::from(row)];
        assert!(!*seen, "row {row} comes twice");
        *seen = true;
    }
}

impl DataPath for Rows {
    fn begin(&mut self, config: &Config, _: u32) -> Result<(), ConfigError> {
        config.validate()?;
        self.count = config.radar.samples.into();
        self.row_done = vec![false; config.sweep.angle_count.into()];
        Ok(())
    }

    fn begin_guard(&mut self, config: &Config, sweep: u32) -> Result<(), ConfigError> {
        self.begin(config, sweep)
    }

    fn samples(&mut self) -> &mut [Iq] {
        &mut self.samples[..self.count]
    }

    fn row(&mut self, row: u16) {
        self.see(row);
    }

    fn lost(&mut self, row: u16) {
        self.see(row);
    }

    fn conclude(&mut self, _: &Drive<'_>, conditions: Conditions) -> Outcome {
        assert!(
            self.row_done.iter().all(|&seen| seen),
            "concluded without all rows"
        );
        let mut sight = testbed::sure();
        let mut outcome = Outcome::silent();
        match self.world.0.borrow().verdict % 3 {
            0 => {}
            1 => sight.echo_found = false,
            _ => {
                outcome.answer.direction = Direction::Up;
                while outcome.answer.steps.push(Step::default()).is_ok() {}
            }
        }
        outcome.decide(&Evidence {
            conditions,
            assessment: Some(sight),
            ..Evidence::default()
        });
        outcome
    }

    fn guard(&mut self, drive: &Drive<'_>, conditions: Conditions) -> GuardResult {
        assert!(
            self.row_done.iter().all(|&seen| seen),
            "a guard's word without all rows"
        );
        let ground = FreeGround {
            free_m: 0.9,
            hazard: HazardKind::Rise,
            confidence: 0.999,
        };
        let verdict = self.world.0.borrow().verdict;
        GuardResult::new(&GuardEvidence {
            echo_found: verdict % 3 != 1,
            motion: MotionQuality::of(drive),
            conditions,
            ground: Some(ground).filter(|_| !verdict.is_multiple_of(3)),
            ..GuardEvidence::default()
        })
    }

    fn calibrate(&mut self, wall_m: f32) -> Result<Mounting, ConfigError> {
        assert!(
            self.row_done.iter().all(|&seen| seen),
            "calibrated without all rows"
        );
        match self.world.0.borrow().verdict % 3 {
            0 => Ok(Mounting {
                mirror_level_db: -30.0,
                height_m: Estimate::new(wall_m, 1e-3),
                offset_rad: Estimate::new(0.1 * wall_m, 1e-3),
                scale: Estimate::new(1.0, 1e-3),
                mirror_echo_m: Estimate::new(0.1 * wall_m, 1e-3),
                floor_echoes: 5,
            }),
            _ => Err(ConfigError {
                field: "scene",
                expected: "another one",
            }),
        }
    }

    fn self_test(&mut self) -> bool {
        !self.world.0.borrow().broken
    }
}
