//! Runs the firmware image in an emulator: QEMU's `netduinoplus2` runs the ELF file, and this
//! module simulates the environment of the chip: the radar module at the link, a terminal at the
//! report port, the motor with its home switch.
//!
//! | module | what it is |
//! |---|---|
//! | [`qemu`] | the emulator's process, its sockets and its log |
//! | [`module`] | the radar module, which plays a recording and can inject faults |
//! | [`shaft`] | the motor: STEP and DIR from the log, home switch by injected edges |
//! | [`session`] | boot, configure, scan |
//! | [`guarding`] | guard sweeps of a recording |
//! | `building` | Cargo runs with elapsed and remaining time |
//! | [`image`] | building the image and reading its sizes and symbols |
//! | [`seal`] | the checksum with which an image verifies itself |
//! | [`tools`] | checks for compiler targets and emulator, and how to install them |

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
