//! State of a scanner from the bytes of its report port.
//!
//! | module | what it is |
//! |---|---|
//! | [`model`] | state of the scanner, from its sentences; pure, time is an argument |
//! | [`guard`] | the last guard sweep, the interval of sweeps, a bar of the free distance |
//! | [`lines`] | the reader of the report: splits bytes of a port or a log into lines |
//! | [`log`] | the files of `live --record` and of any serial logger |
//! | [`arrived`] | what came since the last intact sentence, by kind |
//! | [`talker`] | devices that are recognised by a line of their text |
//! | [`trouble`] | explanations and remedies for faults of a port |

pub mod arrived;
pub mod guard;
pub mod lines;
pub mod log;
pub mod model;
pub mod talker;
pub mod trouble;

/// Milliseconds since the session began.
pub type Ms = u64;
