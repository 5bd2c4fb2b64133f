//! `live`: the scanner as it reports, in a terminal.
//!
//! | module | what it is |
//! |---|---|
//! | [`model`] | what is known of the scanner, from its sentences; pure, time comes as an argument |
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

pub mod device;
pub mod keep;
pub mod lines;
pub mod model;
pub mod offer;
pub mod plain;
pub mod port;
pub mod ports;
pub mod prompt;
pub mod pty;
pub mod screen;
pub mod session;
pub mod side;
pub mod talk;
pub mod terminal;
pub mod trouble;

#[cfg(test)]
mod tests;

/// Milliseconds since the session began.
pub type Ms = u64;
