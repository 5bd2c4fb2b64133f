//! The very image in an emulator: QEMU's `netduinoplus2` runs the ELF file, and this module is
//! everything around the chip: the radar module at the end of the link, a terminal on the report
//! port, the motor with its home switch.
//!
//! | module | what it is |
//! |---|---|
//! | [`qemu`] | the emulator's process, its sockets and its log |
//! | [`module`] | the radar module, which plays a recording and can misbehave |
//! | [`shaft`] | the motor: STEP and DIR from the log, home switch by injected edges |
//! | [`session`] | boot, configure, scan |
//! | [`guarding`] | guard sweeps of a recording |
//! | `building` | Cargo at work, with the time that it takes |
//! | [`image`] | building the image and reading its sizes and symbols |
//! | [`seal`] | the checksum by which an image knows that it is whole |
//! | [`tools`] | whether compiler and emulator are there, and how to get them |

mod building;
pub mod guarding;
pub mod image;
pub mod module;
pub mod qemu;
pub mod seal;
pub mod session;
pub mod shaft;
pub mod tools;

pub use module::{Fault, Module};
pub use session::Session;
