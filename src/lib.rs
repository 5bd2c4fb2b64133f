//! A radar stair scanner for powered wheelchairs: recorded or live FMCW chirps in, steps out.
//!
//! The library is the whole scanner without the chip-specific code: it has no allocator, no global state, no
//! clock and no source of random numbers. Time, seed and hardware are arguments, so the same call gives the same
//! bits on the host, in the emulator and on the Cortex-M4F.
//!
//! The stages in the order of the data:
//!
//! | module | from → to |
//! |---|---|
//! | [`setting`] | one setting: limits, default, text, and the macro that declares them |
//! | [`config`] | settings of a scan, by recording, command or radar module, and their limits |
//! | [`schedule`], [`time`], [`port`] | microstep of each row; microseconds that wrap; a serial port |
//! | [`scanner`] | mirror motor, settings, commands, the scanner's loop |
//! | [`drive`], [`track`] | motion of the chair during a scan; time and position of each row |
//! | [`motion`] | motion sentences of the chair's controller → [`drive`] and [`track`], and whether two sweeps agree |
//! | [`signal`] | radar module → chirps → rows of the polar map → echoes: point scatterers, with positions finer than a cell |
//! | [`mount`] | echoes of the ground → mounting of the scanner: calibration of each scan, and by command |
//! | [`health`] | whether radar, mirror and converter worked during the scan |
//! | [`model`] | scene types, and the likelihood of the echoes given each |
//! | [`infer`] | echoes → the most likely staircase, its steps with their σ, how far it is valid; from scan to scan |
//! | [`guard`] | maps of coarse sweeps of the ground, and the travel in between → free distance ahead |
//! | `paper` | the paper's estimator: map → particles → clusters → steps (feature `paper`, on by default) |
//! | [`params`], [`estimate`] | every tuned number; a value with its variance |
//! | [`past`] | evidence of earlier scans, moved along with the chair |
//! | [`estimator`], [`observer`] | interface of all estimators, and of observers of their intermediate results |
//! | `finder`, [`pipeline`] | map and estimator, and all stages, in one value |
//! | [`answer`] | the answer of a scan: steps, direction, drop, possible further steps |
//! | [`verdict`] | evidence → status, horizon, confidence, reasons: the only writer of a status |
//! | [`report`] | sentences out, motion in |
//! | [`math`], [`sort`] | the few f32 functions that `core` lacks, with their error bounds; a sort without panics |
//! | [`crc`] | the checksum of sentences, records and the radar link's frames |
//!
//! `board` and `main.rs` are not part of the library: they belong to the image and contain all chip-specific
//! code.
//!
//! Dependencies: [`setting`], [`config`], [`answer`], [`estimate`], [`verdict::reasons`], [`params`], [`math`],
//! [`crc`] and [`schedule`] depend on no stage. On them build [`signal::grid`], then [`signal::range`] and
//! [`signal::echoes`], then [`mount`] and [`model`], then [`infer`] and `paper` side by side, then `finder`
//! and [`pipeline`]. Both estimators implement [`estimator`], which passes [`past`] on, and report to [`observer`], where
//! the types of their intermediate results stand. Estimators, pipeline and scanner give their evidence to [`verdict`],
//! which depends on none of them. [`scanner`]'s loop drives any [`scanner::DataPath`], and `pipeline` is one.
//!
//! Entry points: [`pipeline::Pipeline`] takes the chirps of a scan and gives its answer;
//! [`signal::range::RangeProcessor`] makes a range profile of one chirp; [`report::Sentence`] parses the
//! scanner's sentences. `examples/` has a program for each, and `docs/design/estimator.md` the terms and equations of
//! the default estimator.
#![cfg_attr(not(test), no_std)]

// The simulated hardware names this crate as its other users do.
#[cfg(test)]
extern crate self as stairscan;

pub mod answer;
pub mod config;
pub mod crc;
pub mod drive;
pub mod estimate;
pub mod estimator;
mod finder;
pub mod guard;
pub mod health;
pub mod infer;
pub mod math;
pub mod model;
pub mod motion;
pub mod mount;
pub mod observer;
#[cfg(feature = "paper")]
pub mod paper;
pub mod params;
pub mod past;
pub mod pipeline;
pub mod port;
pub mod report;
pub mod scanner;
pub mod schedule;
pub mod setting;
pub mod signal;
pub mod sort;
#[cfg(test)]
#[allow(dead_code, reason = "tests outside of this crate use more of it")]
mod testing;
pub mod time;
pub mod track;
pub mod verdict;

/// Git revision of the build; `unknown` without git, with `-dirty` appended for a changed tree.
pub const REVISION: &str = env!("STAIRSCAN_REVISION");

/// One complex sample of a chirp: in-phase and quadrature part of the down-converted signal.
///
/// Full scale is ±32767 (Q0.15). The layout is that of the recordings (`ci16_le`) and of the
/// Cortex-M4's packed 16-bit instructions: I in the lower half-word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C, align(4))]
pub struct Iq {
    /// In-phase part.
    pub i: i16,
    /// Quadrature part.
    pub q: i16,
}

impl Iq {
    /// Creates a sample from its in-phase and quadrature parts.
    pub const fn new(i: i16, q: i16) -> Self {
        Self { i, q }
    }
}
