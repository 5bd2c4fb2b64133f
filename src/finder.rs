//! The map and the estimators that read it, in one block of memory.

use crate::answer::Answer;
use crate::config::{Config, ConfigError, EstimatorKind};
use crate::drive::Drive;
use crate::estimator::{Estimator, MappedScan};
use crate::guard::Guard;
use crate::infer::Likelihood;
use crate::infer::past::History;
use crate::observer::Observer;
#[cfg(feature = "paper")]
use crate::paper::Paper;
use crate::params::current;
use crate::signal::echoes::Echo;
use crate::signal::grid::{PolarMap, Row};
use crate::verdict::{FreeGround, Sight};

/// What one estimator keeps beside the map, during the scan and after it. Only one works at a
/// time, so they share their memory.
#[derive(Debug)]
#[repr(u8)]
#[allow(
    clippy::large_enum_variant,
    reason = "only one works at a time, and there is no heap to box the larger one on"
)]
enum Scratch {
    /// Before the first scan: tag 0, so that a static of it costs no flash.
    Idle,
    Likelihood(Likelihood),
    #[cfg(feature = "paper")]
    Paper(Paper),
    /// No estimator of stairs: the guard has the memory while it sweeps.
    Guard(Guard),
}

impl Scratch {
    /// Makes room for the estimator of `kind`, if it is not the one that is there.
    fn choose(&mut self, kind: EstimatorKind) {
        match (&self, kind) {
            #[cfg(feature = "paper")]
            (Self::Paper(_), EstimatorKind::Paper) => {}
            #[cfg(feature = "paper")]
            (_, EstimatorKind::Paper) => *self = Self::Paper(Paper::new()),
            (Self::Likelihood(_), EstimatorKind::Likelihood) => {}
            (_, EstimatorKind::Likelihood) => self.renew(),
        }
    }

    /// The default estimator, without anything. By itself, because it comes over the stack.
    #[inline(never)]
    fn renew(&mut self) {
        *self = Self::Likelihood(Likelihood::with(current()));
    }

    /// The guard, where it is not there without anything. By itself, because it comes over the stack.
    #[inline(never)]
    fn guard(&mut self) {
        if !matches!(self, Self::Guard(_)) {
            *self = Self::Guard(Guard::new());
        }
    }

    fn estimator(&mut self) -> Option<&mut dyn Estimator> {
        match self {
            Self::Idle | Self::Guard(_) => None,
            Self::Likelihood(estimator) => Some(estimator),
            #[cfg(feature = "paper")]
            Self::Paper(estimator) => Some(estimator),
        }
    }
}

/// Finds stairs: rows in, outcome out.
///
/// [`StairFinder::begin`] a scan, [`StairFinder::fill`] each row that comes, call
/// [`StairFinder::complete`] for each lost one, from either end of the sweep, then
/// [`StairFinder::finish`]. The configuration names the estimator.
#[derive(Debug)]
pub struct StairFinder {
    map: PolarMap,
    scratch: Scratch,
}

impl StairFinder {
    /// A finder without a scan.
    pub const fn new() -> Self {
        Self {
            map: PolarMap::new(),
            scratch: Scratch::Idle,
        }
    }

    /// Empties the map and gives it the shape of `config`'s scan.
    ///
    /// # Errors
    /// Names the field that makes the scan larger than the map.
    pub fn begin(&mut self, config: &Config) -> Result<(), ConfigError> {
        self.map.begin(config)?;
        self.scratch.choose(config.estimator);
        if let Some(estimator) = self.scratch.estimator() {
            estimator.begin(&self.map);
        }
        Ok(())
    }

    /// Lets `fill` write row `k`, once a scan, and works off what can be during the scan; `None`
    /// beyond the last row.
    pub fn fill<R>(&mut self, k: usize, fill: impl FnOnce(Row<'_>) -> R) -> Option<R> {
        let filled = self.write(k, fill)?;
        self.complete(k);
        Some(filled)
    }

    /// Lets `fill` write row `k` without completing it: [`StairFinder::complete`] follows.
    pub fn write<R>(&mut self, k: usize, fill: impl FnOnce(Row<'_>) -> R) -> Option<R> {
        self.map.fill(k, fill)
    }

    /// Row `k` is final: received or lost. The estimator takes it in.
    pub fn complete(&mut self, k: usize) {
        if let Some(estimator) = self.scratch.estimator() {
            estimator.row(&self.map, k);
        }
    }

    /// Makes the answer of scan number `number` with the configuration that it began with, what is known of the
    /// chair's motion, and the evidence of earlier scans (`past`), while `observer` looks. Returns what the
    /// estimator says of its worth; `None` without an estimator.
    pub fn finish(
        &mut self,
        config: &Config,
        (number, drive): (u32, &Drive<'_>),
        past: Option<&mut History>,
        observer: &mut dyn Observer,
        answer: &mut Answer,
    ) -> Option<Sight> {
        let scan = MappedScan {
            map: &self.map,
            config,
            number,
            drive,
        };
        let sight = self
            .scratch
            .estimator()?
            .conclude(&scan, past, observer, answer);
        answer.link();
        sight
    }

    /// [`StairFinder::begin`] of a guard sweep.
    ///
    /// # Errors
    /// Names the field that makes the sweep larger than the map.
    pub fn begin_guard(&mut self, config: &Config) -> Result<(), ConfigError> {
        self.map.begin(config)?;
        self.scratch.guard();
        Ok(())
    }

    /// The next guard sweep is a first one.
    pub fn forget_guard(&mut self) {
        if let Scratch::Guard(guard) = &mut self.scratch {
            guard.forget();
        }
    }

    /// How far the ground is free after a guard sweep, by it and by those before; `None` where none was begun. In place of
    /// [`StairFinder::finish`].
    pub fn guard(&mut self, config: &Config, drive: &Drive<'_>) -> Option<FreeGround> {
        match &mut self.scratch {
            Scratch::Guard(guard) => Some(guard.sweep(&self.map, config, drive)),
            _ => None,
        }
    }

    /// The echoes of the map after the last row, placed as the configuration has it and with nothing taken
    /// out; none of an estimator that knows no echoes. In place of [`StairFinder::finish`].
    pub fn echoes(&mut self, config: &Config) -> &[Echo] {
        match &mut self.scratch {
            Scratch::Likelihood(estimator) => estimator.echoes(&self.map, config),
            _ => &[],
        }
    }

    /// The map as it stands.
    pub fn map(&self) -> &PolarMap {
        &self.map
    }
}

impl Default for StairFinder {
    fn default() -> Self {
        Self::new()
    }
}
