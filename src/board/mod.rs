//! Everything specific to the STM32F405: clocks, pins, serial ports, timers, watchdog.
//!
//! Pins, levels and connectors are in `docs/user/hardware.md`.

pub mod cfsr;
pub mod clock;
pub mod delay;
pub mod flash;
pub mod march;
pub mod protection;
pub mod retained;
pub mod second_memory;
pub mod watchdog;

#[cfg(target_os = "none")]
mod controller;
#[cfg(all(target_os = "none", feature = "demo"))]
pub mod demo;
#[cfg(target_os = "none")]
mod encoder;
#[cfg(target_os = "none")]
pub mod fault;
#[cfg(target_os = "none")]
pub mod handover;
#[cfg(target_os = "none")]
pub mod motor;
#[cfg(target_os = "none")]
mod probe;
#[cfg(all(target_os = "none", feature = "provoke"))]
pub mod provoke;
#[cfg(target_os = "none")]
pub mod seal;
#[cfg(target_os = "none")]
pub mod serial_number;
#[cfg(target_os = "none")]
mod settings_flash;
#[cfg(target_os = "none")]
pub mod sleep;
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
pub use start::{BoardParts, Interrupts, Queues, start};
