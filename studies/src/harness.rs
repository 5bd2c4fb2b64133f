//! Shared functions of the measuring commands: scenes of a draw, simulated once, processed in
//! parallel.

use std::ops::Range;

use anyhow::Result;
use indicatif::ParallelProgressIterator;
use rayon::prelude::*;
use stairscan::params::{Numbers, Params};

use crate::instrument::Instrument;
use host_sim::console::progress;
use host_sim::random::{Kind, random_with};
use host_sim::recording::Recording;
use host_sim::replay::{self, Options};
use host_sim::score::{self, SceneScore};
use host_sim::seeds::Draw;
use host_sim::simulation::{random_scan, scan_of};

/// A random scene of a draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Drawn {
    /// Kind of scene.
    pub kind: Kind,
    /// Seed of the scene, and of the noise of its scan.
    pub seed: u64,
}

impl Drawn {
    /// Simulates a scan of the scene with the instrument of its kind.
    ///
    /// # Errors
    /// The scene cannot be built; the message names the cause.
    pub fn scan(&self) -> Result<Recording> {
        random_scan(self.kind, self.kind.variety(), self.seed)
    }

    /// Simulates a scan of the scene with another radar module.
    ///
    /// # Errors
    /// The scene cannot be built; the message names the cause.
    pub fn scan_by(&self, instrument: &Instrument) -> Result<Recording> {
        let mut spec = random_with(self.kind, self.kind.variety(), self.seed);
        instrument.apply(&mut spec);
        scan_of(spec, &self.name(), self.seed)
    }

    /// Returns the name of the scene's recording.
    pub fn name(&self) -> String {
        format!("{}_{:03}", self.kind, self.seed)
    }
}

/// Returns the first scenes of a draw, kind by kind, `count(kind)` of each.
pub fn scenes(draw: Draw, count: impl Fn(Kind) -> u64) -> Vec<Drawn> {
    scenes_of(draw.seeds(), count)
}

/// Returns the scenes with the first of these seeds, kind by kind, `count(kind)` of each.
pub fn scenes_of(seeds: Range<u64>, count: impl Fn(Kind) -> u64) -> Vec<Drawn> {
    let of = |kind: Kind| {
        let seeds = seeds.clone().take(count(kind) as usize);
        seeds.map(move |seed| Drawn { kind, seed })
    };
    Kind::ALL.iter().flat_map(|&kind| of(kind)).collect()
}

/// Applies `make` to all jobs in parallel, with a progress bar. Returns the results in the order of
/// the jobs.
///
/// # Errors
/// The first error of `make`.
pub fn each<J: Sync, R: Send>(
    jobs: &[J],
    make: impl Fn(&J) -> Result<R> + Send + Sync,
) -> Result<Vec<R>> {
    let bar = progress(jobs.len() as u64);
    let made = jobs
        .par_iter()
        .progress_with(bar.clone())
        .map(make)
        .collect();
    bar.finish_and_clear();
    made
}

/// Scans all recordings with these parameters of the estimator, and scores the answers against the ground truth.
///
/// # Errors
/// A scan cannot be processed; the message names it.
pub fn answers(scans: &[Recording], params: &'static Params) -> Result<Vec<SceneScore>> {
    let options = Options {
        numbers: Numbers::of(params),
        ..Options::default()
    };
    each(scans, |recording| scored(recording, &options))
}

/// Scans a recording and scores the answer against its ground truth.
///
/// # Errors
/// The scan cannot be processed; the message names it.
pub fn scored(recording: &Recording, options: &Options) -> Result<SceneScore> {
    let truth = recording.meta.truth.clone().unwrap_or_default();
    let answer = replay::answer(recording, options)?;
    Ok(score::scene(&answer, &truth))
}
