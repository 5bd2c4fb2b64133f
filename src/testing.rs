//! Simulated hardware of the unit tests: files of `testbed/`, compiled as part of this crate so that its parts implement
//! this crate's own traits. Tests outside of it use the crate `testbed`.

#[path = "../testbed/src/flash.rs"]
pub mod flash;
#[path = "../testbed/src/framed.rs"]
pub mod framed;
#[path = "../testbed/src/motor.rs"]
pub mod motor;
#[path = "../testbed/src/port.rs"]
pub mod port;
#[path = "../testbed/src/shared.rs"]
pub mod shared;
#[path = "../testbed/src/tmc2209.rs"]
pub mod tmc2209;
