//! What the emulator's images and host-sim share: chirps that try the arithmetic, and the digest of
//! what range processing makes of them.
#![cfg_attr(target_os = "none", no_std)]

#[cfg(target_os = "none")]
pub mod counter;
pub mod head;
#[cfg(target_os = "none")]
pub mod host_file;
#[cfg(target_os = "none")]
pub mod stack;
pub mod twins;
