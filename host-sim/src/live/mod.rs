//! `live`: shows a scanner's reports in a terminal.
//!
//! | module | what it is |
//! |---|---|
//! | [`model`] | state of the scanner, from its sentences; pure, time is an argument |
//! | [`guard`] | the last guard sweep, the interval of sweeps, a bar of the free distance |
//! | [`lines`] | splits the bytes of the port into lines |
//! | [`trouble`] | explanations and remedies for faults of a port |
//! | [`offer`] | check of a command before it is sent |
//! | [`prompt`] | the command line and its history |
//! | [`screen`], [`side`] | the screen, drawn from the state, with the side view |
//! | [`ports`] | the serial ports of this machine |
//! | [`port`] | the thread that reads, writes and reopens a port |
//! | [`pty`] | a pseudo-terminal in place of a port |
//! | [`talk`] | requests to a scanner and its replies, for `settings` and `doctor` |
//! | [`device`] | a simulated scanner, for `--demo` |
//! | [`keep`] | the files of `--record` |
//! | [`session`] | an observed source: its state, the file of its lines, the receiver of its answers |
//! | [`plain`] | output of a source without a screen |
//! | [`terminal`] | the loop over keys, time and screen |

#[cfg(feature = "program")]
pub mod device;
pub mod guard;
#[cfg(feature = "program")]
pub mod keep;
pub mod lines;
pub mod model;
#[cfg(feature = "program")]
pub mod offer;
#[cfg(feature = "program")]
pub mod plain;
#[cfg(feature = "program")]
pub mod port;
#[cfg(feature = "program")]
pub mod ports;
#[cfg(feature = "program")]
pub mod prompt;
#[cfg(feature = "program")]
pub mod pty;
#[cfg(feature = "program")]
pub mod screen;
#[cfg(feature = "program")]
pub mod session;
#[cfg(feature = "program")]
pub mod side;
#[cfg(feature = "program")]
pub mod talk;
#[cfg(feature = "program")]
pub mod terminal;
pub mod trouble;

#[cfg(all(test, feature = "program"))]
mod tests;

/// Milliseconds since the session began.
pub type Ms = u64;
