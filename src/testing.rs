//! Simulated hardware of the unit tests: files of `testbed/`, compiled as part of this crate so that its parts implement
//! this crate's own traits. Tests outside of it use the crate `testbed`.

#[path = "../testbed/src/flash.rs"]
pub mod flash;
