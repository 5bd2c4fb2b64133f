//! Code that the emulator's images and host-sim share: test chirps for the arithmetic, the digest of their
//! processed rows, and the format of scans in a file.
#![cfg_attr(target_os = "none", no_std)]

pub mod arithmetic_check;
#[cfg(target_os = "none")]
pub mod counter;
pub mod header;
#[cfg(target_os = "none")]
pub mod host_file;
#[cfg(target_os = "none")]
pub mod stack;
