//! The chair's own motion during a scan: what its controller says of it, row by row.
//!
//! | module | does |
//! |---|---|
//! | [`track`] | when each row was seen, and where the chair was then |
//! | [`known`] | what is known of the motion when a scan ends, and what holds where nothing is |
//! | [`odometry`] | motion sentences in: checked, interpolated to each row's mid chirp |

pub mod known;
pub mod odometry;
pub mod track;

pub use known::{Drive, Input, Mode, Retention};
pub use odometry::{Odometry, Reading};
pub use track::{RowPose, Track};
