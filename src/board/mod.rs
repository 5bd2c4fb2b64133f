//! Everything specific to the STM32F405: clocks, pins, serial ports, timers, watchdog.
//!
//! Pins, levels and connectors are in `docs/hardware.md`.

pub mod cfsr;
pub mod clock;
pub mod march;
pub mod protection;
pub mod retained;

#[cfg(target_os = "none")]
mod encoder;
#[cfg(target_os = "none")]
pub mod fault;
#[cfg(target_os = "none")]
pub mod flash;
#[cfg(target_os = "none")]
pub mod handover;
#[cfg(target_os = "none")]
pub mod motor;
#[cfg(all(target_os = "none", feature = "provoke"))]
pub mod provoke;
#[cfg(target_os = "none")]
pub mod seal;
#[cfg(target_os = "none")]
pub mod serial_number;
#[cfg(target_os = "none")]
pub mod spi;
#[cfg(target_os = "none")]
mod start;
#[cfg(target_os = "none")]
pub mod supply;
#[cfg(target_os = "none")]
pub mod time;
#[cfg(target_os = "none")]
pub mod uart;

#[cfg(target_os = "none")]
pub use start::{Interrupts, Parts, Queues, start};
