//! What an estimator is to the scanner: it takes in the rows of the map during the scan and gives the
//! answer after the last one.

use crate::answer::Outcome;
use crate::config::Config;
use crate::fusion::History;
use crate::motion::Drive;
use crate::observer::Observer;
use crate::signal::grid::PolarMap;

/// Works a scan's map off. The same map, configuration and scan number give the same answer.
pub trait Estimator {
    /// Ready for the first row of the scan that `map` has been shaped for.
    fn begin(&mut self, map: &PolarMap);

    /// Takes in row `k` of the map. Rows come one after the other from either end; one whose chirp
    /// was lost comes too, empty as it is.
    fn row(&mut self, map: &PolarMap, k: usize);

    /// The answer of scan number `scan`, after the last row, with what is known of the chair's motion
    /// during it, while `observer` looks. `past` is the evidence of earlier scans, to which this one is
    /// added; without it the scan is by itself.
    fn conclude(
        &mut self,
        map: &PolarMap,
        config: &Config,
        scan: u32,
        drive: &Drive<'_>,
        past: Option<&mut History>,
        observer: &mut dyn Observer,
    ) -> Outcome;

    /// The same for a chair that is known to stand, without earlier scans.
    fn finish(
        &mut self,
        map: &PolarMap,
        config: &Config,
        scan: u32,
        observer: &mut dyn Observer,
    ) -> Outcome {
        self.conclude(map, config, scan, &Drive::STANDING, None, observer)
    }
}
