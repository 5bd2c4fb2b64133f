//! What stands before the scanner: a recording that can be exchanged, and what goes wrong with module and
//! mirror while it is scanned.

use std::cell::RefCell;
use std::collections::{BTreeSet, VecDeque};
use std::rc::Rc;
use std::task::Poll;

use anyhow::{Result, anyhow};
use stairscan::Iq;
use stairscan::config::{Config, RadarConfig};
use stairscan::scanner::settings::MotorConfig;
use stairscan::scanner::{BytePort, Micros, Mirror, MirrorError, Motion, Settings};
use stairscan::signal::radar::module::RequestedSettings;
use stairscan::signal::radar::{LinkError, RadarModule};

use crate::playback::{SimShaft, row_at};
use crate::recording::{META_SUFFIX, Recording};
use crate::setup;

/// A scan's chirps by row.
pub struct Reel {
    /// Of which recording.
    pub name: String,
    /// What that brings.
    pub config: Config,
    chirps: Vec<Option<Vec<Iq>>>,
}

impl Reel {
    /// The first scan of `recording`.
    ///
    /// # Errors
    /// Names what in the recording no scan can be made of.
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

    /// The chirp of row `row`.
    pub fn chirp(&self, row: usize) -> Option<&[Iq]> {
        self.chirps.get(row)?.as_deref()
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.chirps.len()
    }
}

/// What goes wrong with one scan.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// Rows whose chirps never come.
    pub lost: BTreeSet<usize>,
    /// From the row of this place in the scan's order on, no chirp comes.
    pub silent_from: Option<usize>,
    /// At the row of this place the motor stalls, once.
    pub stalls_at: Option<usize>,
}

/// Module, mirror and report port.
pub struct Stage {
    /// What is scanned.
    pub reel: Rc<Reel>,
    /// What goes wrong with the present scan, and with the next one.
    pub plan: Plan,
    /// The rows of the present scan in their order, and whether their chirps came.
    pub shown: Vec<(usize, bool)>,
    /// What is typed.
    pub typed: VecDeque<u8>,
    /// What was said, up to the last whole line.
    pub printed: Vec<u8>,
    /// Whether a scan has been asked for and no chirp of it yet.
    asked: bool,
}

impl Stage {
    /// Before the first scan of `reel`.
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

    /// The chirp of `row`, if it comes.
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

/// One of the scanner's traits over the stage.
#[derive(Clone)]
pub struct Shared(pub Rc<RefCell<Stage>>);

/// The module's link.
pub struct Link {
    stage: Shared,
    shaft_angle: i32,
}

impl Link {
    /// The link to the stage's module.
    pub fn new(stage: Shared) -> Self {
        Self {
            stage,
            shaft_angle: 0,
        }
    }
}

impl RadarModule for Link {
    fn program(&mut self, _: Micros, _: &RequestedSettings, _: u32) {
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

/// The shaft, which may stall.
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
