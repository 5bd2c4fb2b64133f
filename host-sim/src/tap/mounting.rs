//! Properties of the scanner that a recording has, and that the radar link does not transmit: mounting, schedules of
//! angles, duration of a chirp.

use stairscan::config::SweepConfig;

use crate::recording::MirrorSetup;

/// Properties of the scanner that the radar link does not transmit.
#[derive(Clone, Debug, PartialEq)]
pub struct Mounting {
    /// Mirror, beam width, height and plane.
    pub setup: MirrorSetup,
    /// Schedule of the angles of the scanner's full scans; `None` if it is not known.
    pub sweep: Option<SweepConfig>,
    /// Schedule of the angles of the scanner's guard sweeps; `None` if it is not known.
    pub guard: Option<SweepConfig>,
    /// Duration of a chirp, µs; `None` if it is not known.
    pub chirp_us: Option<u32>,
}
