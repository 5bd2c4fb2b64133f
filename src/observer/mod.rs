//! Intermediate results of an estimator, for plots, `inspect` and the benchmark.
//!
//! The scanner itself passes `()`, which ignores them. The types of the results stand here ([`trace`] for the default
//! estimator), so that the estimators depend on them and not the other way round.

#[cfg(feature = "paper")]
pub mod paper_trace;
pub mod trace;

use crate::answer::PossibleStep;
use crate::model::View;
use crate::model::cloud::Cloud;
use crate::mount::{Calibration, GroundEvidence};
use crate::signal::echoes::Lobes;
#[cfg(feature = "paper")]
pub use paper_trace::CloudStage;
#[cfg(feature = "paper")]
use paper_trace::{Extent, PointParticle};
use trace::{Candidate, Cell, Scatterer, Stage};

/// An intermediate result, marked with the estimators that report it.
#[derive(Debug)]
pub enum Event<'a> {
    /// Both estimators: a processing stage that follows the scan's last row is complete.
    Done(Stage),
    /// `likelihood`: power of the noise, median of the filtered map, map units (1/8 octave of power, 0.376 dB).
    Noise(f32),
    /// `likelihood`: errors of the shaft's angle and of the configured mounting height, estimated from the ground's
    /// echoes.
    Calibration(Calibration),
    /// `likelihood`: evidence for a ground at its configured place, and for one elsewhere.
    Floor(GroundEvidence),
    /// `likelihood`: widths of the strong echoes' main lobes over the rows.
    Lobes(Lobes),
    /// `likelihood`: one scatterer, strongest first.
    Scatterer(&'a Scatterer),
    /// `likelihood`: one hypothesis of the search, the best of each number of steps, or level ground.
    Candidate(&'a Candidate<'a>),
    /// `likelihood`: a way cell (10 cm of the way ahead) with the evidence that decides whether the answer is valid up
    /// to its end, nearest first.
    Cell(&'a Cell),
    /// `likelihood`: a possible step or drop besides the answer, with its share of the particles, before
    /// [`Weights::maybe_map`] maps this share to a probability.
    ///
    /// [`Weights::maybe_map`]: crate::params::hazard::Weights::maybe_map
    PossibleStep(&'a PossibleStep),
    /// `likelihood` in the depth plane: the posterior distribution, once it is complete.
    Posterior {
        /// Particles with their probabilities, and the probability of each number of steps.
        cloud: &'a Cloud,
        /// Field of view of the scan: only edges within it count as steps.
        view: &'a View,
    },
    /// `paper`: the particles after a stage, and the clusters once there are any.
    #[cfg(feature = "paper")]
    Particles {
        /// Stage after which the particles are reported.
        stage: CloudStage,
        /// The particles, mode after mode.
        particles: &'a [PointParticle],
        /// The clusters; empty before there are any.
        clusters: &'a [Extent],
    },
}

/// Receiver of an estimator's intermediate results.
pub trait Observer {
    /// Returns whether the observer wants scatterers and hypotheses, which take time to compute.
    fn listens(&self) -> bool {
        true
    }

    /// Receives an intermediate result.
    fn event(&mut self, event: Event<'_>);
}

impl Observer for () {
    fn listens(&self) -> bool {
        false
    }

    fn event(&mut self, _event: Event<'_>) {}
}
