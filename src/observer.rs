//! What an estimator tells on its way to the answer, for pictures, `inspect` and the benchmark.
//!
//! The scanner's own calls pass `()`, which listens to nothing.

use crate::answer::Maybe;
use crate::infer::Cloud;
use crate::infer::trace::{Candidate, Cell, Scatterer, Stage};
use crate::model::View;
use crate::mount::{Calibration, Floor};
#[cfg(feature = "paper")]
use crate::paper::{bright::Field, cluster::Extent, particles::PointCloud};
use crate::signal::echoes::Lobes;

/// What an estimator tells. Each says which of these it has to tell.
#[derive(Debug)]
pub enum Event<'a> {
    /// Either estimator: a stage after the last row is done.
    Done(Stage),
    /// `likelihood`: the noise, median of the filtered map, map units (1/8 octave).
    Noise(f32),
    /// `likelihood`: what the floor says about the scanner's own errors.
    Calibration(Calibration),
    /// `likelihood`: how well echoes support a floor in its place, and one elsewhere.
    Floor(Floor),
    /// `likelihood`: how wide the lobes of strong echoes are over the rows.
    Lobes(Lobes),
    /// `likelihood`: one scatterer, strongest first.
    Scatterer(&'a Scatterer),
    /// `likelihood`: one flight of the search, the best of each number of steps, or level ground.
    Candidate(&'a Candidate<'a>),
    /// `likelihood`: a cell of the way ahead and what the verdict knows of it, the nearest first.
    Cell(&'a Cell),
    /// A possible step or drop besides the answer, with its share of the particles before [`Weights::maybe`] maps that.
    ///
    /// [`Weights::maybe`]: crate::params::hazard::Weights::maybe
    Maybe(&'a Maybe),
    /// `likelihood` in the depth plane: what the posterior says once it is complete.
    Posterior {
        /// Its particles with their probabilities, and the probability of each number of steps.
        cloud: &'a Cloud,
        /// What can be seen: only such edges count as steps.
        view: &'a View,
    },
    /// `paper`: the particles after a stage, and the clusters where there are any.
    #[cfg(feature = "paper")]
    Particles {
        /// After which stage.
        stage: CloudStage,
        /// The particles.
        cloud: &'a PointCloud,
        /// The map that they are weighed with.
        field: &'a Field<'a>,
        /// The clusters.
        clusters: &'a [Extent],
    },
}

/// How far the paper's particles have come.
#[cfg(feature = "paper")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CloudStage {
    /// As they were drawn, in cells of the map (angle, range).
    Drawn,
    /// The same after a round of resampling.
    Resampled,
    /// In the sagittal plane (along, across, see [`crate::paper::Places`]), marked with their
    /// clusters.
    Clustered,
    /// The same after fusion and rejection; particles of rejected clusters keep their marks.
    Rejected,
}

/// Listens to an estimator.
pub trait Observer {
    /// Whether it wants to hear about scatterers and candidates, which take time to tell.
    fn listens(&self) -> bool {
        true
    }

    /// Something to tell.
    fn event(&mut self, event: Event<'_>);
}

impl Observer for () {
    fn listens(&self) -> bool {
        false
    }

    fn event(&mut self, _event: Event<'_>) {}
}
