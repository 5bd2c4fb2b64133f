//! Simulated hardware of the stair scanner, each part with faults on command, for tests, fuzz targets and studies.
//!
//! Time and seeds are arguments: the same calls give the same results on every host. The unit tests of `stairscan` itself
//! compile the files that they need as part of that crate (`src/testing.rs`), so that the parts implement its own traits.

pub mod answer;
pub mod board;
#[cfg(feature = "boot")]
mod boot;
pub mod flash;
pub mod framed;
pub mod module;
pub mod motor;
pub mod port;
pub mod shared;
pub mod tmc2209;

pub use answer::sure;
pub use board::Board;
pub use flash::{Flash, FlashFault, Power, SharedPower};
pub use framed::{AnswerFault, FramedModule};
pub use module::{Echoes, Module};
pub use motor::{Motor, Pace};
pub use port::Port;
pub use shared::Shared;
