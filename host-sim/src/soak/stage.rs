//! Simulated environment of the scanner: an exchangeable recording, and disturbances of module and mirror
//! during a scan.

use std::cell::RefCell;
use std::collections::{BTreeSet, VecDeque};
use std::rc::Rc;
use std::task::Poll;

use anyhow::{Result, anyhow};
use stairscan::Iq;
use stairscan::config::{Config, RadarConfig};
use stairscan::scanner::settings::MotorConfig;
use stairscan::scanner::{BytePort, Micros, Mirror, MirrorError, Motion, Settings};
use stairscan::signal::radar::module::Wish;
use stairscan::signal::radar::{LinkError, RadarModule};

use crate::playback::{SimShaft, row_at};
use crate::recording::{META_SUFFIX, Recording};
use crate::setup;

/// A scan's chirps by row.
pub struct Reel {
    /// Name of the recording.
    pub name: String,
    /// Configuration of the recording.
    pub config: Config,
    chirps: Vec<Option<Vec<Iq>>>,
}

impl Reel {
    /// From the first scan of `recording`.
    ///
    /// # Errors
    /// The recording cannot be scanned; the message names the cause.
    pub fn new(recording: &Recording, base: &Config) -> Result<Self> {
        setup::full_scans(recording)?;
        let (config, schedule) = setup::config(recording, 0, base)?;
        let settings = Settings {
            config,
            ..Settings::default()
        };
        settings
            .validate()
            .map_err(|e| anyhow!("{}.{META_SUFFIX}: {e}", recording.name))?;
        let chirp =
            |slot: &Option<usize>| slot.and_then(|k| recording.chirp(k)).map(<[Iq]>::to_vec);
        Ok(Self {
            name: recording.name.clone(),
            config,
            chirps: schedule.chirps.iter().map(chirp).collect(),
        })
    }

    /// Returns the chirp of a row.
    pub fn chirp(&self, row: usize) -> Option<&[Iq]> {
        self.chirps.get(row)?.as_deref()
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.chirps.len()
    }
}

/// Disturbances of one scan.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// Rows whose chirps are lost.
    pub lost: BTreeSet<usize>,
    /// Position in the scan's order from which on no chirp is delivered.
    pub silent_from: Option<usize>,
    /// Position in the scan's order at which the motor stalls once.
    pub stalls_at: Option<usize>,
}

/// Module, mirror and report port.
pub struct Stage {
    /// The recording that is scanned.
    pub reel: Rc<Reel>,
    /// Disturbances of the current scan, and of the next one.
    pub plan: Plan,
    /// Rows of the current scan in their order, and whether their chirps were delivered.
    pub shown: Vec<(usize, bool)>,
    /// Input bytes of the report port.
    pub typed: VecDeque<u8>,
    /// Output of the report port up to the last complete line.
    pub printed: Vec<u8>,
    /// Whether a scan has been requested but no chirp of it yet.
    asked: bool,
}

impl Stage {
    /// The state before the first scan of `reel`.
    pub fn new(reel: Rc<Reel>) -> Self {
        Self {
            reel,
            plan: Plan::default(),
            shown: Vec::new(),
            typed: VecDeque::new(),
            printed: Vec::new(),
            asked: true,
        }
    }

    /// Returns the chirp of `row` unless it is lost.
    fn show(&mut self, row: usize) -> Option<&[Iq]> {
        if self.shown.last().is_none_or(|&(last, _)| last != row) {
            self.shown.push((row, false));
        }
        let place = self.shown.len() - 1;
        let silent = self.plan.silent_from.is_some_and(|from| place >= from);
        if silent || self.plan.lost.contains(&row) {
            return None;
        }
        let chirp = self.reel.chirp(row)?;
        self.shown[place].1 = true;
        Some(chirp)
    }
}

/// Shared stage that implements one of the scanner's traits.
#[derive(Clone)]
pub struct Shared(pub Rc<RefCell<Stage>>);

/// Link to the simulated module.
pub struct Link {
    stage: Shared,
    shaft_angle: i32,
}

impl Link {
    /// A link to the stage's module.
    pub fn new(stage: Shared) -> Self {
        Self {
            stage,
            shaft_angle: 0,
        }
    }
}

impl RadarModule for Link {
    fn program(&mut self, _: Micros, _: &Wish, _: u32) {
        self.stage.0.borrow_mut().asked = true;
    }

    fn settings(&mut self, _: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        Poll::Ready(Ok(self.stage.0.borrow().reel.config.radar))
    }

    fn trigger(&mut self, _: Micros, shaft_angle: i32, _: u32) {
        self.shaft_angle = shaft_angle;
        let mut stage = self.stage.0.borrow_mut();
        if std::mem::take(&mut stage.asked) {
            stage.shown.clear();
        }
    }

    fn poll(&mut self, _: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        let mut stage = self.stage.0.borrow_mut();
        let row = row_at(&stage.reel.config, self.shaft_angle);
        Poll::Ready(match row.and_then(|row| stage.show(row)) {
            Some(chirp) if chirp.len() == samples.len() => {
                samples.copy_from_slice(chirp);
                Ok(())
            }
            Some(_) => Err(LinkError::Answer),
            None => Err(LinkError::Timeout),
        })
    }
}

/// Simulated shaft that may stall.
pub struct Shaft {
    shaft: SimShaft,
    stage: Shared,
}

impl Shaft {
    /// The stage's shaft.
    pub fn new(stage: Shared) -> Self {
        Self {
            shaft: SimShaft::default(),
            stage,
        }
    }
}

impl Mirror for Shaft {
    fn start_home(&mut self, motor: &MotorConfig) {
        self.shaft.start_home(motor);
    }

    fn start_move(&mut self, position: i32, motor: &MotorConfig) {
        self.shaft.start_move(position, motor);
    }

    fn poll(&mut self, now: Micros) -> Result<Motion, MirrorError> {
        let mut stage = self.stage.0.borrow_mut();
        let place = stage.shown.len();
        if !stage.asked && stage.plan.stalls_at.is_some_and(|at| place >= at) {
            stage.plan.stalls_at = None;
            self.shaft.disable();
            return Err(MirrorError::Stall);
        }
        self.shaft.poll(now)
    }

    fn position(&self) -> i32 {
        self.shaft.position()
    }

    fn homed(&self) -> bool {
        self.shaft.homed()
    }

    fn disable(&mut self) {
        self.shaft.disable();
    }
}

impl BytePort for Shared {
    fn read(&mut self) -> Option<u8> {
        self.0.borrow_mut().typed.pop_front()
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        self.0.borrow_mut().printed.extend(bytes);
        bytes.len()
    }
}
