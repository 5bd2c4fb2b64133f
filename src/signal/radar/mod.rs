//! Radar modules and their protocols.
//!
//! The sweep uses a module as a [`RadarModule`], independent of its protocol. A setting selects the module;
//! `docs/design/modules.md` has wiring and limits of each.
//!
//! | module | contains |
//! |---|---|
//! | [`module`] | interface of a radar module, independent of its protocol |
//! | [`wire`] | transmission times on the serial wire |
//! | [`frame`] | this project's binary frames |
//! | [`link`] | a module with this protocol, and the rate of its wire |
//! | [`dwell`] | sum of the chirps of a row, for modules with this protocol and for simulators |
//! | [`framed`] | [`link`] with a port of its own |
//! | [`sirad`] | SiRad Easy and Simple |
//! | [`bgt60`] | Infineon's BGT60TR13C, over SPI |
//! | [`any`] | the one of these that the setting selects |

pub mod any;
pub mod bgt60;
pub mod dwell;
pub mod frame;
pub mod framed;
pub mod link;
pub mod module;
pub mod sirad;
pub mod wire;

pub use framed::FrameLink;
pub use module::{LinkError, RadarModule};
