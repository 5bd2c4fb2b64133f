//! Tests of the program, in one binary: every further binary would link the simulator and its libraries again. `cargo
//! test -p host-sim --test suite NAME` runs the tests of one module.

mod bad_recordings;
mod bad_scenes;
mod bgt60;
mod calibrate;
mod coherent;
mod committed_recordings;
mod common;
mod crash;
mod demo;
mod doctor;
mod documents;
mod dwell;
mod firmware;
mod forms;
mod live;
mod logs;
mod modules;
mod motion;
mod outputs;
mod own_data;
mod planes;
mod printed_commands;
mod processor;
mod real;
mod report;
mod revision;
mod sequences;
mod settings;
mod single_rises;
mod sirad;
mod special_files;
mod streams;
mod sweep_modes;
mod tap;
mod update;
