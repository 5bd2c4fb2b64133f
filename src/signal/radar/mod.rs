//! Radar modules, and how they are spoken to.
//!
//! The sweep sees a module as a [`RadarModule`] and knows nothing of its protocol. Which one it is, is a
//! setting; `docs/modules.md` has the wiring and the limits of each.
//!
//! | module | what it does |
//! |---|---|
//! | [`module`] | the radar module as the sweep sees it, whatever its protocol |
//! | [`wire`] | how long what takes on the wire |
//! | [`frame`] | this project's binary frames |
//! | [`link`] | a module that speaks frames, and the rate of its wire |
//! | [`framed`] | the same over a port of its own |
//! | [`sirad`] | SiRad Easy and Simple |
//! | [`bgt60`] | Infineon's BGT60TR13C, over SPI |
//! | [`any`] | whichever of these the setting names |

pub mod any;
pub mod bgt60;
pub mod frame;
pub mod framed;
pub mod link;
pub mod module;
pub mod sirad;
pub mod wire;

pub use framed::FrameLink;
pub use module::{LinkError, RadarModule};
