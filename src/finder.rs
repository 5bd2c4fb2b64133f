//! The map and the estimator that reads it, in one block of memory.

use crate::answer::Answer;
use crate::config::{Config, ConfigError, EstimatorKind};
use crate::drive::Drive;
use crate::estimator::{Estimator, MappedScan};
use crate::guard::Guard;
use crate::infer::Likelihood;
use crate::observer::Observer;
#[cfg(feature = "paper")]
use crate::paper::Paper;
use crate::params::Numbers;
use crate::past::History;
use crate::signal::echoes::FoundEchoes;
use crate::signal::grid::{PolarMap, Row};
use crate::signal::image::{CoherentRow, KeptImage};
use crate::verdict::{Assessment, FreeGround};

/// Working memory of the estimator of stairs or of the guard, beside the map, during a scan and after it. Only one is
/// in use at a time, so they share their memory.
#[derive(Debug)]
#[repr(u8)]
#[allow(
    clippy::large_enum_variant,
    reason = "only one works at a time, and there is no heap to box the larger one on"
)]
enum Scratch {
    /// Before the first scan. The tag is 0, so that a static of this type takes no flash.
    Idle,
    Likelihood(Likelihood),
    #[cfg(feature = "paper")]
    Paper(Paper),
    /// No estimator of stairs: the guard uses the memory while it sweeps.
    Guard(Guard),
}

impl Scratch {
    /// Creates the estimator of `kind`, unless the memory already holds it.
    fn choose(&mut self, kind: EstimatorKind, numbers: Numbers) {
        match (&self, kind) {
            #[cfg(feature = "paper")]
            (Self::Paper(_), EstimatorKind::Paper) => {}
            #[cfg(feature = "paper")]
            (_, EstimatorKind::Paper) => *self = Self::Paper(Paper::new()),
            (Self::Likelihood(_), EstimatorKind::Likelihood) => {}
            (_, EstimatorKind::Likelihood) => self.renew(numbers),
        }
    }

    /// Creates the default estimator. Not inlined, because the new value passes over the stack.
    #[inline(never)]
    fn renew(&mut self, numbers: Numbers) {
        *self = Self::Likelihood(Likelihood::with(numbers));
    }

    /// Creates the guard, unless the memory already holds it. Not inlined, because the new value passes over the stack.
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

/// Stair finder: rows of a scan in, answer out.
///
/// A scan is [`StairFinder::begin`], then for each row from either end of the scan [`StairFinder::write`], unless it is
/// lost, and [`StairFinder::complete`], then [`StairFinder::finish`]. The configuration selects the
/// estimator.
#[derive(Debug)]
pub struct StairFinder {
    map: PolarMap,
    image: KeptImage,
    found: FoundEchoes,
    scratch: Scratch,
    numbers: Numbers,
}

impl StairFinder {
    /// Creates a finder without a scan.
    pub const fn new(numbers: Numbers) -> Self {
        Self {
            map: PolarMap::new(),
            image: KeptImage::new(),
            found: FoundEchoes::NONE,
            scratch: Scratch::Idle,
            numbers,
        }
    }

    /// Empties map and image and gives them the shape of `config`'s scan.
    ///
    /// # Errors Returns the field that makes the scan larger than the map, or its sweep wider than the shaft can turn.
    pub fn begin(&mut self, config: &Config) -> Result<(), ConfigError> {
        self.map.begin(config)?;
        self.image.begin(&self.map, &config.radar);
        self.scratch.choose(config.estimator, self.numbers);
        if let Some(estimator) = self.scratch.estimator() {
            estimator.begin(&self.map);
        }
        Ok(())
    }

    /// Lets `fill` write row `k` of the map without passing it to the estimator; [`StairFinder::complete`] must follow.
    /// Returns the result of `fill`; `None` beyond the last row.
    pub fn write<R>(&mut self, k: usize, fill: impl FnOnce(Row<'_>) -> R) -> Option<R> {
        self.map.fill(k, fill)
    }

    /// Adds the last written row, `k`, to the image.
    pub fn add(&mut self, k: usize, row: &mut CoherentRow<'_>) {
        self.image.add(&self.map, k, row);
    }

    /// Marks row `k` as final, received or lost, and lets the estimator process it.
    pub fn complete(&mut self, k: usize) {
        if let Some(estimator) = self.scratch.estimator() {
            estimator.row(&self.map, k);
        }
    }

    /// Fills `answer` for scan number `number` with the configuration of [`StairFinder::begin`], the chair's
    /// motion, and the evidence of earlier scans (`past`). `observer` receives intermediate results. Returns
    /// the evidence for the answer's status; `None` without an estimator.
    pub fn finish(
        &mut self,
        config: &Config,
        number: u32,
        drive: &Drive<'_>,
        past: Option<&mut History>,
        observer: &mut dyn Observer,
        answer: &mut Answer,
    ) -> Option<Assessment> {
        self.detect(config);
        let scan = MappedScan {
            map: &self.map,
            found: &self.found,
            config,
            number,
            image: Some(&self.image),
            drive,
        };
        let sight = self
            .scratch
            .estimator()?
            .conclude(&scan, past, observer, answer);
        answer.link();
        sight
    }

    /// Begins a guard sweep, in place of [`StairFinder::begin`]: empties the map and gives it the shape of the sweep.
    ///
    /// # Errors Returns the field that makes the sweep larger than the map, or wider than the shaft can turn.
    pub fn begin_guard(&mut self, config: &Config) -> Result<(), ConfigError> {
        self.map.begin(config)?;
        self.scratch.guard();
        Ok(())
    }

    /// Discards the evidence of earlier guard sweeps.
    pub fn reset_guard(&mut self) {
        if let Scratch::Guard(guard) = &mut self.scratch {
            guard.forget();
        }
    }

    /// Ends a guard sweep, in place of [`StairFinder::finish`]. Returns the free distance by this sweep and those
    /// before it; `None` if no guard sweep was begun.
    pub fn guard(&mut self, config: &Config, drive: &Drive<'_>) -> Option<FreeGround> {
        match &mut self.scratch {
            Scratch::Guard(guard) => Some(guard.sweep(&self.map, config, drive)),
            _ => None,
        }
    }

    /// Closes the image after the last row and finds its echoes, as for a chair that stands: their positions follow from
    /// the configuration alone, without a calibration on the ground. Also for a calibration by command, in place of
    /// [`StairFinder::finish`].
    pub fn detect(&mut self, config: &Config) -> &FoundEchoes {
        self.image.finish();
        self.image.detect(&self.map, config, &mut self.found);
        &self.found
    }

    /// Returns the image, whose memory is lent at boot.
    pub fn image_mut(&mut self) -> &mut KeptImage {
        &mut self.image
    }

    /// Returns the image in its present state.
    pub fn image(&self) -> &KeptImage {
        &self.image
    }

    /// Returns the echoes of the last scan.
    pub fn found(&self) -> &FoundEchoes {
        &self.found
    }

    /// Returns the map in its present state.
    pub fn map(&self) -> &PolarMap {
        &self.map
    }
}

impl Default for StairFinder {
    fn default() -> Self {
        Self::new(Numbers::DEFAULT)
    }
}
