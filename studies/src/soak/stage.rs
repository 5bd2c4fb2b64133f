//! Simulated environment of the scanner: an exchangeable recording, and disturbances of module and mirror
//! during a scan.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::rc::Rc;

use anyhow::anyhow;
use stairscan::Iq;
use stairscan::config::{Config, RadarConfig};
use stairscan::scanner::settings::MotorConfig;
use stairscan::scanner::{Micros, Mirror, MirrorError, Motion, Settings};
use stairscan::signal::radar::LinkError;
use testbed::Echoes;

use host_sim::playback::{SimShaft, deliver, row_at};
use host_sim::recording::{META_SUFFIX, Recording};
use host_sim::setup;

/// The chirps of one scan of a recording, by row, and the scanner's configuration for them.
pub struct ScanChirps {
    /// Name of the recording.
    pub name: String,
    /// The scanner's configuration for the recording.
    pub config: Config,
    chirps: Vec<Option<Vec<Iq>>>,
}

impl ScanChirps {
    /// Takes the chirps of the first scan of `recording`, and the configuration from `base` and the recording.
    ///
    /// # Errors
    /// The recording cannot be scanned; the message names the cause.
    pub fn new(recording: &Recording, base: &Config) -> anyhow::Result<Self> {
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

    /// Returns the samples of the chirp of row `row`; `None` if the recording has none.
    pub fn chirp(&self, row: usize) -> Option<&[Iq]> {
        self.chirps.get(row)?.as_deref()
    }

    /// Returns the number of rows of a scan.
    pub fn rows(&self) -> usize {
        self.chirps.len()
    }
}

/// Disturbances of one scan.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// Indices of the rows whose chirps are lost.
    pub lost: BTreeSet<usize>,
    /// Number of rows, in the scan's order, after which the module delivers no chirp; `None`: it never falls silent.
    pub silent_from: Option<usize>,
    /// Number of rows, in the scan's order, after which the motor stalls once; `None`: it does not.
    pub stalls_at: Option<usize>,
}

/// Simulated radar module and mirror of one scanner.
pub struct Environment {
    /// The recording that is scanned.
    pub chirps: Rc<ScanChirps>,
    /// Disturbances of the current scan, or, after its report, of the next one.
    pub plan: Plan,
    /// Row indices of the current scan in the order of measurement, each with whether its chirp was delivered.
    pub shown: Vec<(usize, bool)>,
    /// Whether the module has been programmed for a scan of which no chirp has been requested yet.
    asked: bool,
}

impl Environment {
    /// Creates the environment before the first scan of the recording `chirps`.
    pub fn new(chirps: Rc<ScanChirps>) -> Self {
        Self {
            chirps,
            plan: Plan::default(),
            shown: Vec::new(),
            asked: true,
        }
    }

    /// Notes that the module measures `row`, and returns its chirp; `None` if it is lost.
    fn show(&mut self, row: usize) -> Option<&[Iq]> {
        if self.shown.last().is_none_or(|&(last, _)| last != row) {
            self.shown.push((row, false));
        }
        let place = self.shown.len() - 1;
        let silent = self.plan.silent_from.is_some_and(|from| place >= from);
        if silent || self.plan.lost.contains(&row) {
            return None;
        }
        let chirp = self.chirps.chirp(row)?;
        self.shown[place].1 = true;
        Some(chirp)
    }
}

/// Shared environment of module and mirror.
#[derive(Clone)]
pub struct Shared(pub Rc<RefCell<Environment>>);

impl Echoes for Shared {
    fn radar(&self) -> Option<RadarConfig> {
        Some(self.0.borrow().chirps.config.radar)
    }

    fn programmed(&mut self) {
        self.0.borrow_mut().asked = true;
    }

    fn triggered(&mut self, _: i32) {
        let mut stage = self.0.borrow_mut();
        if std::mem::take(&mut stage.asked) {
            stage.shown.clear();
        }
    }

    fn chirp(&mut self, shaft_angle: i32, samples: &mut [Iq]) -> Result<(), LinkError> {
        let mut stage = self.0.borrow_mut();
        let row = row_at(&stage.chirps.config, shaft_angle);
        deliver(row.and_then(|row| stage.show(row)), samples)
    }
}

/// Simulated shaft of the mirror, which stalls where the scan's plan says so.
pub struct Shaft {
    shaft: SimShaft,
    stage: Shared,
}

impl Shaft {
    /// Creates the shaft of `stage`.
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
