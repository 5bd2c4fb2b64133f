//! What an estimator is to the scanner: it takes in the rows of the map during the scan and gives the
//! answer after the last one.

use crate::answer::Answer;
use crate::config::Config;
use crate::drive::Drive;
use crate::infer::past::History;
use crate::observer::Observer;
use crate::signal::grid::PolarMap;
use crate::verdict::{Evidence, Outcome, Sight};

/// A scan whose rows have all come or are lost.
#[derive(Clone, Copy, Debug)]
pub struct MappedScan<'a> {
    /// Its map.
    pub map: &'a PolarMap,
    /// The configuration that it was made with.
    pub config: &'a Config,
    /// Its number.
    pub number: u32,
    /// The chair's motion during the scan, as far as it is known.
    pub drive: &'a Drive<'a>,
}

/// Works a scan's map off. The same map, configuration and scan number give the same answer.
pub trait Estimator {
    /// Ready for the first row of the scan that `map` has been shaped for.
    fn begin(&mut self, map: &PolarMap);

    /// Takes in row `k` of the map. Rows come one after the other from either end; one whose chirp
    /// was lost comes too, empty as it is.
    fn row(&mut self, map: &PolarMap, k: usize);

    /// Makes `answer`, which is empty and large for a small stack, and returns what it says of its worth; `None` if
    /// there was nothing to work on. `past` is the evidence of earlier scans, to which this one is
    /// added; without it the scan is by itself. Meanwhile `observer` looks.
    fn conclude(
        &mut self,
        scan: &MappedScan<'_>,
        past: Option<&mut History>,
        observer: &mut dyn Observer,
        answer: &mut Answer,
    ) -> Option<Sight>;

    /// The same with its verdict where the instrument is well.
    fn outcome(
        &mut self,
        scan: &MappedScan<'_>,
        past: Option<&mut History>,
        observer: &mut dyn Observer,
    ) -> Outcome {
        let mut outcome = Outcome::silent();
        let sight = self.conclude(scan, past, observer, &mut outcome.answer);
        outcome.decide(&Evidence {
            sight,
            ..Evidence::default()
        });
        outcome
    }

    /// The same for a chair that is known to stand, without earlier scans.
    fn finish(
        &mut self,
        map: &PolarMap,
        config: &Config,
        number: u32,
        observer: &mut dyn Observer,
    ) -> Outcome {
        let scan = MappedScan {
            map,
            config,
            number,
            drive: &Drive::STANDING,
        };
        self.outcome(&scan, None, observer)
    }
}
