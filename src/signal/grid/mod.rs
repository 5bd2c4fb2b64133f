//! Polar map: filled row by row by range processing, read by the estimators.
//!
//! | module | holds |
//! |---|---|
//! | `window` | range bins of a transform that the map keeps |
//! | `geometry` | position of its cells in the sagittal plane |
//! | `map` | cells, CFAR mask, angles |

mod geometry;
mod map;
mod window;

pub use geometry::{Geometry, two_way_sigma};
pub use map::{DB_PER_UNIT, MAX_BINS, MIN_BINS, PolarMap, Row};
pub(crate) use map::{EIGHTHS, UNITS_PER_OCTAVE};
pub use window::{BinWindow, MAX_CELLS};
