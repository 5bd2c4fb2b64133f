//! What the emulator's images and host-sim share: chirps that try the arithmetic, and the digest of
//! what range processing makes of them.
#![cfg_attr(target_os = "none", no_std)]

#[cfg(target_os = "none")]
pub mod counter;
#[cfg(target_os = "none")]
pub mod host_file;
pub mod twins;
