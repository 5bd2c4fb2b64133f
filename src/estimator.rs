//! Interface of an estimator of stairs: it takes the rows of the map during the scan, and gives the answer after the
//! last one.

use crate::answer::Answer;
use crate::config::Config;
use crate::drive::Drive;
use crate::observer::Observer;
use crate::past::History;
use crate::signal::echoes::FoundEchoes;
use crate::signal::grid::PolarMap;
use crate::signal::image::KeptImage;
use crate::verdict::{Assessment, Evidence, Outcome};

/// A scan whose rows are all final: received or lost.
#[derive(Clone, Copy, Debug)]
pub struct MappedScan<'a> {
    /// Map of the scan.
    pub map: &'a PolarMap,
    /// Configuration of the scan.
    pub config: &'a Config,
    /// Number of the scan; random numbers are seeded with it.
    pub number: u32,
    /// Echoes of the scan, the strongest first, and its noise.
    pub found: &'a FoundEchoes,
    /// Coherent image of the scan, behind the search for echoes.
    pub image: Option<&'a KeptImage>,
    /// Motion of the chair during the scan.
    pub drive: &'a Drive<'a>,
}

/// Estimator of stairs: from the polar map of a scan to its answer. The same map, configuration and scan number give
/// the same answer.
pub trait Estimator {
    /// Prepares for the first row of a scan, whose shape (rows and range bins) `map` already has; for an estimator that
    /// looks at rows.
    fn begin(&mut self, _map: &PolarMap) {}

    /// Takes row `k` of the map. Rows come in order, beginning at either end of the scan; a lost row is passed as well,
    /// and is empty.
    fn row(&mut self, _map: &PolarMap, _k: usize) {}

    /// Fills `answer`, which is empty on entry (a large value, passed by reference because the stack is small),
    /// and returns the evidence for its status; `None` if there was no data. `past` is the evidence of earlier
    /// scans, to which this one is added; without it the scan stands alone. `observer` receives intermediate
    /// results.
    fn conclude(
        &mut self,
        scan: &MappedScan<'_>,
        past: Option<&mut History>,
        observer: &mut dyn Observer,
        answer: &mut Answer,
    ) -> Option<Assessment>;

    /// Calls [`Estimator::conclude`] and decides the status as if no health check had failed.
    fn outcome(
        &mut self,
        scan: &MappedScan<'_>,
        past: Option<&mut History>,
        observer: &mut dyn Observer,
    ) -> Outcome {
        let mut outcome = Outcome::silent();
        let sight = self.conclude(scan, past, observer, &mut outcome.answer);
        outcome.decide(&Evidence {
            assessment: sight,
            ..Evidence::default()
        });
        outcome
    }

    /// Calls [`Estimator::outcome`] for a chair that is known to stand, without earlier scans.
    fn finish(
        &mut self,
        map: &PolarMap,
        found: &FoundEchoes,
        config: &Config,
        number: u32,
        observer: &mut dyn Observer,
    ) -> Outcome {
        let scan = MappedScan {
            map,
            config,
            number,
            found,
            image: None,
            drive: &Drive::STANDING,
        };
        self.outcome(&scan, None, observer)
    }
}
