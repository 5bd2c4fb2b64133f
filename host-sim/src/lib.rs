//! Library of `cargo sim`: scenes and the simulated radar, pictures, the emulator and its radar module, and the programs
//! at a scanner's ports.

// `emit` and `note!` end or go on where stdout or stderr is closed; the macros would panic.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

pub mod budgets;
pub mod cache;
pub mod captures;
pub mod commands;
pub mod console;
pub mod convert;
pub mod crash;
pub mod doctor;
pub mod emulate;
pub mod film;
pub mod html;
pub mod live;
pub mod modules;
pub mod output;
pub mod plots;
pub mod random;
pub mod scene;
pub mod seeds;
pub mod serve;
pub mod setting_file;
pub mod simulation;
pub mod sweeps;
pub mod tap;
pub mod update;

pub use stairscan_replay::{
    answer, coherent, counted, guarded, inspect, motion, playback, posterior, recording, replay,
    score, setup, views, volatile,
};
