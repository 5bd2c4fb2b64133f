//! Tests of the program, in one binary: every further binary would link the simulator and its libraries again. `cargo
//! test -p studies --test suite NAME` runs the tests of one module.

mod accuracy;
mod capability;
mod common;
mod documents;
mod faults;
mod fitted;
mod image;
mod outputs;
mod soak;
mod table1;
