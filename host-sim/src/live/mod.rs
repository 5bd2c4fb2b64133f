//! `live`: shows a scanner's reports in a terminal, from its state ([`stairscan_replay::live`]).
//!
//! | module | what it is |
//! |---|---|
//! | [`offer`] | check of a command before it is sent |
//! | [`prompt`] | the command line and its history |
//! | [`screen`], [`side`] | the screen, drawn from the state, with the side view |
//! | [`guarded`] | the guard on the screen: side view of the last sweep, strip of the last ones |
//! | [`ports`] | the serial ports of this machine |
//! | [`port`] | the thread that reads, writes and reopens a port |
//! | [`pty`] | a pseudo-terminal in place of a port |
//! | [`talk`] | requests to a scanner and its replies, for `settings` and `doctor` |
//! | [`device`] | a simulated scanner, for `--demo` |
//! | [`sweep_times`] | the rate of its guard sweeps |
//! | [`keep`] | the files of `--record` |
//! | [`session`] | an observed source: its state, the file of its lines, the receiver of its answers |
//! | [`plain`] | output of a source without a screen |
//! | [`terminal`] | the loop over keys, time and screen |

pub mod device;
pub mod guarded;
pub mod keep;
pub mod offer;
pub mod plain;
pub mod port;
pub mod ports;
pub mod prompt;
pub mod pty;
pub mod screen;
pub mod session;
pub mod side;
pub mod sweep_times;
pub mod talk;
pub mod terminal;

pub use stairscan_replay::live::*;

#[cfg(test)]
mod tests;
