//! The map and the estimators that read it, in one block of memory.

use super::likelihood::Likelihood;
use super::map::{PolarMap, Row};
use super::paper::{Observer, Paper};
use super::{Outcome, Reason};
use crate::config::{Config, ConfigError, EstimatorKind};

/// What one estimator keeps beside the map, during the scan and after it. Only one works at a
/// time, so they share their memory.
#[derive(Debug)]
#[repr(u8)]
#[expect(
    clippy::large_enum_variant,
    reason = "one estimator or the other in the same memory"
)]
enum Scratch {
    /// Before the first scan: tag 0, so that a static of it costs no flash.
    Idle,
    Likelihood(Likelihood),
    Paper(Paper),
}

/// Finds stairs: rows in, outcome out.
///
/// [`StairFinder::begin`] a scan, fill each [`StairFinder::row_mut`] that comes and say so with
/// [`StairFinder::row_done`], or with [`StairFinder::row_lost`] that it does not, from either end
/// of the sweep, then [`StairFinder::finish`]. The configuration names the estimator.
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
        match (&mut self.scratch, config.estimator) {
            (Scratch::Paper(_), EstimatorKind::Paper)
            | (Scratch::Likelihood(_), EstimatorKind::Likelihood) => {}
            (scratch, EstimatorKind::Paper) => *scratch = Scratch::Paper(Paper::new()),
            (scratch, EstimatorKind::Likelihood) => {
                *scratch = Scratch::Likelihood(Likelihood::new());
            }
        }
        match &mut self.scratch {
            Scratch::Idle => {}
            Scratch::Likelihood(state) => state.begin(&self.map),
            Scratch::Paper(state) => state.begin(),
        }
        Ok(())
    }

    /// Row `k`, to be filled at the angle that the shaft really has; `None` beyond the last.
    pub fn row_mut(&mut self, k: usize, angle_rad: f32) -> Option<Row<'_>> {
        self.map.row_mut(k, angle_rad)
    }

    /// Row `k` is filled, once a scan: what can be worked out during the scan is.
    pub fn row_done(&mut self, k: usize) {
        match &mut self.scratch {
            Scratch::Likelihood(state) => state.row(&self.map, k),
            Scratch::Paper(state) => state.row(&self.map, k),
            Scratch::Idle => {}
        }
    }

    /// Row `k` will not come.
    pub fn row_lost(&mut self, k: usize) {
        match &mut self.scratch {
            Scratch::Likelihood(state) => state.row(&self.map, k),
            Scratch::Paper(_) | Scratch::Idle => {}
        }
    }

    /// The answer of scan number `scan` with the configuration that it began with.
    pub fn finish(&mut self, config: &Config, scan: u32) -> Outcome {
        self.finish_observed(config, scan, &mut ())
    }

    /// The same while somebody looks.
    pub fn finish_observed(
        &mut self,
        config: &Config,
        scan: u32,
        observer: &mut impl Observer,
    ) -> Outcome {
        let mut outcome = match &mut self.scratch {
            Scratch::Likelihood(state) => state.finish(&self.map, config, scan),
            Scratch::Paper(state) => state.finish(&self.map, config, scan, observer),
            Scratch::Idle => Outcome::fault(Reason::Silent),
        };
        super::dimension::link(&mut outcome.steps);
        outcome
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
