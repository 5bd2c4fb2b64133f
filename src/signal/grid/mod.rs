//! The polar map: what range processing fills row by row and the estimators read.
//!
//! | module | holds |
//! |---|---|
//! | `window` | which range bins of a transform the map keeps |
//! | `geometry` | where its cells lie in the sagittal plane |
//! | `map` | the cells, the CFAR mask, the angles |

mod geometry;
mod map;
mod window;

pub use geometry::Geometry;
pub use map::{DB_PER_UNIT, MAX_BINS, MIN_BINS, PolarMap, Row};
pub(crate) use map::{EIGHTHS, UNITS_PER_OCTAVE};
pub use window::{BinWindow, MAX_CELLS};
