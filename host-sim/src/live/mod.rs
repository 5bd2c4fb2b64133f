//! `live`: the scanner as it reports, in a terminal.
//!
//! | module | what it is |
//! |---|---|
//! | [`model`] | what is known of the scanner, from its sentences; pure, time comes as an argument |
//! | [`guard`] | the last guard sweep, how often they come, the free distance as a bar |
//! | [`lines`] | bytes of the port into lines |
//! | [`trouble`] | what may be wrong with a port, in words, and what helps |
//! | [`offer`] | what is said of a command before it is sent |
//! | [`prompt`] | the command line and its history |
//! | [`screen`], [`side`] | the screen, drawn from the state; the side view on it |
//! | [`ports`] | the serial ports of this machine |
//! | [`port`] | the thread that reads and writes a port, and opens it again |
//! | [`pty`] | a pseudo-terminal in place of a port |
//! | [`talk`] | questions to a scanner and its answers: `settings`, `doctor` |
//! | [`device`] | a scanner on the host: what `--demo` shows |
//! | [`keep`] | what `--record` keeps |
//! | [`session`] | a source while it is watched: its state, the file of its lines, who gets its answers |
//! | [`plain`] | a source watched without a screen |
//! | [`terminal`] | keys, time and screen brought together |

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
